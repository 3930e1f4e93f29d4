"""Paths of the beads over one cycle, as in Gallas' Figs. 4, 7a and 7c."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.figures.belt_cell import cell, draw_belt, draw_obstacle, nothing, shown, wrapped
from sim.figures.style import place_legend
from sim.figures.summary import FigureData

LEAD = (
    "Paths of the beads during a single cycle of the vibration in the steady state, in the frame "
    "of the laboratory: the centre of each bead after every 50 of 2000 steps (every fortieth of "
    "the cycle, both ends included). The horizontal line is the average position of the belt; "
    "lengths are in mean diameters ⟨d⟩."
)

_COLUMNS = ("bead", "step of 40", "time [s]", "x [⟨d⟩]", "z [⟨d⟩]")


def draw(data: FigureData) -> Figure:
    """Draw the paths; what leaves the periodic cell on one side comes back on the other."""
    found = shown(data, "path", "path_time")
    if found is None:
        return nothing()
    row, state = found
    path = state["path"].values / row["diameter"]
    figure, axes = cell(row, path[..., 1].max() + 0.5)
    axes.plot(
        wrapped(path[..., 0], row).ravel(),
        path[..., 1].ravel(),
        ".",
        color="black",
        markersize=1.6,
        markeredgewidth=0,
        rasterized=True,
        label="centre of a bead",
    )
    draw_obstacle(axes, row)
    draw_belt(axes)
    place_legend(figure, axes)
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the paths: a row per bead and step, positions along the belt not wrapped."""
    found = shown(data, "path", "path_time")
    if found is None:
        return pd.DataFrame(columns=_COLUMNS)
    row, state = found
    path = np.round(state["path"].values.astype(float) / row["diameter"], 4)
    steps, beads, _ = path.shape
    time = np.repeat(state["path_time"].values.astype(float), beads)
    values = (
        np.tile(np.arange(beads), steps),
        np.repeat(np.arange(steps), beads),
        time,
        path[..., 0].ravel(),
        path[..., 1].ravel(),
    )
    return pd.DataFrame(dict(zip(_COLUMNS, values, strict=True)))
