"""netCDF files that a test writes or changes, sealed like those of the program."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import netCDF4
import xarray as xr

from sim.base.files import seal

#: How far a profile in a dataset is from that in the run file at most, relative.
ROUNDED = 2.0**-10


def store(dataset: xr.Dataset, path: Path, **options: Any) -> None:
    """Write a dataset with `xarray.Dataset.to_netcdf`."""
    dataset.to_netcdf(path, **options)
    seal(path)


@contextmanager
def changing(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a file to be changed in a block."""
    with netCDF4.Dataset(path, "a") as file:
        yield file
    seal(path)
