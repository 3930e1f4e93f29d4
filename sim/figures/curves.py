"""Curves of an observable against a parameter or another observable, defined by a study file."""

from dataclasses import replace
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures import paper_curves
from sim.figures.axes import has_cut_bars, limit_axis, mark_cut_bars, set_log
from sim.figures.caption import bar_notes
from sim.figures.data import FigureData, Quantity, quantity_table, varying_parameters
from sim.figures.family import draw_family, name_bands
from sim.figures.fit import Fit, draw_fits, fit_columns, fit_curves, fit_notes
from sim.figures.plot import (
    Panels,
    append_foreign_data,
    curve_keys,
    draw_foreign_data,
    foreign_data_notes,
    foreign_values,
    label_axes,
    missing_value_note,
    nonpositive_note,
    observable_label,
    observed_quantity,
    panels,
    parameter_label,
    set_run_ticks,
    width_of,
    write_no_data,
)
from sim.figures.style import CurveStyle, Look, is_undecided
from sim.figures.variables import has_logarithmic_values, is_number, legend, shared_look
from sim.parameters import SYSTEMS
from sim.study.plot_contents import SCATTER_HINT, parameter_phrase
from sim.study.plottable import numbers

#: Shift between neighbouring curves, points of print.
_PITCH = 2.4

#: Widest shift between the first and the last curve, points of print.
_WIDEST = 10 * _PITCH

#: Most ticks per inch of a horizontal axis that shows an observable.
_TICKS_PER_INCH = 1.8

#: Column of the observable on the horizontal axis.
_OBSERVED_X = "across"


def select(data: FigureData) -> FigureData:
    """Return the data with the points to draw."""
    return paper_curves.select(data) if data.spec.paper else data


def draw(data: FigureData) -> Figure:
    """Draw the curves."""
    if data.spec.paper:
        return paper_curves.draw(data)
    spec, quantities = data.spec, _drawable_quantities(data)
    figure, shown = panels(data)
    for axes, rows in shown:
        _draw_curves(data, axes, rows, quantities)
    empty_axes = [axis for axis, quantity in quantities.items() if quantity.value.isna().all()]
    write_no_data(shown, quantities[(*empty_axes, "y")[0]].name)
    foreign = draw_foreign_data(data, shown)
    _set_axes(data, shown, quantities)
    for axes, _ in shown:
        mark_cut_bars(axes)
    by_name = numbers(spec.system)
    x = (
        parameter_label(spec.system, spec.axes[0])
        if spec.axes
        else observable_label(data, by_name[spec.second])
    )
    label_axes(figure, shown, x, observable_label(data, by_name[spec.show]))
    legend(data, figure, shown, _keys(data), foreign)
    if spec.scattered:
        figure.suptitle(_hint(len(data.rows)), fontsize=9)
    return figure


def _draw_curves(
    data: FigureData, axes: Axes, rows: pd.DataFrame, quantities: dict[str, Quantity]
) -> None:
    """Draw the curves of a panel; curves along a parameter are shifted against each other."""
    points = rows[_has_all_values(quantities)[rows.index]]
    number = max(1, len(points[_keys(data)].drop_duplicates()))
    options: dict[str, Any] = {"pitch": min(_PITCH, _WIDEST / number)}
    if "x" in quantities:
        points = points.assign(**{_OBSERVED_X: quantities["x"].value})
        options = {"spread": quantities["x"].half_width}
    along = data.spec.axes[0] if data.spec.axes else _OBSERVED_X
    draw_family(axes, points, quantities["y"], along, _keys(data), (), look=_look(data), **options)
    draw_fits(axes, _fits(data, rows, quantities), _look(data))


def _fits(data: FigureData, rows: pd.DataFrame, quantities: dict[str, Quantity]) -> list[Fit]:
    """Return the fits to the curves of some points; empty for a plot without ``fit``."""
    if not data.spec.fit:
        return []
    points = rows[_has_all_values(quantities)[rows.index]]
    if "x" in quantities:
        points = points.assign(**{_OBSERVED_X: quantities["x"].value})
    keys = list(dict.fromkeys([*_keys(data), *data.spec.curves]))
    along = data.spec.axes[0] if data.spec.axes else _OBSERVED_X
    return fit_curves(data.spec.fit, points, quantities["y"], along, keys)


def _quantities(data: FigureData) -> dict[str, Quantity]:
    """Return the observables by axis: ``y``, and ``x`` where no parameter is there."""
    x_quantity = {"x": observed_quantity(data, "second")} if data.spec.second else {}
    return x_quantity | {"y": observed_quantity(data)}


def _has_all_values(quantities: dict[str, Quantity]) -> pd.Series:
    """Return for each point whether all quantities have a value."""
    return pd.concat([quantity.value.notna() for quantity in quantities.values()], axis=1).all(
        axis=1
    )


def _drawable_quantities(data: FigureData) -> dict[str, Quantity]:
    """Return the observables by axis, with values ≤ 0 dropped on logarithmic axes."""
    return {
        axis: replace(quantity, value=quantity.value.where(quantity.value > 0))
        if axis in data.spec.log
        else quantity
        for axis, quantity in _quantities(data).items()
    }


