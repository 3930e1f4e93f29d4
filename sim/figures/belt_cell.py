"""What Gallas' pictures of beads share: the one flow that is shown, its cell and its belt."""

from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from sim.errors import InputError
from sim.figures.summary import FigureData
from sim.parameters import NUMERICAL, BeltParameters, field_info

#: Parameters that the captions of all pictures give.
NAMED = (
    "frequency",
    "vibration_angle",
    "amplitude",
    "damping",
    "shear_damping",
    "obstacle",
    "beads",
    "width",
    "steps_per_cycle",
    "transient",
    "average",
)

#: Inches per ⟨d⟩, and the margins (inches) that the axes need.
SCALE, MARGINS = 0.27, (0.9, 0.9)

#: Tallest cell that is shown (⟨d⟩).
TALLEST = 45.0

Row = Mapping[Hashable, Any]


def select(data: FigureData) -> FigureData:
    """Narrow the points to the one that is shown.

    Of those with a completed replicate it is the first that differs from the paper in the fewest
    parameters, numerical ones aside; it is thus one of the published protocol if there is any.
    """
    rows = data.rows[data.rows["completed"] > 0]
    if rows.empty:
        return data
    usual = {row.name: row.default for row in field_info(BeltParameters).values()}
    differing = sum(rows[name] != usual[name] for name in usual if name not in NUMERICAL)
    return replace(data, rows=rows.loc[[differing.idxmin()]])


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of the run that is shown."""
    sentences = []
    for row in data.rows[data.rows["completed"] > 0].itertuples():
        interval = f" ± {row.half_width:.2g} m/s" if np.isfinite(row.half_width) else " m/s"
        over = f"{row.completed} replicates" if row.completed > 1 else "this replicate"
        sentences.append(
            f"Shown is the first replicate that completed of point {row.point} ({row.protocol} "
            f"protocol, regime {row.regime}); the mean velocity of {over} is "
            f"{row.velocity:.3g}{interval} (95 % interval)."
        )
    return sentences


def shown(data: FigureData, *names: str) -> tuple[Row, xr.Dataset] | None:
    """Return the selected point and its particles, or nothing where no replicate completed.

    Raises
    ------
    InputError
        When the dataset has not kept one of the arrays ``names`` of them.
    """
    rows = data.rows[data.rows["completed"] > 0]
    if rows.empty:
        return None
    row = rows.iloc[0]
    state = data.results.particles(row["point"])
    for name in names:
        if name not in state:
            raise InputError(f"{row['point']}: no {name} of the particles in the dataset")
    return row, state


def cell(row: Row, top: float) -> tuple[Figure, Axes]:
    """Return axes in ⟨d⟩ to scale, of one period of the belt up to a height ``top`` (⟨d⟩)."""
    low, high = -row["amplitude"] - 0.7, min(top, TALLEST)
    size = row["width"] * SCALE + MARGINS[0], (high - low) * SCALE + MARGINS[1]
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=(0, row["width"]), ylim=(low, high), aspect="equal")
    axes.grid(visible=False)
    axes.set_xlabel("position along the belt x (⟨d⟩)")
    axes.set_ylabel("height z (⟨d⟩)")
    return figure, axes


def draw_belt(axes: Axes) -> None:
    """Draw the average position of the belt, which is also where a cycle begins."""
    axes.axhline(0, color="black", linewidth=1.3, label="average position of the belt")


def draw_obstacle(axes: Axes, row: Row) -> None:
    """Draw the obstacle, if there is one: a circle at x = L/2, z = A_z."""
    if row["obstacle"] > 0:
        place = row["width"] / 2, row["amplitude"]
        look = {"facecolor": "#e69f00", "edgecolor": "black", "linewidth": 0.8, "zorder": 3}
        axes.add_patch(Circle(place, row["obstacle"] / 2, label="obstacle", **look))


def wrapped(x: np.ndarray, row: Row) -> np.ndarray:
    """Return positions along the belt within its period [0, L), all in ⟨d⟩."""
    return np.mod(x, row["width"])


def nothing() -> Figure:
    """Return the figure of a point without a completed replicate."""
    figure = Figure(figsize=(5.6, 3.9), layout="constrained")
    figure.subplots().set_axis_off()
    return figure
