"""Replicates of each point: distribution, time series, and how likely a curve of them rises."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.errors import InputError
from sim.base.seals import checked_read
from sim.base.statistics import MANY, share_of_rises, student
from sim.engine.stored_run import RunFile, require_all
from sim.figures.caption import label_with_unit, not_drawn, unit_of
from sim.figures.data import Drawing, FigureData, split_curves
from sim.figures.plot import (
    above_zero,
    curve_keys,
    label_axes,
    named_columns,
    observable_label,
    panels,
    parameter_label,
    replicate_values,
    rows_of_points,
    scale_of_point,
    wrap_label,
    write_no_data,
)
from sim.figures.style import LEVEL, PALE, set_log
from sim.figures.variables import groups, legend, shared_look
from sim.parameters import SYSTEMS, amounts
from sim.study.plottable import numbers, series

#: Share of the room of an x value that its curves fill, and share of that over which dots spread.
_FILLED_SHARE, _SPREAD_SHARE = 0.7, 0.6


def _draw_distribution(data: FigureData) -> Figure:
    """Draw a dot per replicate and a bar at the median; x values are equally spaced."""
    spec = data.spec
    along, observable = spec.axes[0], numbers(spec.system)[spec.show]
    values = pd.Series(replicate_values(data, observable), data.rows.index)
    figure, shown = panels(data)
    places = {value: place for place, value in enumerate(sorted(set(data.rows[along])))}
    for axes, rows in shown:
        _draw_replicates(axes, data, rows, values, places)
        axes.set_xticks(list(places.values()), [f"{value:g}" for value in places])
        if len(places) > 8:
            axes.tick_params(axis="x", labelrotation=90)
        axes.set_xlim(-0.6, len(places) - 0.4)
        axes.grid(visible=False, axis="x")
        if "y" in spec.log:
            set_log(axes, "y")
    label_axes(
        figure, shown, parameter_label(spec.system, along), observable_label(data, observable)
    )
    write_no_data(shown, observable.name)
    legend(data, figure, shown, curve_keys(data))
    return figure


def _draw_replicates(
    axes: Axes, data: FigureData, rows: pd.DataFrame, values: pd.Series, places: dict[float, int]
) -> None:
    """Draw the replicates of points, curve next to curve at each x value.

    The bar is at the median of all replicates, including those that a logarithmic axis omits.
    """
    keys = list(curve_keys(data))
    look = shared_look(data, keys)
    curves = [names for names, _ in data.rows.groupby(keys)] if keys else [()]
    width = _FILLED_SHARE / len(curves)
    for index, row in rows.iterrows():
        key = tuple(row[name] for name in keys)
        style, label = look(dict(zip(keys, key, strict=True)), 0)
        place = curves.index(key) - (len(curves) - 1) / 2
        middle = places[row[data.spec.axes[0]]] + width * place
        replicates = np.sort(values[index])
        if not replicates.size:
            continue
        aside = width * _SPREAD_SHARE * (np.arange(replicates.size) * 0.618 % 1 - 0.5)
        dots: dict[str, Any] = {"color": style.colour, "alpha": 2 * PALE, "markersize": 3.5}
        axes.plot(middle + aside, replicates, style.marker, label=label, zorder=3, **dots)
        ends = [middle - 0.4 * width, middle + 0.4 * width]
        axes.plot(ends, [np.median(replicates)] * 2, color=style.colour, linewidth=1.8, zorder=4)


def _distribution_table(data: FigureData) -> pd.DataFrame:
    spec, observable = data.spec, numbers(data.spec.system)[data.spec.show]
    unit = unit_of(observable.unit, spec.units, spec.system) or "1"
    rows = pd.DataFrame(named_columns(data, data.rows))
    rows["regime"] = data.rows["regime"]
    rows[f"{observable.name} [{unit}]"] = pd.Series(
        replicate_values(data, observable), data.rows.index
    )
    return rows.explode(f"{observable.name} [{unit}]")


def _distribution_notes(data: FigureData) -> list[str]:
    completed = replace(data, rows=data.rows[data.rows["completed"] > 0])
    values = replicate_values(completed, numbers(data.spec.system)[data.spec.show])
    missing = sum(not one.size for one in values)
    omitted = int(np.isnan(above_zero(data, "y", np.concatenate([np.zeros(0), *values]))).sum())
    return [
        "A dot per replicate, spread sideways; bars: medians. x is not to scale.",
        *not_drawn(missing, "without a value"),
        *not_drawn(omitted, "replicates not above 0 on a logarithmic axis"),
    ]


# How likely a curve rises that has one run per point: any choice of one replicate of each.

#: Columns of the data: probability and its interval.
_CHANCE = "probability [1]", "interval, low [1]", "interval, high [1]"


def _draw_likelihood(data: FigureData) -> Figure:
    """Draw the probability to rise from each x on, with 95 % bands."""
    spec = data.spec
    figure, shown = panels(data)
    look = shared_look(data, curve_keys(data))
    for axes, rows in shown:
        for index, (names, points, values) in enumerate(_curves(data, rows)):
            style, label = look(names, index)
            x = points[spec.axes[0]].to_numpy(float)
            axes.plot(x, values[:, 0], style.marker, color=style.colour, label=label, linestyle="-")
            axes.fill_between(x, values[:, 1], values[:, 2], color=style.colour, alpha=PALE)
        axes.set_ylim(-0.03, 1.03)
    name = numbers(spec.system)[spec.show].name
    along = parameter_label(spec.system, spec.axes[0])
    label_axes(figure, shown, along, wrap_label("probability to rise from here on"))
    write_no_data(shown, name)
    legend(data, figure, shown, curve_keys(data))
    return figure


def _curves(
    data: FigureData, rows: pd.DataFrame
) -> Iterator[tuple[dict[str, Any], pd.DataFrame, np.ndarray]]:
    """Yield the names of each curve, its points, and probability and interval (X, 3) at each.

    At each x it is that one replicate of this and of each further point, drawn at random, rises
    from point to point. The last point has none.
    """
    spec = data.spec
    observable = numbers(spec.system)[spec.show]
    fields = tuple(SYSTEMS[spec.system].model_fields)
    for names, points in split_curves(rows, spec.axes[0], curve_keys(data), fields):
        own = FigureData(spec, points, data.boundaries, data.results)
        groups = [values[np.isfinite(values)] for values in replicate_values(own, observable)]
        has_values = [bool(group.size) for group in groups]
        filled = [group for group in groups if group.size]
        shown_points = points[has_values][:-1]
        values = np.array([_interval(filled[first:]) for first in range(len(shown_points))])
        yield names, shown_points, values.reshape(-1, 3)


def _interval(groups: list[np.ndarray]) -> tuple[float, float, float]:
    share, error = share_of_rises(groups)
    half_width = float(student(MANY)) * error
    return share, max(0.0, share - half_width), min(1.0, share + half_width)


def _likelihood_table(data: FigureData) -> pd.DataFrame:
    along, parts = data.spec.axes[0], []
    for names, points, values in _curves(data, data.rows):
        named = points[[along]].assign(**names, protocol=points["protocol"])
        parts.append(named.assign(**dict(zip(_CHANCE, values.T, strict=True))))
    return pd.concat(parts) if parts else pd.DataFrame(columns=[along, *_CHANCE])


def _likelihood_notes(data: FigureData) -> list[str]:
    return [
        "The probability is that a curve of single runs, one replicate per point drawn at random, "
        "rises from each point to the next from this x on. Bands: 95 % (jackknife)."
    ]


# Time series, read from run files.

#: Most values of a line; more samples are averaged in successive groups.
MOST_VALUES = 400


def _draw_series(data: FigureData) -> Figure:
    """Draw a line per replicate, and a dotted one where averaging begins."""
    spec = data.spec
    figure, shown = panels(data)
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            values = read_time_series(data, row)
            look = {"color": style.colour, "linestyle": style.dashes, "linewidth": 1.0}
            for _, one in values.groupby("replicate"):
                x, y = (
                    above_zero(data, axis, one[name].to_numpy(float))
                    for axis, name in zip("xy", ("time", "value"), strict=True)
                )
                axes.plot(x, y, label=label, **look, zorder=2)
            starts = data.results.dataset["average_start"].sel(point=row["point"]).values
            axes.axvline(float(np.nanmean(starts)) / scale_of_point(data, row, "s"), **LEVEL)
        for axis in spec.log:
            set_log(axes, axis)
    unit = unit_of("s", spec.units, spec.system)
    observable = series(spec.system)[spec.show]
    label_axes(
        figure,
        shown,
        label_with_unit("time since the start", unit),
        observable_label(data, observable),
    )
    write_no_data(shown, observable.name)
    legend(data, figure, shown, curve_keys(data))
    return figure


def read_time_series(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the time series of a point with columns ``replicate``, ``time`` and ``value``.

    Times and values are in the units of the plot. Raises ``InputError`` where the run file is
    missing or damaged.
    """
    observable = series(data.spec.system)[data.spec.show]
    if data.results.runs is None:
        raise InputError(f"{row['point']}: time series are in run files, of which there are none")
    path, model = data.results.runs / f"{row['point']}.nc", SYSTEMS[data.spec.system]
    point = model.model_construct(**{name: row[name] for name in model.model_fields})
    with (
        checked_read(path, "run file", replaceable=True, sealed=True),
        netCDF4.Dataset(path) as file,
    ):
        # It may hold more than these amounts.
        run = RunFile(file, amounts(point))
        require_all(run.attrs, path)
        completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
        time, values = np.asarray(run["time"]), np.asarray(run[observable.source])
    scales = scale_of_point(data, row, "s"), scale_of_point(data, row, observable.unit)
    parts = []
    for number in completed:
        is_known = np.isfinite(values[number])
        both = (_averaged(each[is_known]) for each in (time, values[number]))
        columns = (each / scale for each, scale in zip(both, scales, strict=True))
        named = dict(zip(("time", "value"), columns, strict=True))
        parts.append(pd.DataFrame({"replicate": number} | named))
    return pd.concat(parts) if parts else pd.DataFrame(columns=["replicate", "time", "value"])


