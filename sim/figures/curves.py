"""Curves of observables against a parameter or another observable, of studies and of papers."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.caption import not_drawn, point_notes
from sim.figures.data import (
    FigureData,
    Quantity,
    measured_replicates,
    quantities,
    quantity_table,
    varying_parameters,
    velocity_table,
)
from sim.figures.family import APART, X_HALF, Y_HALF, X, Y, draw_family
from sim.figures.fit import Fit, draw_fits, fit_columns, fit_curves, fit_notes
from sim.figures.plot import (
    append_foreign_data,
    curve_keys,
    draw_foreign_data,
    foreign_values,
    given_labels,
    label_axes,
    mark_runs,
    observed_quantity,
    panels,
    replicate_values,
    write_no_data,
)
from sim.figures.style import (
    LEVEL,
    PATTERNS,
    CurveStyle,
    Look,
    limit_axis,
    look_of,
    set_log,
    set_plain_ticks,
)
from sim.figures.variables import is_number, legend, shared_look
from sim.measures.belt import speed_along_x
from sim.parameters import SYSTEMS
from sim.study.figure_spec import Measure
from sim.study.plot_contents import SCATTER_HINT, in_words, parameter_phrase
from sim.study.plottable import numbers

#: Largest acceleration of the belt that is drawn (g): well within the flow.
_LARGEST = 3.0

#: Column of the acceleration of the belt (g).
_ACCELERATION = "acceleration_ratio"


def select(data: FigureData) -> FigureData:
    """Return the points to draw; of a relative figure those near the onset of transport."""
    if not data.spec.relative:
        return data
    rows = data.rows
    rate, vertical = 2 * np.pi * rows["frequency"], rows["amplitude"] * rows["diameter"]
    rows = rows.assign(**{_ACCELERATION: rate**2 * vertical / rows["gravity"]})
    return replace(data, rows=rows[rows[_ACCELERATION] <= _LARGEST])


def draw(data: FigureData) -> Figure:
    """Draw the curves."""
    drawable = _drawable_quantities(data)
    figure, shown = panels(data)
    for axes, rows in shown:
        _draw_curves(data, axes, rows, drawable)
    empty = [one for one in drawable.values() if one.value.isna().all()]
    write_no_data(shown, [*empty, drawable["y"]][0].name)
    foreign = draw_foreign_data(data, shown)
    for axes, _ in shown:
        _set_axes(data, axes, drawable)
        _draw_levels(data, axes)
    label_axes(figure, shown, *given_labels(data))
    legend(data, figure, shown, _keys(data), foreign)
    if data.spec.scattered:
        figure.suptitle(_hint(len(data.rows)), fontsize=9)
    return figure


def _draw_curves(
    data: FigureData, axes: Axes, rows: pd.DataFrame, drawable: dict[str, Quantity]
) -> None:
    points, spec = _points(data, rows, drawable), data.spec
    measures: Sequence[Measure | None] = spec.quantities or [None]
    on_y = [quantity for axis, quantity in drawable.items() if axis != "x"]
    for one, measure in zip(on_y, measures, strict=True):
        columns = {Y: one.value, Y_HALF: one.half_width}
        columns[APART] = _replicates_apart(data, one, measure)
        drawn = points[points["completed"] > 0].assign(**columns)
        draw_family(axes, drawn, _keys(data), _look(data, measure), joins_open=spec.joins_open)
        if measure and measure.dashes and not measure.colour:
            # Dashes alone tell the measures of a curve apart.
            dashes: dict[str, Any] = {"linestyle": PATTERNS[measure.dashes]}
            axes.plot([], [], color="#666666", label=measure.entry, **dashes)
    draw_fits(axes, _fits(data, rows, drawable), _look(data))


def _replicates_apart(data: FigureData, one: Quantity, measure: Measure | None) -> pd.Series:
    """Return the replicates of points whose interval is too wide for a mean, by point."""
    rows, widest = data.rows, data.spec.widest
    too_wide = one.half_width > widest * one.value.abs()
    if not (widest and too_wide.any()):
        return pd.Series(None, rows.index, object)
    if data.spec.relative:
        velocities = measured_replicates(data, Measure(name="velocity", label=one.label))
        values = [each / speed for each, speed in zip(velocities, speed_along_x(rows), strict=True)]
    elif measure:
        values = measured_replicates(data, measure)
    else:
        values = replicate_values(data, numbers(data.spec.system)[one.name])
    return pd.Series(values, rows.index).where(too_wide, None)


def _along(data: FigureData) -> str:
    if data.spec.relative:
        return _ACCELERATION
    return data.spec.axes[0] if data.spec.axes else X


def _draw_levels(data: FigureData, axes: Axes) -> None:
    """Draw what values are compared with, and velocities in natural units at the right."""
    spec, rows = data.spec, data.rows
    for level in spec.levels:
        axes.axhline(level, **LEVEL)
    if spec.level:
        axes.plot([], [], label=spec.level, **LEVEL)
    if spec.relative:
        axes.axvline(1, **LEVEL)
    if "right" in spec.labels and spec.units == "si":
        unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
        functions = (lambda v: np.divide(v, unit), lambda v: np.multiply(v, unit))
        right = axes.secondary_yaxis("right", functions=functions)
        if axes.get_yscale() == "log":
            set_plain_ticks(right.yaxis)
        right.set_ylabel(spec.labels["right"])
        axes.spines["right"].set_visible(True)


def _points(data: FigureData, rows: pd.DataFrame, drawable: dict[str, Quantity]) -> pd.DataFrame:
    """Return the points that have all values, with their places along x."""
    points = rows[_has_all_values(drawable)[rows.index]]
    if "x" in drawable:
        return points.assign(**{X: drawable["x"].value, X_HALF: drawable["x"].half_width})
    return points.assign(**{X: points[_along(data)], X_HALF: np.nan})


def _fits(data: FigureData, rows: pd.DataFrame, drawable: dict[str, Quantity]) -> list[Fit]:
    if not data.spec.fit:
        return []
    keys = list(dict.fromkeys([*_keys(data), *data.spec.groups]))
    return fit_curves(data.spec.fit, _points(data, rows, drawable), drawable["y"], X, keys)


def quantities_by_axis(data: FigureData) -> dict[str, Quantity]:
    """Return what is shown by axis: ``y``, then ``y1`` and so on; ``x`` where no parameter is."""
    spec, rows = data.spec, data.rows
    across = {"x": observed_quantity(data, "second")} if spec.second else {}
    if spec.relative:
        of_belt, label = speed_along_x(rows), "velocity over the belt's along x [1]"
        value, half_width = rows["velocity"] / of_belt, rows["half_width"] / of_belt
        return {"y": Quantity("relative_velocity", label, value, half_width)}
    each = quantities(data) if spec.quantities else [observed_quantity(data)]
    return across | {f"y{number or ''}": one for number, one in enumerate(each)}


def _has_all_values(shown: dict[str, Quantity]) -> pd.Series:
    """Return for each point whether all quantities have a value."""
    return pd.concat([quantity.value.notna() for quantity in shown.values()], axis=1).all(axis=1)


def _drawable_quantities(data: FigureData) -> dict[str, Quantity]:
    """Return the observables by axis, with values ≤ 0 dropped on logarithmic axes."""
    return {
        axis: replace(quantity, value=quantity.value.where(quantity.value > 0))
        if axis[0] in data.spec.log
        else quantity
        for axis, quantity in quantities_by_axis(data).items()
    }


def _keys(data: FigureData) -> list[str]:
    """Return the parameters that name curves.

    With an observable on the x axis, numerical parameters that are not requested vary along curves.
    Points of a design have no curves.
    """
    spec, keys = data.spec, () if data.spec.scattered else curve_keys(data)
    is_named = {name: not is_number(spec.system, name) or name in spec.by for name in keys}
    return [name for name in keys if not spec.second or is_named[name]]


def _parameters_along(data: FigureData) -> list[str]:
    """Return the parameters that vary along the curves of one observable against another."""
    named = list(dict.fromkeys([*_keys(data), *data.spec.groups]))
    curves = [curve for _, curve in data.rows.groupby(named)] if named else [data.rows]
    shown = {*named, *data.spec.axes}
    others = [name for name in SYSTEMS[data.spec.system].model_fields if name not in shown]
    varied = {name for curve in curves for name in varying_parameters(curve, others)}
    return [name for name in others if name in varied]


def _look(data: FigureData, measure: Measure | None = None) -> Look:
    """Return the look of the curves; lines need exactly one parameter that varies along them.

    A fitted line takes the place of the one that joins points.
    """
    spec = data.spec
    if spec.styles or spec.entry or measure:
        is_named = spec.styles or spec.entry
        names = [name for name in spec.by if is_named or data.rows[name].nunique() > 1]
        return look_of(spec, names, measure)
    shared = shared_look(data, _keys(data))
    is_joined = bool(spec.axes) or len(_parameters_along(data)) == 1

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, label = shared(names, index)
        is_line = is_joined and not (spec.scattered or spec.fit)
        return style if is_line else replace(style, dashes="none"), label

    return look


def _set_axes(data: FigureData, axes: Axes, drawable: dict[str, Quantity]) -> None:
    """Set scales and limits, and put a tick at each value of the parameter that was run."""
    spec = data.spec
    chosen = _has_all_values(drawable) & (data.rows["completed"] > 0)
    for axis in spec.log:
        set_log(axes, axis)
    axes.margins(x=0.07)
    axes.autoscale_view()
    for along in {name[0] for name in drawable}:
        values = [one.value[chosen] for name, one in drawable.items() if name[0] == along]
        levels = pd.Series(spec.levels if along == "y" else [], dtype=float)
        limit_axis(axes, along, *values, levels, foreign_values(data, along))
    low, high = axes.get_ylim()
    if low < 0 < high:
        axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
    if spec.axes:
        mark_runs(axes, data.rows[_along(data)])


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    spec, shown = data.spec, quantities_by_axis(data)
    is_plain = not spec.fit and not spec.foreign
    if spec.paper and [*shown.values()][-1].name == "velocity" and is_plain:
        return velocity_table(data)
    relative = {"acceleration of the belt [g]": data.rows[_ACCELERATION]} if spec.relative else None
    rows = quantity_table(data, list(shown.values()), relative)
    rows = rows.assign(**fit_columns(data, _fits(data, data.rows, _drawable_quantities(data))))
    # The parameter on x follows the id of the point.
    x = shown["x"].label if "x" in shown else rows.columns[1]
    return append_foreign_data(data, rows, x, shown["y"].label)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on intervals, lines and what is not drawn."""
    spec, drawable = data.spec, _drawable_quantities(data)
    completed = data.rows["completed"] > 0
    shown = data.rows[completed & _has_all_values(drawable)]
    with_values = int((completed & _has_all_values(quantities_by_axis(data))).sum())
    fits = _fits(data, data.rows[completed], drawable)
    return [
        *point_notes(replace(data, rows=shown), list(drawable.values())),
        *([f"{_hint(len(data.rows))}."] if spec.scattered else []),
        *([] if fits else _notes_on_lines(data)),
        *fit_notes(data, fits),
        *not_drawn(int(completed.sum()) - with_values, "without a value"),
        *not_drawn(with_values - len(shown), "not above 0 on a logarithmic axis"),
    ]


def _hint(count: int) -> str:
    return f"{count} points, hardly two of them on one curve; {SCATTER_HINT}"


def _notes_on_lines(data: FigureData) -> list[str]:
    """Return a sentence on the points that lines join where these do not follow a parameter."""
    spec = data.spec
    names = [] if spec.axes and not spec.scattered else _parameters_along(data)
    named = in_words(parameter_phrase(spec.system, name) for name in names)
    if len(names) == 1:
        return [f"Lines join points that differ in {named} alone, in the order of x."]
    return [f"Points that differ in {named} are not joined."] if names else []