def _keys(data: FigureData) -> list[str]:
    """Return the parameters that name curves.

    With an observable on the x axis, numerical parameters that are not requested vary along curves.
    Points of a design have no curves.
    """
    spec, keys = data.spec, curve_keys(data)
    if spec.scattered:
        return []
    if not spec.second:
        return list(keys)
    return [name for name in keys if name in spec.by or not is_number(spec.system, name)]


def _parameters_along(data: FigureData) -> list[str]:
    """Return the parameters that vary along the curves of one observable against another."""
    named = list(dict.fromkeys([*_keys(data), *data.spec.curves]))
    curves = [curve for _, curve in data.rows.groupby(named)] if named else [data.rows]
    shown = {*named, *data.spec.axes}
    others = [name for name in SYSTEMS[data.spec.system].model_fields if name not in shown]
    varied = {name for curve in curves for name in varying_parameters(curve, others)}
    return [name for name in others if name in varied]


def _look(data: FigureData) -> Look:
    """Return the look of the curves; lines need exactly one parameter that varies along them.

    A fitted line takes the place of the one that joins points.
    """
    look = shared_look(data, _keys(data))
    is_joined = data.spec.axes or len(_parameters_along(data)) == 1
    if is_joined and not (data.spec.scattered or data.spec.fit):
        return look

    def unjoined_look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, label = look(names, index)
        return replace(style, dashes="none"), label

    return unjoined_look


def _set_axes(data: FigureData, shown: Panels, quantities: dict[str, Quantity]) -> None:
    """Set scales and limits, and put a tick at each value of the parameter that was run."""
    log = set(data.spec.log)
    if any(has_logarithmic_values(data.rows[name]) for name in data.spec.axes[:1]):
        log.add("x")
    chosen = _has_all_values(quantities) & (data.rows["completed"] > 0)
    for axes, _ in shown:
        for axis in log:
            set_log(axes, axis)
        axes.margins(x=0.07)
        axes.autoscale_view()
        for axis, quantity in quantities.items():
            if axis not in log:
                shown_values = quantity.value[chosen], quantity.half_width[chosen]
                limit_axis(axes, axis, *shown_values, foreign_values(data, axis))
        if data.spec.axes:
            set_run_ticks(axes, data, data.spec.axes[0], width_of(shown))
        elif "x" not in log:
            axes.locator_params("x", nbins=round(_TICKS_PER_INCH * width_of(shown)))


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    if data.spec.paper:
        return paper_curves.table(data)
    quantities = _quantities(data)
    rows = quantity_table(data, list(quantities.values()))
    rows = rows.assign(**fit_columns(data, _fits(data, data.rows, _drawable_quantities(data))))
    # The parameter on x follows the id of the point.
    x = quantities["x"].label if "x" in quantities else rows.columns[1]
    return append_foreign_data(data, rows, x, quantities["y"].label)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on error bars, lines, markers and omitted points."""
    if data.spec.paper:
        return paper_curves.notes(data)
    spec, keys, quantities = data.spec, _keys(data), _drawable_quantities(data)
    completed = data.rows[data.rows["completed"] > 0]
    shown = completed[_has_all_values(quantities)[completed.index]]
    with_values = int(_has_all_values(_quantities(data))[completed.index].sum())
    omitted = with_values - len(shown)
    shown_quantities = {
        axis: replace(
            quantity, value=quantity.value[shown.index], half_width=quantity.half_width[shown.index]
        )
        for axis, quantity in quantities.items()
    }
    log = spec.log
    is_cut = any(
        has_cut_bars(
            quantity.value, quantity.half_width, foreign_values(data, axis), logarithmic=axis in log
        )
        for axis, quantity in shown_quantities.items()
    )
    fits = _fits(data, completed, quantities)
    is_loose = (spec.axes and not spec.scattered) or fits
    along = [] if is_loose else _parameters_along(data)
    bars = bar_notes(data, shown, list(shown_quantities.values()))
    is_lined = spec.axes and not (fits or spec.scattered)
    aside = spec.axes and keys and len(shown[keys].drop_duplicates()) > 1
    # Of what is neither steady nor too short to tell.
    has_open = ((shown["regime"] != "steady") & ~is_undecided(shown)).any()
    interrupted = len(along) < 2 and not fits and has_open
    return [
        *(name_bands(bars, shown[spec.axes[0]]) if is_lined else bars),
        *([f"{_hint(len(data.rows))}."] if spec.scattered else []),
        *(["Error bars that end in a caret go on beyond the axes."] if is_cut else []),
        *(["Curves are drawn a little aside of each other."] if aside else []),
        *_notes_on_lines([parameter_phrase(spec.system, name) for name in along]),
        *(["Lines are interrupted at open markers."] if interrupted else []),
        *fit_notes(data, fits),
        *missing_value_note(len(completed) - with_values),
        *nonpositive_note(omitted, "points" if omitted > 1 else "point"),
        *foreign_data_notes(data),
    ]


def _hint(count: int) -> str:
    """Return what a plot of curves says that has points of a design."""
    return f"{count} points, hardly two of them on one curve; {SCATTER_HINT}"


def _notes_on_lines(along: list[str]) -> list[str]:
    """Return a sentence on the points that lines join, given the parameters along curves."""
    if len(along) == 1:
        return [f"Lines join points that differ in {along[0]} alone, in the order of x."]
    named = " and ".join(filter(None, (", ".join(along[:-1]), *along[-1:])))
    return [f"Points that differ in {named} are not joined."] if along else []
