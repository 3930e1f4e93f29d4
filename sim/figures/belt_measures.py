"""Measures of the belt's beads over a parameter.

Options of a figure: those of `sim.figures.looks`; ``quantities``, of each ``name`` in the dataset,
``label`` with its unit and, where there are several, ``entry`` in the legend and ``style``;
``axis``, label of the vertical axis; ``levels`` to compare with.
"""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.belt_curves import axis_label, draw_curves
from sim.figures.caption import measure_notes
from sim.figures.curves import draw_family
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import Look, look_of
from sim.figures.quantity import Quantity, measure_table, measures
from sim.figures.style import LEVEL, CurveStyle, canvas, catalogue_style, place_legend
from sim.parameters import BeltParameters
from sim.study.figure_spec import FigureSpec


def draw(data: FigureData) -> Figure:
    """Draw the figure: curves of one measure, or one curve of each of several."""
    spec, quantities = data.spec, measures(data)
    figure, axes = canvas()
    if len(quantities) == 1:
        (quantity,) = quantities
        draw_curves(axes, data.rows[quantity.value.notna()], quantity, spec)
    else:
        _draw_several(axes, data.rows, quantities, spec)
    for level in spec.options.get("levels", ()):
        axes.axhline(level, **LEVEL)
    axes.set_xlabel(axis_label(spec.axes[0]))
    axes.set_ylabel(spec.options["axis"])
    place_legend(figure, axes)
    return figure


def _draw_several(
    axes: Axes, rows: pd.DataFrame, quantities: list[Quantity], spec: FigureSpec
) -> None:
    names, keys = tuple(BeltParameters.model_fields), spec.curves or ("protocol",)
    for quantity, option in zip(quantities, spec.options["quantities"], strict=True):
        known, look = rows[quantity.value.notna()], _look_of_one(spec, option)
        draw_family(axes, known, quantity, spec.axes[0], keys, names, look=look)
    axes.set_ylim(bottom=0)


def _look_of_one(spec: FigureSpec, option: dict[str, Any]) -> Look:
    """Return the look of the curves of one of several measures."""
    look = look_of(spec)

    def look_of_quantity(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        _, entry = look(names, index)
        return catalogue_style(*option["style"]), ", ".join(filter(None, (option["entry"], entry)))

    return look_of_quantity


KIND = Kind(draw, table=measure_table, notes=measure_notes)
