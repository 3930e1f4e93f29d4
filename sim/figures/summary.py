"""From a study's dataset to one row per point: mean velocity, its interval, its regime."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from sim.dataset.replicates import OUTCOME, outcome
from sim.dataset.results import Results
from sim.parameters import NUMERICAL
from sim.study.catalogue import FigureSpec


@dataclass(frozen=True)
class FigureData:
    """What a figure is drawn from.

    ``rows`` one per point, as `summarize` returns them; ``boundaries`` those that feed the figure;
    ``results`` all of the study, for profiles and particles of the points.
    """

    rows: pd.DataFrame
    boundaries: pd.DataFrame
    results: Results


def figure_data(results: Results, spec: FigureSpec) -> FigureData:
    """Return what feeds a figure."""
    found = results.boundaries
    fed = [spec.name in names.split() for names in found["figures"]]
    return FigureData(summarize(results.dataset, spec), found[np.array(fed, dtype=bool)], results)


def summarize(dataset: xr.Dataset, spec: FigureSpec) -> pd.DataFrame:
    """Return one row per point of a figure.

    Parameters
    ----------
    dataset : xarray.Dataset
        A study's ``dataset.nc``.
    spec : FigureSpec
        The figure; the points that feed it are taken.

    Returns
    -------
    pandas.DataFrame
        All coordinates of the points, the columns of `sim.dataset.replicates.outcome`, and
        ``regimes``: those of the completed replicates.
    """
    fed = np.array([spec.name in names.split() for names in dataset["figures"].values], dtype=bool)
    points = dataset.isel(point=np.flatnonzero(fed))
    names = [name for name, values in points.coords.items() if values.dims == ("point",)]
    rows = pd.DataFrame({name: points[name].values for name in names})
    outcomes = [outcome(points.isel(point=index)) for index in range(points.sizes["point"])]
    done = points["status"].values == "completed"
    regimes = [tuple(each[kept]) for each, kept in zip(points["regime"].values, done, strict=True)]
    rows["regimes"] = pd.Series(regimes, dtype=object)
    return pd.concat([rows, pd.DataFrame(outcomes, columns=list(OUTCOME))], axis=1)


def split_curves(
    rows: pd.DataFrame, along: str, keys: Sequence[str], parameters: Sequence[str]
) -> list[tuple[dict[str, object], pd.DataFrame]]:
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
        and that changes the flow, is added to the keys, so that no curve mixes two flows.

    Returns
    -------
    list of (dict, pandas.DataFrame)
        The values that name each curve, and its points in the order of ``along``.
    """
    varied = varying(rows, [name for name in parameters if name != along])
    names = list(dict.fromkeys([*keys, *varied]))
    return [
        (dict(zip(names, values, strict=True)), curve.sort_values(along))
        for values, curve in rows.groupby(names, sort=True)
    ]


def varying(rows: pd.DataFrame, parameters: Sequence[str]) -> list[str]:
    """Return which parameters vary and change the flow; a plane as rough as the particles aside."""
    varied = [name for name in parameters if name not in NUMERICAL and rows[name].nunique() > 1]
    plane = "friction_plane"
    if plane in varied and rows[plane].equals(rows["friction"].rename(plane)):
        varied.remove(plane)
    return varied
