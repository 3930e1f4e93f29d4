"""A number of each point against a parameter, or against another number: a study's own plot.

Options of a figure: those of `sim.figures.plot`.
"""

from dataclasses import replace
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.bars import cuts, end_bars, mark_cut_bars
from sim.figures.beside import (
    beside_notes,
    draw_beside,
    set_run_ticks,
    values_beside,
    with_beside,
)
from sim.figures.caption import interval_sentence, quantity_notes, regime_sentence
from sim.figures.curves import draw_family
from sim.figures.data import FigureData, varying
from sim.figures.kind import Kind
from sim.figures.looks import Look
from sim.figures.plot import (
    Panels,
    empty_text,
    keys_of,
    label_axes,
    legend,
    look_of_all,
    lost_note,
    observable_label,
    observed,
    panels,
    parameter_label,
    set_log,
    width_of,
    without_note,
)
from sim.figures.quantity import Quantity, quantity_table
from sim.figures.style import CurveStyle
from sim.parameters import SYSTEMS
from sim.study.plot_words import described, plain
from sim.study.plottable import numbers

#: Points of print between two curves.
_PITCH = 2.4

#: Ticks at most in an inch of a horizontal axis of no parameter.
_PER_INCH = 1.8

#: Column of what is observed along the horizontal axis.
_ACROSS = "across"


def draw(data: FigureData) -> Figure:
    """Draw the curves; lines are interrupted at flows that accelerate."""
    spec, quantities = data.spec, _placed(data)
    figure, shown = panels(data)
    for axes, rows in shown:
        _draw_curves(data, axes, rows, quantities)
    lacking = [axis for axis, one in quantities.items() if one.value.isna().all()]
    empty_text(shown, quantities[(*lacking, "y")[0]].name)
    beside = draw_beside(data, shown)
    _set_axes(data, shown, quantities)
    for axes, _ in shown:
        mark_cut_bars(axes)
    named = numbers(spec.system)
    x = (
        parameter_label(spec.system, spec.axes[0])
        if spec.axes
        else observable_label(data, named[spec.options["second"]])
    )
    label_axes(figure, shown, x, observable_label(data, named[spec.options["show"]]))
    legend(figure, shown, beside)
    return figure


def _draw_curves(
    data: FigureData, axes: Axes, rows: pd.DataFrame, quantities: dict[str, Quantity]
) -> None:
    """Draw the curves of a panel; those along a parameter a little aside of each other."""
    known = rows[_known(quantities)[rows.index]]
    how: dict[str, Any] = {"pitch": _PITCH}
    if "x" in quantities:
        known = known.assign(**{_ACROSS: quantities["x"].value})
        how = {"spread": quantities["x"].half_width}
    along = data.spec.axes[0] if data.spec.axes else _ACROSS
    apart = known["regime"] == "accelerating"
    how |= {"look": _look(data), "unjoined": apart}
    draw_family(axes, known, quantities["y"], along, _keys(data), (), **how)


def _quantities(data: FigureData) -> dict[str, Quantity]:
    """Return what is observed, by the axis that it is on: y, and x where no parameter is there."""
    found = {"x": observed(data, "second")} if data.spec.options["second"] else {}
    return found | {"y": observed(data)}


def _known(quantities: dict[str, Quantity]) -> pd.Series:
    """Return of which points all is known."""
    return pd.concat([one.value.notna() for one in quantities.values()], axis=1).all(axis=1)


def _placed(data: FigureData) -> dict[str, Quantity]:
    """Return what is observed without what has no place on logarithmic axes: 0 and below."""
    return {
        axis: replace(one, value=one.value.where(one.value > 0))
        if axis in data.spec.options["log"]
        else one
        for axis, one in _quantities(data).items()
    }


def _keys(data: FigureData) -> list[str]:
    """Return the parameters that name curves.

    Where one number is shown against another, other parameters that are numbers vary along them.
    """
    fields, keys = SYSTEMS[data.spec.system].model_fields, keys_of(data)
    if not data.spec.options["second"]:
        return list(keys)
    asked = data.spec.options["curves"]
    return [name for name in keys if name in asked or fields[name].annotation not in (int, float)]


