"""Turn a study's dataset into one row per point of a figure, and into the table of its data."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.files import file_version
from sim.base.statistics import student_half_width
from sim.dataset.replicates import OUTCOME, SCALARS, answering_regime, outcomes, replicate_values
from sim.dataset.results import Results
from sim.parameters import NUMERICAL, SYSTEMS, field_info
from sim.study.figure_spec import FigureSpec, Measure
from sim.study.plottable import numbers
from sim.surrogates.answers import caveats_in, refusal_in

#: Parameters that every table of velocities has in addition to those of its figure.
_PROTOCOL = ("protocol", "target", "limit")


@dataclass(frozen=True)
class FigureData:
    """The data of a figure.

    ``spec`` is its entry of the catalogue. ``rows`` has one row per point, as `summarize` returns
    them. ``boundaries`` are those that feed the figure. ``results`` are all results of the study,
    for measures, profiles and particles of the points.
    """

    spec: FigureSpec
    rows: pd.DataFrame
    boundaries: pd.DataFrame
    results: Results

    @property
    def answer(self) -> Path:
        """File of the answer that the figure shows, in the results of its study."""
        if self.results.runs is None or not self.spec.answer.file:
            raise InputError(f"{self.spec.name}: drawn in the results of a study alone")
        return self.results.runs.parent / self.spec.answer.file

    @property
    def refusal(self) -> str:
        """What stands in place of the answer, empty where there is one."""
        return refusal_in(self.answer)

    @property
    def caveats(self) -> tuple[str, ...]:
        """Caveats of the answer, the worst first."""
        return caveats_in(self.answer)

    @property
    def flows_of_answer(self) -> pd.DataFrame:
        """Completed points with the regimes that answers take them for.

        Further columns are ``has_value``, of what the answer is about, and ``is_counted``.
        """
        rows, answer = self.rows[self.rows["completed"] > 0], self.spec.answer
        observable = numbers(self.spec.system)[answer.observable]
        values = replicate_values(self.results, observable, list(rows["point"]))
        has_value = np.array([row.size > 0 for row in values], bool)
        regimes = pd.Series(
            map(answering_regime, rows.to_dict("records")), rows.index, dtype=object
        )
        is_counted = regimes.isin(answer.regimes) & has_value
        return rows.assign(regime=regimes, has_value=has_value, is_counted=is_counted)

    def read_answer(self, load: Callable[[Path], Any]) -> Any:
        """Return the answer that the figure shows, as a function reads its file."""
        return read_once(load, self.answer, file_version(self.answer))


@lru_cache(maxsize=8)
def read_once(load: Callable[[Path], Any], path: Path, version: tuple[int, ...]) -> Any:
    """Return what a function reads of a version of a file, for all pictures that show it."""
    return load(path)


class Drawing(NamedTuple):
    """What draws a kind of plot where a module draws several: functions of the data of a figure."""

    draw: Callable[[FigureData], Any]
    table: Callable[[FigureData], pd.DataFrame]
    notes: Callable[[FigureData], list[str]]
    select: Callable[[FigureData], FigureData] = lambda data: data


def figure_data(results: Results, spec: FigureSpec) -> FigureData:
    """Return the points and boundaries that a figure shows."""
    found = results.boundaries
    is_named = np.array([spec.name in names.split() for names in found["figures"]], bool)
    is_named |= found["name"].isin(spec.series or ()).to_numpy(bool)
    return FigureData(spec, summarize(results.dataset, spec), found[is_named], results)


def summarize(dataset: xr.Dataset, spec: FigureSpec) -> pd.DataFrame:
    """Return one row per point of a figure: all coordinates, and the columns of `outcomes`.

    It is fed by the points that name it; a plot that a study file defines is fed by the points of
    its system and series.
    """
    key, wanted = ("series", set(spec.series)) if spec.series else ("figures", {spec.name})
    feeds = np.array([not wanted.isdisjoint(names.split()) for names in dataset[key].values], bool)
    if spec.series:
        feeds &= (dataset["system"] == spec.system).values
    kept = [name for name in SCALARS if name in dataset]
    points = dataset[kept].isel(point=np.flatnonzero(feeds))
    columns = {
        str(name): values.values
        for name, values in points.coords.variables.items()
        if values.dims == ("point",)
    }
    if spec.axes and "start_from" in spec.groups:
        columns["start_from"] = _sweeps(columns, spec.axes[0])
    found = pd.DataFrame(outcomes(points), columns=list(OUTCOME))
    return pd.concat([pd.DataFrame(columns), found], axis=1)


def _sweeps(columns: dict[str, Any], along: str) -> np.ndarray:
    """Return what points start from; of those in a sweep its series, and which way ``along`` it.

    In a sweep each point of a series starts from another one. The way is told of series with both.
    """
    number = {point: k for k, point in enumerate(columns["point"])}
    series = [names.split() for names in columns["series"]]
    starts = {k: number[start] for k, start in enumerate(columns["start_from"]) if start in number}
    sweeps: dict[int, tuple[str, str]] = {}
    for k, before in starts.items():
        if common := [name for name in series[k] if name in series[before]]:
            is_down = columns[along][k] < columns[along][before]
            sweeps[k] = common[0], "down" if is_down else "up"
    both = Counter(name for name, _ in set(sweeps.values()))
    labels = {k: " ".join(one) if both[one[0]] > 1 else one[0] for k, one in sweeps.items()}
    # The first of a sweep goes the way of the second.
    firsts = {starts[k]: label for k, label in labels.items() if starts[k] not in labels}
    every = enumerate(columns["start_from"])
    return np.array([(firsts | labels).get(k, start) for k, start in every], object)


def split_curves(
    rows: pd.DataFrame, along: str, keys: Sequence[str], parameters: Sequence[str]
) -> list[tuple[dict[str, Any], pd.DataFrame]]:
    """Split points into curves: values that name each, and its points in the order of ``along``.

    ``keys`` always name a curve. Of the ``parameters`` of the system, those that vary and change
    the flow are added to them, so that no curve mixes two flows.
    """
    varied = varying_parameters(rows, [name for name in parameters if name != along])
    names = list(dict.fromkeys([*keys, *varied]))
    if not names:
        return [({}, rows.sort_values(along))]
    return [
        (dict(zip(names, values, strict=True)), curve.sort_values(along))
        for values, curve in rows.groupby(names, sort=True)
    ]


def varying_parameters(rows: pd.DataFrame, parameters: Sequence[str]) -> list[str]:
    """Return the parameters that vary and change the flow.

    ``friction_plane`` is left out where it equals ``friction`` everywhere.
    """
    plane, friction = (rows.get(name, pd.Series()) for name in ("friction_plane", "friction"))
    apart = {*NUMERICAL, *["friction_plane"] * plane.equals(friction)}
    candidates = [name for name in parameters if name in rows and name not in apart]
    return [name for name in candidates if rows[name].nunique() > 1]


def is_undecided(rows: pd.DataFrame) -> pd.Series:
    """Return a mask of points that may be steady or not: few samples, or no clear trend."""
    return rows["regime"].isin(("steady", "undetermined")) & (rows["quality"] == "short")


def parameter_unit(system: str, name: str) -> str:
    """Return the unit of a parameter in study files, as in headings; empty for a choice."""
    row = field_info(SYSTEMS[system])[name]
    return row.scale or row.unit or ""


def parameter_heading(system: str, name: str) -> str:
    """Return the heading of a column with a parameter."""
    unit = parameter_unit(system, name)
    return f"{name} [{unit}]" if unit else name


def parameter_columns(
    rows: pd.DataFrame, system: str, names: Iterable[str]
) -> dict[str, pd.Series]:
    """Return the ids of points and some of their parameters, units in the headings."""
    columns = {parameter_heading(system, name): rows[name] for name in names}
    return {"point": rows["point"]} | columns


def velocity_table(data: FigureData) -> pd.DataFrame:
    """Return parameters and outcome of points, one row each, units in the headings."""
    rows, spec = data.rows, data.spec
    names = dict.fromkeys([*spec.axes, *spec.groups, *spec.named, *_PROTOCOL])
    return pd.DataFrame(
        parameter_columns(rows, spec.system, names)
        | {
            "mean velocity [m s-1]": rows["velocity"],
            "half width of 95 % interval [m s-1]": rows["half_width"],
            "interval": rows["interval"],
            "completed replicates": rows["completed"],
            "replicates": rows["replicates"].astype(int),
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
            "stopped by": rows["stopped"],
            "reason of failures": rows["reason"],
            "caveat": rows["caveat"],
        }
    )


@dataclass(frozen=True)
class Quantity:
    """A quantity of every point of a figure, from the column or measure ``name``.

    ``label`` is ``meaning [unit]``. Value, and half width of its 95 % interval, are not-a-number
    where unknown.
    """

    name: str
    label: str
    value: pd.Series
    half_width: pd.Series


def velocity(rows: pd.DataFrame) -> Quantity:
    """Return the mean velocity of points."""
    return Quantity("velocity", "mean velocity [m s-1]", rows["velocity"], rows["half_width"])


def _measured(data: FigureData, measure: Measure) -> Quantity:
    """Return a measure of the dataset: its mean over the replicates that have a finite value."""
    finite = measured_replicates(data, measure)
    return replicate_means(measure.name, measure.label, finite, data.rows.index)


def measured_replicates(data: FigureData, measure: Measure) -> list[np.ndarray]:
    """Return one array per point: a measure of its replicates that have a finite value."""
    rows, dataset = data.rows, data.results.dataset
    if measure.name not in dataset:
        raise InputError(f"no {measure.name} in the dataset")
    values = dataset[measure.name].sel(point=rows["point"].values).values
    if measure.over:
        values = values / rows[measure.over].to_numpy()[:, None]
    return [replicates[np.isfinite(replicates)] for replicates in values]


def replicate_means(
    name: str, label: str, values: Sequence[np.ndarray], index: pd.Index
) -> Quantity:
    """Return a quantity whose values are the means over the replicates (R,) of each point."""
    means = [one.mean() if one.size else np.nan for one in values]
    half_widths = [float(student_half_width(one)) for one in values]
    value, half = (pd.Series(column, index, dtype=float) for column in (means, half_widths))
    return Quantity(name, label, value, half)


def quantities(data: FigureData) -> list[Quantity]:
    """Return the measures that the key ``quantities`` of a figure names, or the velocity."""
    return [_measured(data, one) for one in data.spec.quantities] or [velocity(data.rows)]


def point_table(data: FigureData) -> pd.DataFrame:
    """Return parameters and quantities of a figure, one row per point, units in the headings."""
    if data.spec.quantities:
        return quantity_table(data, quantities(data))
    return velocity_table(data)


def quantity_table(
    data: FigureData, quantities: Sequence[Quantity], along: dict[str, pd.Series] | None = None
) -> pd.DataFrame:
    """Return parameters and quantities of points, one row each, units in the headings.

    ``along`` are columns between parameters and quantities, by their headings.
    """
    rows, spec, columns = data.rows, data.spec, dict(along or {})
    for quantity in quantities:
        what, bracket, unit = quantity.label.partition("[")
        of = "" if len(quantities) == 1 else f" of the {what.strip()}"
        columns[quantity.label] = quantity.value
        columns[f"half width of 95 % interval{of} {bracket}{unit}"] = quantity.half_width
    names = (*spec.axes, *spec.named, "protocol")
    states = {"completed replicates": "completed", "regime": "regime"}
    states["quality of the mean"] = "quality"
    columns |= {heading: rows[name] for heading, name in states.items()}
    return pd.DataFrame(parameter_columns(rows, spec.system, names) | columns)
