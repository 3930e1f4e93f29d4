"""Gallas' pictures of beads: paths over a cycle, and places and velocities at its beginning."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator

from sim.base.errors import InputError, count_text
from sim.figures.caption import first_clause, velocity_text
from sim.figures.data import Drawing, FigureData
from sim.figures.plot import message_figure
from sim.figures.spheres import across_sides, draw_particles
from sim.figures.style import DOTTED, legend_above
from sim.parameters import NUMERICAL, BeltParameters, field_info
from sim.study.plot_contents import in_words

#: Inches per ⟨d⟩, the room that labels and legend take, and the width that a legend needs.
_SCALE, _LABELS, _ABOVE, _NARROWEST = 0.25, 0.75, 0.9, 4.6

#: Room (⟨d⟩) above the beads for the scale of the velocities.
_SCALE_ROOM = 2.0

OBSTACLE = "#e69f00"

#: Tallest cell that is shown (⟨d⟩).
TALLEST = 30.0


class PointParticles(NamedTuple):
    """A point and the particles of its first completed replicate."""

    row: Mapping[Hashable, Any]
    state: xr.Dataset


def select(data: FigureData) -> FigureData:
    """Narrow the points to the one of each protocol that differs from the paper the least.

    That is in the fewest parameters, numerical ones aside; the published protocol comes first.
    """
    rows = data.rows[data.rows["completed"] > 0]
    if rows.empty:
        return data
    usual = {row.name: row.default for row in field_info(BeltParameters).values()}
    differing = sum(rows[name] != usual[name] for name in usual if name not in NUMERICAL)
    nearest = differing.groupby(rows["protocol"]).idxmin().sort_index(ascending=False)
    return replace(data, rows=rows.loc[nearest])


def notes(data: FigureData) -> list[str]:
    """Return a sentence on what is drawn, and one on the point of each run for the details."""
    rows = data.rows[data.rows["completed"] > 0].to_dict("records")
    drawn = [f"{velocity_text(row)} ({row['protocol']} protocol, {row['regime']})" for row in rows]
    return [
        f"Drawn is the first replicate that completed; the mean velocity is {in_words(drawn)}.",
        *(
            f"{row['protocol'].capitalize()} protocol: point {row['point']}, "
            f"{row['completed']} replicates."
            for row in rows
        ),
    ]


def _with_particles(data: FigureData, *names: str) -> list[PointParticles]:
    """Return the selected points with their particles, of which the dataset has these arrays."""
    points = []
    for row in data.rows[data.rows["completed"] > 0].to_dict("records"):
        state = data.results.particles(row["point"])
        for name in names:
            if name not in state:
                raise InputError(f"{row['point']}: no {name} of the particles in the dataset")
        points.append(PointParticles(row, state))
    return points


def _cells(points: Sequence[PointParticles], top: float) -> tuple[Figure, list[Axes]]:
    """Return axes in ⟨d⟩ to scale, one below the other, of a period of the belt up to ``top``.

    Titles name the caveat of a point: an unstable time step makes other paths.
    """
    low, high = -max(row["amplitude"] for row, _ in points) - 0.7, min(top, TALLEST)
    number, width = len(points), max(row["width"] for row, _ in points)
    size = max(_NARROWEST, width * _SCALE + _LABELS), number * ((high - low) * _SCALE + _ABOVE)
    figure = Figure(figsize=size, layout="compressed")
    panels = figure.subplots(number, squeeze=False, sharex=True)[:, 0]
    for axes, (row, _) in zip(panels, points, strict=True):
        axes.set(xlim=(0, row["width"]), ylim=(low, high), aspect="equal")
        axes.grid(visible=False)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MultipleLocator(5))
        axes.set_ylabel("height z/⟨d⟩")
        steps = f"{row['protocol']} protocol, {row['steps_per_cycle']:g} steps a cycle"
        lines = [steps] * (number > 1) + [first_clause(row["caveat"])] * bool(row["caveat"])
        axes.set_title("\n".join(lines), size=8.5)
    panels[-1].set_xlabel("position along the belt x/⟨d⟩")
    return figure, list(panels)


def draw_obstacle(axes: Axes, row: Mapping[Any, Any]) -> None:
    """Draw the obstacle of a point, if any, at x = L/2, z = A_z."""
    if row["obstacle"] > 0:
        place = row["width"] / 2, row["amplitude"]
        look = {"facecolor": OBSTACLE, "edgecolor": "black", "linewidth": 0.8, "zorder": 3}
        axes.add_patch(Circle(place, row["obstacle"] / 2, **look))
        axes.plot([], [], "o", color=OBSTACLE, markeredgecolor="black", label="obstacle")


def _draw_belt(axes: Axes, row: Mapping[Any, Any], beads: np.ndarray) -> None:
    """Draw the belt and the obstacle, and count beads whose lowest height is above the picture."""
    draw_obstacle(axes, row)
    axes.axhline(0, color="black", linewidth=1.3, label="average position of the belt")
    if count := int((beads > axes.get_ylim()[1]).sum()):
        text = f"{count_text(count, 'bead')} above"
        axes.text(0.01, 0.985, text, transform=axes.transAxes, va="top", fontsize=8)


def _wrapped(x: np.ndarray, point: PointParticles) -> np.ndarray:
    """Return positions along the belt within its period [0, L), all in ⟨d⟩."""
    return np.mod(x, point.row["width"])


def _draw_paths(data: FigureData) -> Figure:
    """Draw the paths; what leaves the periodic cell on one side comes back on the other."""
    points = _with_particles(data, "path", "path_time")
    if not points:
        return message_figure("no point completed")
    paths = [_path(point) for point in points]
    figure, panels = _cells(points, max(path[..., 1].max() for path in paths) + 0.5)
    for axes, point, path in zip(panels, points, paths, strict=True):
        look: dict[str, Any] = {"color": "black", "markersize": 2.0, "markeredgewidth": 0}
        look |= {"rasterized": True, "label": "centre of a bead"}
        axes.plot(_wrapped(path[..., 0], point).ravel(), path[..., 1].ravel(), ".", **look)
        _draw_belt(axes, point.row, path[..., 1].min(axis=0))
    legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def _paths_table(data: FigureData) -> pd.DataFrame:
    # Positions along the belt are not wrapped.
    parts = []
    for point in _with_particles(data, "path", "path_time"):
        path = np.round(_path(point), 3)
        steps, beads, _ = path.shape
        time = np.round(point.state["path_time"].values.astype(float), 8)
        columns = {
            "protocol": point.row["protocol"],
            "bead": np.tile(np.arange(beads), steps),
            "time [s]": np.repeat(time, beads),
            "x [⟨d⟩]": path[..., 0].ravel(),
            "z [⟨d⟩]": path[..., 1].ravel(),
        }
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts) if parts else pd.DataFrame(columns=["protocol", "bead"])


def _path(point: PointParticles) -> np.ndarray:
    """Return the positions (S, N, 2) in ⟨d⟩."""
    return point.state["path"].values.astype(float) / point.row["diameter"]


def _draw_snapshots(data: FigureData) -> Figure:
    """Draw the beads; those that cross an end of the periodic cell are drawn at both ends."""
    points = _with_particles(data, "position", "particle_velocity", "radius")
    if not points:
        return message_figure("no point completed")
    tables = [_beads(point) for point in points]
    tops = [(beads["z [⟨d⟩]"] + beads["diameter [⟨d⟩]"] / 2).max() for beads in tables]
    figure, panels = _cells(points, max(tops) + _SCALE_ROOM)
    # The velocity (m/s) that one ⟨d⟩ stands for, round.
    squares = [beads[["v_x [m s-1]", "v_z [m s-1]"]].pow(2).sum(axis=1).mean() for beads in tables]
    speed = float(f"{max(squares) ** 0.5:.1g}") or 1.0
    for axes, point, beads in zip(panels, points, tables, strict=True):
        _draw_beads(axes, point.row["width"], beads, speed)
        _draw_scale(axes, speed)
        _draw_belt(axes, point.row, (beads["z [⟨d⟩]"] - beads["diameter [⟨d⟩]"] / 2).to_numpy())
        for sign, label in ((1, "its extreme positions"), (-1, None)):
            height = sign * point.row["amplitude"]
            axes.axhline(height, color="black", linewidth=1.3, linestyle=DOTTED, label=label)
    legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def _beads_table(data: FigureData) -> pd.DataFrame:
    points = _with_particles(data, "position", "particle_velocity", "radius")
    parts = [_beads(point) for point in points]
    return pd.concat(parts) if parts else pd.DataFrame(columns=["protocol", "bead"])


def _beads(point: PointParticles) -> pd.DataFrame:
    row, state = point
    place = state["position"].values.astype(float) / row["diameter"]
    velocity = state["particle_velocity"].values.astype(float)
    columns = {
        "protocol": row["protocol"],
        "bead": np.arange(len(place)),
        "diameter [⟨d⟩]": np.round(2 * state["radius"].values.astype(float) / row["diameter"], 5),
        "x [⟨d⟩]": np.round(_wrapped(place[:, 0], point), 5),
        "z [⟨d⟩]": np.round(place[:, 1], 5),
        "v_x [m s-1]": velocity[:, 0],
        "v_z [m s-1]": velocity[:, 1],
    }
    return pd.DataFrame(columns)


def _draw_beads(axes: Axes, width: float, beads: pd.DataFrame, speed: float) -> None:
    """Draw circles and velocities of all beads, and of their images that reach into the cell."""
    places = beads[["x [⟨d⟩]", "z [⟨d⟩]"]].to_numpy()
    steps = beads[["v_x [m s-1]", "v_z [m s-1]"]].to_numpy() / speed
    diameters = beads["diameter [⟨d⟩]"].to_numpy()
    # Velocities, too, are seen at both sides of the cell.
    index, x = across_sides(places[:, 0], diameters + 2 * np.abs(steps[:, 0]), width)
    seen = np.column_stack([x, places[index, 1]])
    edge: dict[str, Any] = {"edgecolors": "#666666", "linewidths": 0.6}
    grey = np.full((len(index), 4), 0.94)
    draw_particles(axes, seen, diameters[index], grey, **edge)
    sticks = np.stack([seen, seen + steps[index]], axis=1)
    axes.add_collection(LineCollection(list(sticks), color="#0072b2", linewidth=1.0))


def _draw_scale(axes: Axes, speed: float) -> None:
    right, top = axes.get_xlim()[1] - 0.5, axes.get_ylim()[1] - 0.8
    axes.plot([right - 1, right], [top, top], color="#0072b2", linewidth=1.6)
    axes.text(right - 1.2, top, f"{speed:g} m/s", ha="right", va="center", fontsize=8)


PATHS = Drawing(_draw_paths, _paths_table, notes, select)
SNAPSHOTS = Drawing(_draw_snapshots, _beads_table, notes, select)
