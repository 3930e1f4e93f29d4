"""Turn a study's dataset into one row per point of a figure, and into the table of its data."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.dataset.replicates import OUTCOME, SCALARS, outcomes
from sim.dataset.results import Results
from sim.parameters import NUMERICAL, SYSTEMS, field_info
from sim.study.figure_spec import FigureSpec, Measure
from sim.study.plot_contents import name_in_words, parameter_phrase

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


class Drawing(NamedTuple):
    """What draws a kind of plot where a module draws several: functions of the data of a figure."""

    draw: Callable[[FigureData], Any]
    table: Callable[[FigureData], pd.DataFrame]
    notes: Callable[[FigureData], list[str]]
    select: Callable[[FigureData], FigureData] = lambda data: data


def figure_data(results: Results, spec: FigureSpec) -> FigureData:
    """Return the points and boundaries that a figure shows."""
    boundaries = results.boundaries
    feeds_figure = np.array(
        [spec.name in names.split() for names in boundaries["figures"]], dtype=bool
    )
    return FigureData(spec, summarize(results.dataset, spec), boundaries[feeds_figure], results)


def summarize(dataset: xr.Dataset, spec: FigureSpec) -> pd.DataFrame:
    """Return one row per point of a figure.

    Parameters
    ----------
    dataset : xarray.Dataset
        A study's ``dataset.nc``.
    spec : FigureSpec
        The figure. It is fed by the points that name it; a plot that a study file defines is fed by
        the points of its system and series.

    Returns
    -------
    pandas.DataFrame
        All coordinates of the points, the columns of `sim.dataset.replicates.outcome`, and
        ``regimes``: a tuple of those of the completed replicates.
    """
    points = dataset[list(SCALARS)].isel(point=np.flatnonzero(_feeds_figure(dataset, spec)))
    columns = {
        str(name): values.values
        for name, values in points.coords.variables.items()
        if values.dims == ("point",)
    }
    rows = pd.DataFrame(columns)
    completed = points["status"].values == "completed"
    regimes = [
        tuple(row[is_completed])
        for row, is_completed in zip(points["regime"].values, completed, strict=True)
    ]
    rows["regimes"] = pd.Series(regimes, dtype=object)
    return pd.concat([rows, pd.DataFrame(outcomes(points), columns=list(OUTCOME))], axis=1)


def _feeds_figure(dataset: xr.Dataset, spec: FigureSpec) -> np.ndarray:
    if not spec.series:
        is_named = [spec.name in names.split() for names in dataset["figures"].values]
        return np.array(is_named, dtype=bool)
    is_in_series = [
        not set(spec.series).isdisjoint(names.split()) for names in dataset["series"].values
    ]
    return np.array(is_in_series, dtype=bool) & (dataset["system"].values == spec.system)


def split_curves(
    rows: pd.DataFrame, along: str, keys: Sequence[str], parameters: Sequence[str]
) -> list[tuple[dict[str, Any], pd.DataFrame]]:
    """Split points into curves.

    Parameters
    ----------
    rows : pandas.DataFrame
        Points, as `summarize` returns them.
    along : str
        Parameter on the horizontal axis.
    keys : sequence of str
        Parameters that always name a curve.
    parameters : sequence of str
        All parameters of the system. A parameter that varies and changes the flow is added to the
        keys unless it is ``along``, so that no curve mixes two flows. Parameters that an older
        dataset lacks do not vary in it.

    Returns
    -------
    list of (dict, pandas.DataFrame)
        The values that name each curve, and its points in the order of ``along``.
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
    candidates = [name for name in parameters if name in rows and name not in NUMERICAL]
    names = [name for name in candidates if rows[name].nunique() > 1]
    plane = "friction_plane"
    if plane in names and rows[plane].equals(rows["friction"].rename(plane)):
        names.remove(plane)
    return names


def parameter_columns(
    rows: pd.DataFrame, system: str, names: Iterable[str]
) -> dict[str, pd.Series]:
    """Return the ids of points and some of their parameters, units in the headings."""
    columns = {parameter_heading(system, name): rows[name] for name in names}
    return {"point": rows["point"]} | columns


def parameter_unit(system: str, name: str) -> str:
    """Return the unit of a parameter in study files, as in headings; empty for a choice."""
    row = field_info(SYSTEMS[system])[name]
    return row.scale or row.unit or ""


def parameter_heading(system: str, name: str) -> str:
    """Return the heading of a column with a parameter."""
    unit = parameter_unit(system, name)
    return f"{name} [{unit}]" if unit else name


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


