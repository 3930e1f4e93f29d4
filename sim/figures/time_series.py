"""Time series of replicates, read from their run files: a plot that a study file defines."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.errors import InputError
from sim.base.seals import checked_read
from sim.engine.stored_run import RunFile, require_all
from sim.figures.axes import set_log
from sim.figures.caption import not_drawn
from sim.figures.data import FigureData, label_with_unit, unit_of
from sim.figures.plot import (
    above_zero,
    curve_keys,
    label_axes,
    observable_label,
    panels,
    rows_of_points,
    scale_of_point,
    write_no_data,
)
from sim.figures.style import LEVEL
from sim.figures.variables import groups, legend
from sim.parameters import SYSTEMS, amounts
from sim.study.plottable import series

#: Most values of a line; more samples are averaged in successive groups.
MOST_VALUES = 400


def draw(data: FigureData) -> Figure:
    """Draw a line per replicate, and a dotted one where averaging begins."""
    spec = data.spec
    figure, shown = panels(data)
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            values = read_time_series(data, row)
            look = {"color": style.colour, "linestyle": style.dashes, "linewidth": 1.0}
            for number, (_, replicate_values) in enumerate(values.groupby("replicate")):
                entry = label if number == 0 else None
                x, y = (
                    above_zero(data, axis, replicate_values[name].to_numpy(float))
                    for axis, name in zip("xy", ("time", "value"), strict=True)
                )
                axes.plot(x, y, label=entry, **look, zorder=2)
            axes.axvline(_averaging_start(data, row), **LEVEL)
        for axis in spec.log:
            set_log(axes, axis)
    unit = unit_of("s", spec.units, spec.system)
    replicate_values = series(spec.system)[spec.show]
    label_axes(
        figure,
        shown,
        label_with_unit("time since the start", unit),
        observable_label(data, replicate_values),
    )
    write_no_data(shown, replicate_values.name)
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
    path = data.results.runs / f"{row['point']}.nc"
    with (
        checked_read(path, "run file", replaceable=True, sealed=True),
        netCDF4.Dataset(path) as file,
    ):
        run = RunFile(file, _point_amounts(data.spec.system, row))
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


def _point_amounts(system: str, row: Mapping[str, Any]) -> dict[str, float]:
    """Return the amounts of a point; its run file may hold more than these."""
    model = SYSTEMS[system]
    return amounts(model.model_construct(**{name: row[name] for name in model.model_fields}))


def _averaged(values: np.ndarray) -> np.ndarray:
    """Average groups of successive values, so that at most `MOST_VALUES` remain."""
    size = -(-len(values) // MOST_VALUES) or 1
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def _averaging_start(data: FigureData, row: Mapping[str, Any]) -> float:
    starts = data.results.dataset["average_start"].sel(point=row["point"]).values
    return float(np.nanmean(starts)) / scale_of_point(data, row, "s")


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, a row per value, units in the headings."""
    spec, observable = data.spec, series(data.spec.system)[data.spec.show]
    units = [unit_of(unit, spec.units, spec.system) for unit in (observable.unit, "s")]
    headings = {"time": f"time [{units[1]}]", "value": f"{observable.name} [{units[0] or '1'}]"}
    return rows_of_points(data, headings, partial(read_time_series, data))


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on the lines."""
    return [
        "A line per replicate. Dotted: where averaging begins.",
        f"A line has at most {MOST_VALUES} means over successive samples; the dotted line is at "
        "the mean over the replicates of a point.",
        *(_notes_on_logarithms(data) if data.spec.log else []),
    ]


def _notes_on_logarithms(data: FigureData) -> list[str]:
    time, value = table(data).iloc[:, -2:].to_numpy(float).T
    shown = above_zero(data, "x", time) + above_zero(data, "y", value)
    lost = int(np.isnan(shown).sum())
    return not_drawn(lost, "values not above 0 on a logarithmic axis")
