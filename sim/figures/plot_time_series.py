"""Time series of replicates, read from their run files: a study's own plot.

Options of a figure: those of `sim.figures.plot`.
"""

from collections.abc import Mapping
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.dataset.run_file import RunFile
from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.plot import (
    above_zero,
    empty_text,
    groups,
    label_axes,
    legend,
    lost_note,
    named_columns,
    observable_label,
    panels,
    scale_of_point,
    set_log,
)
from sim.figures.style import LEVEL
from sim.figures.units import headed, unit_of
from sim.parameters import SYSTEMS, amounts
from sim.study.plottable import series

#: Values of a line at most: means of as many successive samples as that takes.
MOST = 400


def draw(data: FigureData) -> Figure:
    """Draw a line per replicate; dotted, where averaging begins."""
    spec = data.spec
    figure, shown = panels(data)
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            values = courses(data, row)
            look = {"color": style.colour, "linestyle": style.dashes, "linewidth": 1.0}
            for number, (_, one) in enumerate(values.groupby("replicate")):
                entry = label if number == 0 else None
                x, y = (
                    above_zero(data, axis, one[name].to_numpy(float))
                    for axis, name in zip("xy", ("time", "value"), strict=True)
                )
                axes.plot(x, y, label=entry, **look, zorder=2)
            axes.axvline(_start(data, row), **LEVEL)
        for axis in spec.options["log"]:
            set_log(axes, axis)
    unit = unit_of("s", spec.options["units"], spec.system)
    one = series(spec.system)[spec.options["show"]]
    label_axes(figure, shown, headed("time since the start", unit), observable_label(data, one))
    empty_text(shown, one.name)
    legend(figure, shown)
    return figure


def courses(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the time series of a point: ``replicate``, ``time`` and ``value``, in the units.

    Raises ``InputError`` where its run file is missing or damaged.
    """
    one = series(data.spec.system)[data.spec.options["show"]]
    if data.results.runs is None:
        raise InputError(f"{row['point']}: time series are in run files, of which there are none")
    path = data.results.runs / f"{row['point']}.nc"
    with (
        checked_read(path, "run file", replaceable=True, sealed=True),
        netCDF4.Dataset(path) as file,
    ):
        run = RunFile(file, _wanted(data.spec.system, row))
        completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
        time, values = np.asarray(run["time"]), np.asarray(run[one.source])
    by = scale_of_point(data, row, one.unit)
    parts = []
    for number in completed:
        known = np.isfinite(values[number])
        moment, value = thinned(time[known]), thinned(values[number][known])
        parts.append(
            pd.DataFrame(
                {
                    "replicate": number,
                    "time": moment / scale_of_point(data, row, "s"),
                    "value": value / by,
                }
            )
        )
    return pd.concat(parts) if parts else pd.DataFrame(columns=["replicate", "time", "value"])


def _wanted(system: str, row: Mapping[str, Any]) -> dict[str, float]:
    """Return the amounts of a point, of which its run file may hold more."""
    model = SYSTEMS[system]
    return amounts(model.model_construct(**{name: row[name] for name in model.model_fields}))


def thinned(values: np.ndarray) -> np.ndarray:
    """Return means of successive values, `MOST` at most."""
    size = -(-len(values) // MOST) or 1
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def _start(data: FigureData, row: Mapping[str, Any]) -> float:
    """Return where the averaging of the replicates of a point begins, in the mean."""
    starts = data.results.dataset["average_start"].sel(point=row["point"]).values
    return float(np.nanmean(starts)) / scale_of_point(data, row, "s")


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the lines, a row per value, units in the headings."""
    spec, one = data.spec, series(data.spec.system)[data.spec.options["show"]]
    units = [unit_of(unit, spec.options["units"], spec.system) for unit in (one.unit, "s")]
    known = data.rows[data.rows["completed"] > 0]
    named = named_columns(data, known)
    headings = {"time": f"time [{units[1]}]", "value": f"{one.name} [{units[0] or '1'}]"}
    parts = []
    for index, row in known.iterrows():
        values = courses(data, {str(name): value for name, value in row.items()})
        own = {name: column[index] for name, column in named.items()}
        parts.append(pd.DataFrame(own | {name: values[name] for name in values}))
    found = pd.concat(parts) if parts else pd.DataFrame(columns=[*named, "replicate", *headings])
    return found.rename(columns=headings)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of the lines."""
    return [
        f"A line per replicate, of at most {MOST} means over successive samples. Dotted: where "
        "averaging begins, in the mean over the replicates of a point.",
        *(_notes_on_logarithms(data) if data.spec.options["log"] else []),
        unsteady_sentence(data.rows),
    ]


def _notes_on_logarithms(data: FigureData) -> list[str]:
    """Say how many values a logarithmic axis has no place for."""
    time, value = table(data).iloc[:, -2:].to_numpy(float).T
    kept = above_zero(data, "x", time) + above_zero(data, "y", value)
    return lost_note(int(np.isnan(kept).sum()), f"of {time.size:,} values")


KIND = Kind(draw, table=table, notes=notes)