#: Natural unit by SI unit: powers of diameter, gravity and mass, and how it is written.
_NATURAL = {
    "m": ((1, 0, 0), "d"),
    "s": ((0.5, -0.5, 0), "√(d/g)"),
    "m s-1": ((0.5, 0.5, 0), "√(gd)"),
    "m s-2": ((0, 1, 0), "g"),
    "m2 s-2": ((1, 1, 0), "gd"),
    "m-2": ((-2, 0, 0), "1/d²"),
    "s-1": ((-0.5, 0.5, 0), "√(g/d)"),
    "N": ((0, 1, 1), "mg"),
    "J": ((1, 1, 1), "mgd"),
    "W": ((0.5, 1.5, 1), "mg√(gd)"),
    "Pa": ((-2, 1, 1), "mg/d²"),
    "kg s-1": ((-0.5, 0.5, 1), "m√(g/d)"),
    "kg m-1 s-1": ((-1.5, 0.5, 1), "m√(g/d)/d"),
}

#: What natural units have, and those by which a label can be divided without brackets.
_NATURAL_UNIT, _ONE_FACTOR = re.compile("[σ⟨]|^m?g$"), re.compile(r"⟨d⟩|\w|√\([^()]*\)")

#: SI units as axes show them.
_AXIS_UNITS = {
    "m s-1": "m/s",
    "m s-2": "m/s²",
    "m2 s-2": "m²/s²",
    "m-2": "1/m²",
    "s-1": "1/s",
    "kg s-1": "kg/s",
    "kg m-1 s-1": "kg/(m s)",
}


@dataclass(frozen=True)
class Quantity:
    """A quantity of every point of a figure.

    Attributes
    ----------
    name : str
        Column or measure that is its source.
    label : str
        Its meaning and its unit: ``meaning [unit]``.
    value, half_width : pandas.Series
        Value and half width of its 95 % interval per row of the points; not-a-number if unknown.
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
    rows, dataset = data.rows, data.results.dataset
    if measure.name not in dataset:
        raise InputError(f"no {measure.name} in the dataset")
    values = dataset[measure.name].sel(point=rows["point"].values).values
    if measure.over:
        values = values / rows[measure.over].to_numpy()[:, None]
    finite = [replicates[np.isfinite(replicates)] for replicates in values]
    return replicate_means(measure.name, measure.label, finite, rows.index)


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

    Parameters
    ----------
    data : FigureData
        The data of the figure.
    quantities : sequence of Quantity
        Quantities of its rows.
    along : dict, optional
        Columns between parameters and quantities, by their headings.
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


def unit_of(unit: str, units: str, system: str) -> str:
    """Return a unit as axes show it, empty for pure numbers.

    >>> unit_of("m s-1", "si", "chute"), unit_of("m s-1", "natural", "chute")
    ('m/s', '√(gσ)')
    """
    if unit == "1":
        return ""
    if units == "natural" and unit in _NATURAL:
        return _NATURAL[unit][1].replace("d", _diameter(system))
    return _AXIS_UNITS.get(unit, unit)


def _diameter(system: str) -> str:
    return field_info(SYSTEMS[system])["diameter"].symbol


def scale_of(unit: str, units: str, rows: pd.DataFrame) -> pd.Series:
    """Return the divisor of values in an SI unit, for each point; 1 for units ``"si"``."""
    powers = _NATURAL[unit][0] if units == "natural" and unit in _NATURAL else (0, 0, 0)
    length, gravity, mass = powers
    scale = rows["diameter"] ** length * rows["gravity"] ** gravity * rows["mass"] ** mass
    return pd.Series(scale, rows.index, dtype=float)


def parameter_text(system: str, name: str) -> str:
    """Return the label of a parameter, in the unit of study files.

    >>> parameter_text("belt", "amplitude")
    'amplitude A_z/⟨d⟩'
    """
    row = field_info(SYSTEMS[system])[name]
    return label_with_unit(parameter_phrase(system, name), row.scale or row.unit_text.strip())


def observable_text(name: str, unit: str, units: str, system: str) -> str:
    """Return the label of an observable in an SI unit: its name and its unit, as of `unit_of`."""
    return label_with_unit(name_in_words(name), unit_of(unit, units, system))


def label_with_unit(text: str, unit: str) -> str:
    """Return a label with its unit, if any; a quantity is divided by a natural unit.

    The space before a unit in brackets does not break.

    >>> label_with_unit("height z", "⟨d⟩"), label_with_unit("stress", "mg/σ²")
    ('height z/⟨d⟩', 'stress/(mg/σ²)')
    >>> label_with_unit("height z", "m") == "height z\N{NO-BREAK SPACE}(m)"
    True
    """
    if not unit:
        return text
    if not _NATURAL_UNIT.search(unit):
        return f"{text}\N{NO-BREAK SPACE}({unit})"
    return f"{text}/{unit if _ONE_FACTOR.fullmatch(unit) else f'({unit})'}"
