"""Measures of chute flows over their depth.

Options of a figure: ``quantities``, of each ``name`` in the dataset, ``label`` with its unit, the
parameter ``over`` which it is taken and, where there are several, ``entry`` in the legend and
``dashes``; ``axis``, label of the vertical axis; ``log``, the logarithmic axes, y alone;
``levels`` to compare with.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.bars import mark_cut_bars
from sim.figures.caption import measure_notes
from sim.figures.chute_curves import draw_curves, set_depth_axis, unjoined, varied
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import Look, look_of
from sim.figures.quantity import Quantity, measure_table, measures
from sim.figures.style import LEVEL, PATTERNS, CurveStyle, canvas, place_legend
from sim.study.figure_spec import FigureSpec


def draw(data: FigureData) -> Figure:
    """Draw the figure; curves of one measure stand aside of each other, those of several do not."""
    spec, quantities = data.spec, measures(data)
    figure, axes = canvas()
    for quantity, option in zip(quantities, spec.options["quantities"], strict=True):
        rows = data.rows[quantity.value.notna()]
        apart = unjoined(data.rows, quantity)
        if len(quantities) == 1:
            draw_curves(axes, rows, quantity, spec, apart)
        else:
            look = _look_of_one(spec, varied(rows, spec), option)
            draw_curves(axes, rows, quantity, spec, apart, look=look, pitch=0)
    for level in spec.options.get("levels", ()):
        axes.axhline(level, **LEVEL)
    set_depth_axis(axes, data.rows["depth"])
    if "y" in spec.options.get("log", ()):
        axes.set_yscale("log")
    else:
        _set_height(axes, quantities)
    axes.set_ylabel(spec.options["axis"])
    mark_cut_bars(axes)
    place_legend(figure, axes)
    return figure


def _look_of_one(spec: FigureSpec, keys: Sequence[str], option: dict[str, Any]) -> Look:
    """Return the look of the curves of one of several measures: its dashes, its name behind."""
    look = look_of(spec, keys)

    def look_of_quantity(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, entry = look(names, index)
        named = ", ".join(filter(None, (entry, option["entry"])))
        return replace(style, dashes=PATTERNS[option["dashes"]]), named

    return look_of_quantity


def _set_height(axes: Axes, quantities: list[Quantity]) -> None:
    """Begin the vertical axis at zero, and end it where intervals over two replicates may go on."""
    highest = max(quantity.value.max() for quantity in quantities)
    axes.set_ylim(0, min(axes.get_ylim()[1], 1.5 * highest) if highest > 0 else 1)


KIND = Kind(draw, table=measure_table, notes=measure_notes)
