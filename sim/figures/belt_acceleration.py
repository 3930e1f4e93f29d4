"""Transport velocity over the belt's against the acceleration of the belt, near the onset.

Options of a figure: those of `sim.figures.looks`.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.figures.curves import draw_family
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import look_of
from sim.figures.quantity import Quantity, quantity_table
from sim.figures.style import LEVEL, canvas, place_legend
from sim.measures.belt import speed_along_x
from sim.parameters import BeltParameters

#: Largest acceleration drawn (g): well within the flow.
_LARGEST = 3.0


def select(data: FigureData) -> FigureData:
    """Return the points near the onset, the belt's in the column ``acceleration_ratio`` (g)."""
    rows = data.rows
    vertical = rows["amplitude"] * rows["diameter"]
    rate = 2 * np.pi * rows["frequency"]
    rows = rows.assign(acceleration_ratio=rate**2 * vertical / rows["gravity"])
    return replace(data, rows=rows[rows["acceleration_ratio"] <= _LARGEST])


def relative_velocity(rows: pd.DataFrame) -> Quantity:
    """Return the transport velocity over the amplitude of the belt's along x."""
    along = speed_along_x(rows)
    return Quantity(
        "relative_velocity",
        "velocity over the belt's along x [1]",
        rows["velocity"] / along,
        rows["half_width"] / along,
    )


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows, spec = data.rows, data.spec
    figure, axes = canvas()
    names = tuple(name for name in BeltParameters.model_fields if name != "frequency")
    quantity, look = relative_velocity(rows), look_of(spec)
    draw_family(axes, rows, quantity, "acceleration_ratio", spec.curves, names, look=look)
    axes.axvline(1, **LEVEL)
    for level in spec.options["levels"]:
        axes.axhline(level, **LEVEL)
    axes.set_xlabel("acceleration of the belt Γ = $4π^2 f^2 A_z/g$")
    axes.set_ylabel("$V_x / (A_x 2πf)$")
    place_legend(figure, axes)
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    along = {"acceleration of the belt [g]": data.rows["acceleration_ratio"]}
    return quantity_table(data, [relative_velocity(data.rows)], along)


KIND = Kind(draw, table=table, select=select)
