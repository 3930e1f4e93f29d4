"""Beads at the beginning of a cycle, as in Gallas' Figs. 5 and 7b: circles with velocities."""

from math import floor, log10

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from sim.figures.belt_cell import Row, cell, draw_belt, draw_obstacle, nothing, shown, wrapped
from sim.figures.style import DOTTED, place_legend
from sim.figures.summary import FigureData

LEAD = (
    "Beads (circles, to scale) at the beginning of a cycle, at the end of the run. The linear "
    "segments that begin at their centres are their velocities in the frame of the laboratory, to "
    "the scale at the top right. Dotted lines are the highest and the lowest position of the belt, "
    "the solid line its average one, where it is at that moment; lengths are in mean diameters ⟨d⟩."
)

#: Room (⟨d⟩) above the beads for the scale of the velocities.
_ABOVE = 2.0

_COLUMNS = ("bead", "diameter [⟨d⟩]", "x [⟨d⟩]", "z [⟨d⟩]", "v_x [m s-1]", "v_z [m s-1]")


def draw(data: FigureData) -> Figure:
    """Draw the beads; those that cross an end of the periodic cell are drawn at both ends."""
    found = shown(data, "position", "particle_velocity", "radius")
    if found is None:
        return nothing()
    row, state = found
    beads = _beads(row, state)
    top = (beads["z [⟨d⟩]"] + beads["diameter [⟨d⟩]"] / 2).max() + _ABOVE
    figure, axes = cell(row, top)
    speed = round_speed(np.hypot(beads["v_x [m s-1]"], beads["v_z [m s-1]"]))
    _draw_beads(axes, row, beads, speed)
    _draw_scale(axes, speed)
    draw_obstacle(axes, row)
    draw_belt(axes)
    for height, label in ((row["amplitude"], "its extreme positions"), (-row["amplitude"], None)):
        axes.axhline(height, color="black", linewidth=1.3, linestyle=DOTTED, label=label)
    place_legend(figure, axes)
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the beads: a row for each, positions along the belt within the cell."""
    found = shown(data, "position", "particle_velocity", "radius")
    return pd.DataFrame(columns=_COLUMNS) if found is None else _beads(*found)


def round_speed(speeds: np.ndarray) -> float:
    """Return the velocity (m/s) that one ⟨d⟩ stands for: 1, 2 or 5 times a power of ten.

    It is the next one above the root mean square of the speeds.

    >>> round_speed(np.array([0.03]))
    0.05
    """
    mean_square = float(np.mean(np.square(speeds)))
    if not mean_square > 0:
        return 1.0
    power = 10.0 ** floor(log10(mean_square) / 2)
    return next(
        float(f"{digit * power:g}") for digit in (1, 2, 5, 10) if (digit * power) ** 2 > mean_square
    )


def _beads(row: Row, state: xr.Dataset) -> pd.DataFrame:
    place = state["position"].values.astype(float) / row["diameter"]
    velocity = state["particle_velocity"].values.astype(float)
    values = (
        np.arange(len(place)),
        np.round(2 * state["radius"].values.astype(float) / row["diameter"], 5),
        np.round(wrapped(place[:, 0], row), 5),
        np.round(place[:, 1], 5),
        velocity[:, 0],
        velocity[:, 1],
    )
    return pd.DataFrame(dict(zip(_COLUMNS, values, strict=True)))


def _draw_beads(axes: Axes, row: Row, beads: pd.DataFrame, speed: float) -> None:
    """Draw circles and velocities of all beads, and of their images that reach into the cell."""
    places = beads[["x [⟨d⟩]", "z [⟨d⟩]"]].to_numpy()
    ends = places + beads[["v_x [m s-1]", "v_z [m s-1]"]].to_numpy() / speed
    diameters = beads["diameter [⟨d⟩]"].to_numpy()
    for shift in (-row["width"], 0.0, row["width"]):
        left = np.minimum(places[:, 0] - diameters / 2, ends[:, 0]) + shift
        right = np.maximum(places[:, 0] + diameters / 2, ends[:, 0]) + shift
        seen = (right > 0) & (left < row["width"])
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
