"""Turn a study's dataset into one row per point of a figure, and into the table of its data."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.dataset.replicates import OUTCOME, SCALARS, outcomes
from sim.dataset.results import Results
from sim.parameters import NUMERICAL, SYSTEMS, field_info
from sim.study.figure_spec import FigureSpec

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
        if self.results.runs is None or "answer" not in self.spec.options:
            raise InputError(f"{self.spec.name}: drawn in the results of a study alone")
        return self.results.runs.parent / self.spec.options["answer"]


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
    """Return a mask of the points that feed a figure, (point,)."""
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
    declared = field_info(SYSTEMS[system])
    columns = {"point": rows["point"]}
    for name in names:
        row = declared[name]
        unit = row.scale or row.unit
        columns[f"{name} [{unit}]" if unit else name] = rows[name]
    return columns


def velocity_table(data: FigureData) -> pd.DataFrame:
    """Return parameters and outcome of points, one row each, units in the headings."""
    rows, spec = data.rows, data.spec
    names = dict.fromkeys([*spec.axes, *spec.curves, *spec.named, *_PROTOCOL])
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
