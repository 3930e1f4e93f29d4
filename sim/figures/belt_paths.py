"""Paths of the beads over one cycle, as in Gallas' Figs. 4, 7a and 7c."""

import numpy as np
import pandas as pd
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
from sim.figures.style import place_legend


def draw(data: FigureData) -> Figure:
    """Draw the paths; what leaves the periodic cell on one side comes back on the other."""
    points = with_particles(data, "path", "path_time")
    paths = [_path(point) for point in points]
    figure, panels = cells(points, max((path[..., 1].max() for path in paths), default=0) + 0.5)
    for axes, point, path in zip(panels, points, paths, strict=True):
        axes.plot(
            wrapped(path[..., 0], point).ravel(),
            path[..., 1].ravel(),
            ".",
            color="black",
            markersize=2.0,
            markeredgewidth=0,
            rasterized=True,
            label="centre of a bead",
        )
        tell_beyond(axes, path[..., 1].min(axis=0))
        draw_surroundings(axes, point)
    if panels:
        place_legend(figure, panels[0])
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the paths: a row per bead and time, positions along the belt not wrapped."""
    parts = []
    for point in with_particles(data, "path", "path_time"):
        path = np.round(_path(point), 3)
        steps, beads, _ = path.shape
        columns = {
            "protocol": point.row["protocol"],
            "bead": np.tile(np.arange(beads), steps),
            "time [s]": np.repeat(
                np.round(point.state["path_time"].values.astype(float), 8), beads
            ),
            "x [⟨d⟩]": path[..., 0].ravel(),
            "z [⟨d⟩]": path[..., 1].ravel(),
        }
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts) if parts else pd.DataFrame(columns=["protocol", "bead"])


def _path(point: PointParticles) -> np.ndarray:
    """Return the positions (S, N, 2) in ⟨d⟩."""
    return point.state["path"].values.astype(float) / point.row["diameter"]


KIND = Kind(draw, table=table, notes=notes, select=select)