def _vary_along(data: FigureData) -> list[str]:
    """Return the parameters that vary along curves on which one number is shown against another."""
    named = list(dict.fromkeys([*_keys(data), *data.spec.curves]))
    curves = [curve for _, curve in data.rows.groupby(named)] if named else [data.rows]
    others = [name for name in SYSTEMS[data.spec.system].model_fields if name not in named]
    found = {name for curve in curves for name in varying(curve, others)}
    return [name for name in others if name in found]


def _look(data: FigureData) -> Look:
    """Return the look of the curves; what more than one parameter tells apart, no line joins."""
    look = look_of_all(data, _keys(data))
    if data.spec.axes or len(_vary_along(data)) == 1:
        return look

    def apart(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, label = look(names, index)
        return replace(style, dashes="none"), label

    return apart


def _set_axes(data: FigureData, shown: Panels, quantities: dict[str, Quantity]) -> None:
    """Set scales and limits, and a tick at each value of a parameter that was run."""
    log = data.spec.options["log"]
    chosen = _known(quantities) & (data.rows["completed"] > 0)
    for axes, _ in shown:
        for axis in log:
            set_log(axes, axis)
        axes.margins(x=0.07)
        axes.autoscale_view()
        for axis, one in quantities.items():
            if axis not in log:
                end_bars(axes, axis, pd.concat([one.value[chosen], values_beside(data, axis)]))
        if data.spec.axes:
            set_run_ticks(axes, data, data.spec.axes[0], width_of(shown))
        elif "x" not in log:
            axes.locator_params("x", nbins=round(_PER_INCH * width_of(shown)))


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    quantities = _quantities(data)
    found = quantity_table(data, list(quantities.values()))
    # Behind the name of the point.
    x = quantities["x"].label if "x" in quantities else found.columns[1]
    return with_beside(data, found, x, quantities["y"].label)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of error bars, lines and markers that there are."""
    spec, keys, quantities = data.spec, _keys(data), _placed(data)
    completed = data.rows[data.rows["completed"] > 0]
    shown = completed[_known(quantities)[completed.index]]
    known = int(_known(_quantities(data))[completed.index].sum())
    lost = known - len(shown)
    own = {
        axis: replace(one, value=one.value[shown.index], half_width=one.half_width[shown.index])
        for axis, one in quantities.items()
    }
    log = spec.options["log"]
    cut = any(
        cuts(one.value, one.half_width, values_beside(data, axis), logarithmic=axis in log)
        for axis, one in own.items()
    )
    along = [] if spec.axes else _vary_along(data)
    aside = spec.axes and keys and len(shown[keys].drop_duplicates()) > 1
    accelerating = len(along) < 2 and (shown["regime"] == "accelerating").any()
    return [
        *_notes_on_bars(replace(data, rows=shown), list(own.values())),
        *(["Error bars that end in a caret go on beyond the axes."] if cut else []),
        *(["Curves are drawn a little aside of each other."] if aside else []),
        *_notes_on_lines([described(spec.system, name) for name in along]),
        *(["Lines are interrupted at flows that accelerate."] if accelerating else []),
        *without_note(len(completed) - known),
        *lost_note(lost, "points" if lost > 1 else "point"),
        *beside_notes(data),
    ]


def _notes_on_bars(data: FigureData, quantities: list[Quantity]) -> list[str]:
    """Say what error bars and markers are; only velocities have intervals of one replicate."""
    others = [one for one in quantities if one.name != "velocity"]
    if len(others) == len(quantities):
        return quantity_notes(data, quantities)
    bare = [plain(one.name) for one in others if one.half_width.isna().any()]
    lacking = [f"No bar of the {name} where only one replicate is known." for name in bare]
    return [interval_sentence(data.rows), *lacking, regime_sentence(data.rows)]


def _notes_on_lines(along: list[str]) -> list[str]:
    """Say which points lines join where one number is shown against another."""
    if len(along) == 1:
        return [f"Lines join points that differ in {along[0]} alone, in the order of x."]
    named = " and ".join(filter(None, (", ".join(along[:-1]), *along[-1:])))
    return [f"Points that differ in {named} are not joined."] if along else []


KIND = Kind(draw, table=table, notes=notes)
