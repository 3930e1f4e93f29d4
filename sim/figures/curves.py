"""Curves of observables against a parameter or another observable, of studies and of papers."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.axes import limit_axis, set_log, set_plain_ticks
from sim.figures.caption import not_drawn, point_notes
from sim.figures.data import (
    FigureData,
    Quantity,
    quantities,
    quantity_table,
    varying_parameters,
    velocity_table,
)
from sim.figures.family import draw_family
from sim.figures.fit import Fit, draw_fits, fit_columns, fit_curves, fit_notes
from sim.figures.plot import (
    Panels,
    append_foreign_data,
    curve_keys,
    draw_foreign_data,
    foreign_values,
    given_labels,
    label_axes,
    mark_runs,
    observed_quantity,
    panels,
    write_no_data,
)
from sim.figures.style import LEVEL, PATTERNS, CurveStyle, Look, look_of
from sim.figures.variables import is_number, legend, shared_look
from sim.measures.belt import speed_along_x
from sim.parameters import SYSTEMS
from sim.study.figure_spec import Measure
from sim.study.plot_contents import SCATTER_HINT, in_words, parameter_phrase

#: Largest acceleration of the belt that is drawn (g): well within the flow.
_LARGEST = 3.0

#: Shift between neighbouring curves, points of print.
_PITCH = 2.4

#: Widest shift between the first and the last curve, points of print.
_WIDEST = 10 * _PITCH

#: Column of the observable on the horizontal axis, and of the acceleration of the belt (g).
_OBSERVED_X, _ACCELERATION = "across", "acceleration_ratio"


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
    _set_axes(data, shown, drawable)
    for axes, _ in shown:
        _draw_levels(data, axes)
    label_axes(figure, shown, *given_labels(data))
    legend(data, figure, shown, _keys(data), foreign)
    if data.spec.scattered:
        figure.suptitle(_hint(len(data.rows)), fontsize=9)
    return figure


def _draw_curves(
    data: FigureData, axes: Axes, rows: pd.DataFrame, drawable: dict[str, Quantity]
) -> None:
    """Draw the curves of a panel; those of one quantity along a parameter stand side by side."""
    points, spec = rows[_has_all_values(drawable)[rows.index]], data.spec
    measures: Sequence[Measure | None] = spec.quantities or [None]
    number = max(1, len(points[_keys(data)].drop_duplicates()))
    options: dict[str, Any] = {"pitch": min(_PITCH, _WIDEST / number) * (len(measures) == 1)}
    if "x" in drawable:
        points = points.assign(**{_OBSERVED_X: drawable["x"].value})
        options = {"spread": drawable["x"].half_width}
    for one, measure in zip(_on_y(drawable), measures, strict=True):
        if spec.widest:
            options["unjoined"] = one.half_width > spec.widest * one.value.abs()
        look = _look(data, measure)
        draw_family(axes, points, one, _along(data), _keys(data), look=look, **options)
        if measure and measure.dashes and not measure.colour:
            # Dashes alone tell the measures of a curve apart.
            dashes: dict[str, Any] = {"linestyle": PATTERNS[measure.dashes]}
            axes.plot([], [], color="#666666", label=measure.entry, **dashes)
    draw_fits(axes, _fits(data, rows, drawable), _look(data))


def _along(data: FigureData) -> str:
    if data.spec.relative:
        return _ACCELERATION
    return data.spec.axes[0] if data.spec.axes else _OBSERVED_X


def _draw_levels(data: FigureData, axes: Axes) -> None:
    """Draw what values are compared with, and velocities in natural units at the right."""
    spec, rows = data.spec, data.rows
    for level in spec.levels:
        axes.axhline(level, **LEVEL)
    if spec.level:
        axes.plot([], [], label=spec.level, **LEVEL)
    if spec.relative:
        axes.axvline(1, **LEVEL)
    if "right" in spec.labels:
        unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
        right = axes.secondary_yaxis(
            "right", functions=(lambda v: np.divide(v, unit), lambda v: np.multiply(v, unit))
        )
        if axes.get_yscale() == "log":
            set_plain_ticks(right.yaxis)
        right.set_ylabel(spec.labels["right"])
        axes.spines["right"].set_visible(True)


def _fits(data: FigureData, rows: pd.DataFrame, drawable: dict[str, Quantity]) -> list[Fit]:
    if not data.spec.fit:
        return []
    points = rows[_has_all_values(drawable)[rows.index]]
    if "x" in drawable:
        points = points.assign(**{_OBSERVED_X: drawable["x"].value})
    keys = list(dict.fromkeys([*_keys(data), *data.spec.groups]))
    return fit_curves(data.spec.fit, points, drawable["y"], _along(data), keys)


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


def _on_y(shown: dict[str, Quantity]) -> list[Quantity]:
    return [quantity for axis, quantity in shown.items() if axis != "x"]


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
    spec, keys = data.spec, curve_keys(data)
    if spec.scattered:
        return []
    if not spec.second:
        return list(keys)
    return [name for name in keys if name in spec.by or not is_number(spec.system, name)]


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
    look = shared_look(data, _keys(data))
    is_joined = spec.axes or len(_parameters_along(data)) == 1
    if is_joined and not (spec.scattered or spec.fit):
        return look

    def unjoined_look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, label = look(names, index)
        return replace(style, dashes="none"), label

    return unjoined_look


def _set_axes(data: FigureData, shown: Panels, drawable: dict[str, Quantity]) -> None:
    """Set scales and limits, and put a tick at each value of the parameter that was run."""
    spec, log = data.spec, data.spec.log
    chosen = _has_all_values(drawable) & (data.rows["completed"] > 0)
    for axes, _ in shown:
        for one in log:
            set_log(axes, one)
        axes.margins(x=0.07)
        axes.autoscale_view()
        for axis in {name[0] for name in drawable}:
            limits = _limits(data, drawable, axis, chosen)
            limit_axis(axes, axis, *limits, logarithmic=axis in log)
        low, high = axes.get_ylim()
        if low < 0 < high:
            axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
        if spec.axes:
            mark_runs(axes, data.rows[_along(data)])


def _limits(
    data: FigureData, drawable: dict[str, Quantity], axis: str, chosen: pd.Series
) -> tuple[pd.Series, pd.Series, pd.Series]:
    each = [quantity for name, quantity in drawable.items() if name[0] == axis]
    others = [foreign_values(data, axis)]
    if axis == "y":
        others.append(pd.Series(data.spec.levels, dtype=float))
    return (
        pd.concat([one.value[chosen] for one in each], ignore_index=True),
        pd.concat([one.half_width[chosen] for one in each], ignore_index=True),
        pd.concat(others, ignore_index=True),
    )


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    spec, shown = data.spec, quantities_by_axis(data)
    if spec.paper and [*shown.values()][-1].name == "velocity" and not spec.fit:
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
    chosen = completed & _has_all_values(drawable)
    with_values = int((completed & _has_all_values(quantities_by_axis(data))).sum())
    fits = _fits(data, data.rows[completed], drawable)
    keys, shown = _keys(data), data.rows[chosen]
    is_aside = spec.axes and not spec.quantities and keys and len(shown[keys].drop_duplicates()) > 1
    return [
        *point_notes(replace(data, rows=shown), list(drawable.values())),
        *([f"{_hint(len(data.rows))}."] if spec.scattered else []),
        *(["Curves stand a little aside of each other."] if is_aside else []),
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
