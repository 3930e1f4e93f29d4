"""NetCDF files that tests write or change, sealed like those of the program."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import netCDF4
import xarray as xr

from sim.base.seals import seal

#: Largest relative difference of a profile in a dataset from that in the run file.
ROUNDING = 2.0**-10


def store(dataset: xr.Dataset, path: Path, **options: Any) -> None:
    """Write a dataset with `xarray.Dataset.to_netcdf`."""
    dataset.to_netcdf(path, **options)
    seal(path)


@contextmanager
def edit_file(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a file for changes in a block, then seal it."""
    with netCDF4.Dataset(path, "a") as file:
        yield file
    seal(path)