def _averaged(values: np.ndarray) -> np.ndarray:
    """Average groups of successive values, so that at most `MOST_VALUES` remain."""
    size = -(-len(values) // MOST_VALUES) or 1
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def _series_table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, a row per value, units in the headings."""
    spec, observable = data.spec, series(data.spec.system)[data.spec.show]
    units = [unit_of(unit, spec.units, spec.system) for unit in (observable.unit, "s")]
    headings = {"time": f"time [{units[1]}]", "value": f"{observable.name} [{units[0] or '1'}]"}
    return rows_of_points(data, headings, partial(read_time_series, data))


def _series_notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on the lines."""
    time, value = _series_table(data).iloc[:, -2:].to_numpy(float).T
    shown = above_zero(data, "x", time) + above_zero(data, "y", value)
    return [
        "A line per replicate. Dotted: where averaging begins.",
        f"A line has at most {MOST_VALUES} means over successive samples; the dotted line is at "
        "the mean over the replicates of a point.",
        *not_drawn(int(np.isnan(shown).sum()), "values not above 0 on a logarithmic axis"),
    ]


DISTRIBUTION = Drawing(_draw_distribution, _distribution_table, _distribution_notes)
LIKELIHOOD = Drawing(_draw_likelihood, _likelihood_table, _likelihood_notes)
TIME_SERIES = Drawing(_draw_series, _series_table, _series_notes)
