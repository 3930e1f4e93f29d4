"""What Gallas' pictures of beads share: the flow that is shown, its cell, its belt."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator

from sim.base.errors import InputError
from sim.figures.caption import velocity_text
from sim.figures.data import FigureData
from sim.parameters import NUMERICAL, BeltParameters, field_info

#: Inches per ⟨d⟩ in one panel and in each of two, the room that labels and legend take, and the
#: width that a legend needs.
_SCALES = {1: 0.25, 2: 0.19}
_LABELS, _ABOVE, _NARROWEST = 0.75, 1.0, 4.6

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
    """Return a sentence for the caption on each run: its point, regime and mean velocity."""
    sentences = []
    for row in data.rows[data.rows["completed"] > 0].to_dict("records"):
        count = row["completed"]
        over = f"{count} replicates" if count > 1 else "this replicate"
        sentences.append(
            f"{row['protocol'].capitalize()} protocol: first replicate that completed of point "
            f"{row['point']}, regime {row['regime']}; the mean velocity of {over} is "
            f"{velocity_text(row)} (95 % interval)."
        )
    return sentences


def with_particles(data: FigureData, *names: str) -> list[PointParticles]:
    """Return the selected points with their particles, none where no replicate completed.

    Raises
    ------
    InputError
        When the dataset has not kept one of the arrays ``names`` of them.
    """
    points = []
    for row in data.rows[data.rows["completed"] > 0].to_dict("records"):
        state = data.results.particles(row["point"])
        for name in names:
            if name not in state:
                raise InputError(f"{row['point']}: no {name} of the particles in the dataset")
        points.append(PointParticles(row, state))
    return points


def cells(points: Sequence[PointParticles], top: float) -> tuple[Figure, list[Axes]]:
    """Return axes in ⟨d⟩ to scale, one per point, of a period of the belt up to ``top`` (⟨d⟩)."""
    if not points:
        figure = Figure(figsize=(5.6, 3.9), layout="constrained")
        figure.subplots().set_axis_off()
        return figure, []
    low, high = -max(row["amplitude"] for row, _ in points) - 0.7, min(top, TALLEST)
    widths = [row["width"] for row, _ in points]
    scale = _SCALES[len(points)]
    wide = max(_NARROWEST, sum(widths) * scale + _LABELS * len(points))
    figure = Figure(figsize=(wide, (high - low) * scale + _ABOVE), layout="compressed")
    panels = figure.subplots(1, len(points), squeeze=False, sharey=True, width_ratios=widths)[0]
    for axes, (row, _) in zip(panels, points, strict=True):
        axes.set(xlim=(0, row["width"]), ylim=(low, high), aspect="equal")
        axes.grid(visible=False)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MultipleLocator(5))
        axes.set_xlabel("position along the belt x (⟨d⟩)")
        if len(points) > 1:
            axes.set_title(f"{row['protocol']}, {row['steps_per_cycle']:g} steps a cycle", size=9)
    panels[0].set_ylabel("height z (⟨d⟩)")
    return figure, list(panels)


def draw_surroundings(axes: Axes, point: PointParticles) -> None:
    """Draw the average position of the belt, and the obstacle, if any, at x = L/2, z = A_z."""
    row = point.row
    if row["obstacle"] > 0:
        place = row["width"] / 2, row["amplitude"]
        look = {"facecolor": OBSTACLE, "edgecolor": "black", "linewidth": 0.8, "zorder": 3}
        axes.add_patch(Circle(place, row["obstacle"] / 2, **look))
        axes.plot([], [], "o", color=OBSTACLE, markeredgecolor="black", label="obstacle")
    axes.axhline(0, color="black", linewidth=1.3, label="average position of the belt")


def tell_beyond(axes: Axes, lowest: np.ndarray) -> None:
    """Write how many beads are above the picture, from the lowest height (⟨d⟩) of each."""
    count = int((lowest > axes.get_ylim()[1]).sum())
    if count:
        text = f"{count} bead{'s' if count > 1 else ''} above"
        axes.text(0.01, 0.985, text, transform=axes.transAxes, va="top", fontsize=8)


def wrapped(x: np.ndarray, point: PointParticles) -> np.ndarray:
    """Return positions along the belt within its period [0, L), all in ⟨d⟩."""
    return np.mod(x, point.row["width"])
