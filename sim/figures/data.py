"""From a study's dataset to one row per point of a figure, and to the table behind it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.dataset.replicates import OUTCOME, SCALARS, outcomes
from sim.dataset.results import Results
from sim.parameters import NUMERICAL, SYSTEMS, field_info
from sim.study.catalogue import FigureSpec

#: Parameters that every table of velocities tells beside those of its figure.
_PROTOCOL = ("protocol", "target", "limit")


@dataclass(frozen=True)
class FigureData:
    """What a figure is drawn from.

    ``spec`` is its entry of the catalogue; ``rows`` one per point, as `summarize` returns them;
    ``boundaries`` those that feed the figure; ``results`` all of the study, for measures, profiles
    and particles of the points.
    """

    spec: FigureSpec
    rows: pd.DataFrame
    boundaries: pd.DataFrame
    results: Results


def figure_data(results: Results, spec: FigureSpec) -> FigureData:
    """Return the points and boundaries that a figure shows."""
    found = results.boundaries
    fed = np.array([spec.name in names.split() for names in found["figures"]], dtype=bool)
    return FigureData(spec, summarize(results.dataset, spec), found[fed], results)


def summarize(dataset: xr.Dataset, spec: FigureSpec) -> pd.DataFrame:
    """Return one row per point of a figure.

    Parameters
    ----------
    dataset : xarray.Dataset
        A study's ``dataset.nc``.
    spec : FigureSpec
        The figure; the points that feed it are taken: those that name it or, of a study's own
        plot, those of its system and series.

    Returns
    -------
    pandas.DataFrame
        All coordinates of the points, the columns of `sim.dataset.replicates.outcome`, and
        ``regimes``: those of the completed replicates.
    """
    points = dataset[list(SCALARS)].isel(point=np.flatnonzero(_fed(dataset, spec)))
    columns = {
        str(name): values.values
        for name, values in points.coords.variables.items()
        if values.dims == ("point",)
    }
    rows = pd.DataFrame(columns)
    done = points["status"].values == "completed"
    regimes = [tuple(each[kept]) for each, kept in zip(points["regime"].values, done, strict=True)]
    rows["regimes"] = pd.Series(regimes, dtype=object)
    return pd.concat([rows, pd.DataFrame(outcomes(points), columns=list(OUTCOME))], axis=1)


def _fed(dataset: xr.Dataset, spec: FigureSpec) -> np.ndarray:
    """Return which points feed a figure, (point,)."""
    if not spec.series:
        named = [spec.name in names.split() for names in dataset["figures"].values]
        return np.array(named, dtype=bool)
    own = [not set(spec.series).isdisjoint(names.split()) for names in dataset["series"].values]
    return np.array(own, dtype=bool) & (dataset["system"].values == spec.system)


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
        All parameters of the system. One that varies although it is neither ``along`` nor a key,
        and that changes the flow, is added to the keys, so that no curve mixes two flows. One that
        an older dataset does not know cannot vary in it.

    Returns
    -------
    list of (dict, pandas.DataFrame)
        The values that name each curve, and its points in the order of ``along``.
    """
    varied = varying(rows, [name for name in parameters if name != along])
    names = list(dict.fromkeys([*keys, *varied]))
    if not names:
        return [({}, rows.sort_values(along))]
    return [
        (dict(zip(names, values, strict=True)), curve.sort_values(along))
        for values, curve in rows.groupby(names, sort=True)
    ]


def varying(rows: pd.DataFrame, parameters: Sequence[str]) -> list[str]:
    """Return which parameters vary and change the flow; a plane as rough as the particles aside."""
    known = [name for name in parameters if name in rows and name not in NUMERICAL]
    varied = [name for name in known if rows[name].nunique() > 1]
    plane = "friction_plane"
    if plane in varied and rows[plane].equals(rows["friction"].rename(plane)):
        varied.remove(plane)
    return varied


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
