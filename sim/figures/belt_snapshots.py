"""Beads at the beginning of a cycle, as in Gallas' Figs. 5 and 7b: circles with velocities."""

from math import floor, log10

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from sim.figures.belt_cell import (
    PointParticles,
    cells,
    draw_surroundings,
    notes,
    select,
    tell_beyond,
    with_particles,
    wrapped,
)
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.style import DOTTED, place_legend

#: Room (⟨d⟩) above the beads for the scale of the velocities.
_ABOVE = 2.0


def draw(data: FigureData) -> Figure:
    """Draw the beads; those that cross an end of the periodic cell are drawn at both ends."""
    points = with_particles(data, "position", "particle_velocity", "radius")
    tables = [_beads(point) for point in points]
    tops = [(beads["z [⟨d⟩]"] + beads["diameter [⟨d⟩]"] / 2).max() for beads in tables]
    figure, panels = cells(points, max(tops, default=0) + _ABOVE)
    speed = round_speed(max(map(_mean_square_speed, tables), default=0))
    for axes, point, beads in zip(panels, points, tables, strict=True):
        _draw_beads(axes, point.row["width"], beads, speed)
        _draw_scale(axes, speed)
        tell_beyond(axes, (beads["z [⟨d⟩]"] - beads["diameter [⟨d⟩]"] / 2).to_numpy())
        draw_surroundings(axes, point)
        for sign, label in ((1, "its extreme positions"), (-1, None)):
            height = sign * point.row["amplitude"]
            axes.axhline(height, color="black", linewidth=1.3, linestyle=DOTTED, label=label)
    if panels:
        place_legend(figure, panels[0])
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the beads: a row for each, positions along the belt within the cell."""
    points = with_particles(data, "position", "particle_velocity", "radius")
    parts = [_beads(point) for point in points]
    return pd.concat(parts) if parts else pd.DataFrame(columns=["protocol", "bead"])


def round_speed(mean_square: float) -> float:
    """Return the velocity (m/s) that one ⟨d⟩ stands for: 1, 2 or 5 times a power of ten.

    It is the next one above the root of the mean square (m²/s²) of the speeds.

    >>> round_speed(0.03**2)
    0.05
    """
    if not mean_square > 0:
        return 1.0
    power = 10.0 ** floor(log10(mean_square) / 2)
    return next(
        float(f"{digit * power:g}") for digit in (1, 2, 5, 10) if (digit * power) ** 2 > mean_square
    )


def _beads(point: PointParticles) -> pd.DataFrame:
    row, state = point
    place = state["position"].values.astype(float) / row["diameter"]
    velocity = state["particle_velocity"].values.astype(float)
    columns = {
        "protocol": row["protocol"],
        "bead": np.arange(len(place)),
        "diameter [⟨d⟩]": np.round(2 * state["radius"].values.astype(float) / row["diameter"], 5),
        "x [⟨d⟩]": np.round(wrapped(place[:, 0], point), 5),
        "z [⟨d⟩]": np.round(place[:, 1], 5),
        "v_x [m s-1]": velocity[:, 0],
        "v_z [m s-1]": velocity[:, 1],
    }
    return pd.DataFrame(columns)


def _mean_square_speed(beads: pd.DataFrame) -> float:
    return float((beads["v_x [m s-1]"] ** 2 + beads["v_z [m s-1]"] ** 2).mean())


def _draw_beads(axes: Axes, width: float, beads: pd.DataFrame, speed: float) -> None:
    """Draw circles and velocities of all beads, and of their images that reach into the cell."""
    places = beads[["x [⟨d⟩]", "z [⟨d⟩]"]].to_numpy()
    ends = places + beads[["v_x [m s-1]", "v_z [m s-1]"]].to_numpy() / speed
    diameters = beads["diameter [⟨d⟩]"].to_numpy()
    for shift in (-width, 0.0, width):
        left = np.minimum(places[:, 0] - diameters / 2, ends[:, 0]) + shift
        right = np.maximum(places[:, 0] + diameters / 2, ends[:, 0]) + shift
        seen = (right > 0) & (left < width)
        if not seen.any():
            continue
        axes.add_collection(
            EllipseCollection(
                diameters[seen],
                diameters[seen],
                np.zeros(seen.sum()),
                units="xy",
                offsets=places[seen] + (shift, 0),
                offset_transform=axes.transData,
                facecolor="#f0f0f0",
                edgecolor="#666666",
                linewidth=0.6,
            )
        )
        sticks = np.stack([places, ends], axis=1)[seen] + (shift, 0)
        axes.add_collection(LineCollection(sticks, color="#0072b2", linewidth=1.0))


def _draw_scale(axes: Axes, speed: float) -> None:
    """Draw at the top right how long a velocity is drawn."""
    right, top = axes.get_xlim()[1] - 0.5, axes.get_ylim()[1] - 0.8
    axes.plot([right - 1, right], [top, top], color="#0072b2", linewidth=1.6)
    axes.text(right - 1.2, top, f"{speed:g} m/s", ha="right", va="center", fontsize=8)


KIND = Kind(draw, table=table, notes=notes, select=select)
