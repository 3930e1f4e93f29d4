"""Measures: numbers per replicate that a dataset adds to those of its run files."""

import numpy as np
import xarray as xr

from sim.dataset.measures import belt, chute, energy

_OF_SYSTEM = {"chute": chute, "belt": belt}

#: Unit and long name of every measure.
MEASURES: dict[str, tuple[str, str]] = energy.MEASURES | chute.MEASURES | belt.MEASURES


def measures(run: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the measures of a run, each an array over its replicates.

    Parameters
    ----------
    run : xarray.Dataset
        A run file. Replicates that failed, and files without the arrays that a measure needs, give
        not-a-number.
    """
    system = _OF_SYSTEM[run.attrs["system"]]
    completed = run["status"].values == "completed"
    table = {
        name: np.full(run.sizes["replicate"], np.nan) for name in energy.MEASURES | system.MEASURES
    }
    for index in np.flatnonzero(completed):
        replicate = run.isel(replicate=index)
        found = energy.measure(replicate) | system.measure(replicate)
        for name, value in found.items():
            table[name][index] = value
    return table
