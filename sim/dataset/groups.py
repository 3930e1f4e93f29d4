"""Groups of an open netCDF file, as xarray reads them and as a new file gets them."""

from typing import Any

import netCDF4
import xarray as xr
from xarray.backends import NetCDF4DataStore
from xarray.backends.common import ArrayWriter


def open_group(file: netCDF4.Dataset, group: str | None) -> xr.Dataset:
    """Return a group of an open file, the root without a name; each access reads from the file."""
    return xr.open_dataset(NetCDF4DataStore(file[group] if group else file), cache=False)


class Values(ArrayWriter):
    """The values of variables that xarray has defined, written by `fill`.

    xarray writes the values of each variable before it defines the next. For the library below, a
    definition after values costs as much as all earlier definitions together.
    """

    def __init__(self) -> None:
        super().__init__()
        self._queue: list[tuple[Any, Any]] = []

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Queue the values of a variable; xarray calls this."""
        self._queue.append((source, target))

    def define(
        self, dataset: xr.Dataset, group: netCDF4.Dataset, encoding: dict[str, Any] | None = None
    ) -> None:
        """Define the variables and attributes of a dataset in an open file or a group of it."""
        dataset.dump_to_store(NetCDF4DataStore(group), writer=self, encoding=encoding or {})

    def fill(self) -> None:
        """Write the values of all variables that were defined since the last call."""
        for source, target in self._queue:
            target[...] = source
        self._queue.clear()
