"""Measures: numbers per replicate that a dataset adds to those of its run files."""

from collections.abc import Callable

import numpy as np
import xarray as xr

from sim.measures import belt, chute

#: Unit and long name of every measure.
MEASURES: dict[str, tuple[str, str]] = chute.MEASURES | belt.MEASURES

_OF_SYSTEM: dict[str, Callable[[xr.Dataset], dict[str, float]]] = {
    "chute": chute.measure,
    "belt": belt.measure,
}


def measures(run: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the measures of a run, each an array over its replicates.

    Parameters
    ----------
    run : xarray.Dataset
        A run file. Replicates that failed, and files without the arrays that a measure needs, give
        not-a-number.
    """
    system = run.attrs["system"]
    names = {"chute": chute.MEASURES, "belt": belt.MEASURES}[system]
    completed = run["status"].values == "completed"
    table = {name: np.full(run.sizes["replicate"], np.nan) for name in names}
    for index in np.flatnonzero(completed):
        for name, value in _OF_SYSTEM[system](run.isel(replicate=index)).items():
            table[name][index] = value
    return table
