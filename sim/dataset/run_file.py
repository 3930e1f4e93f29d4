"""A run file as arrays by name, each read when it is first asked for."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import netCDF4
import numpy as np
import xarray as xr


class RunFile(Mapping[str, np.ndarray]):
    """An open run file; ``attrs`` are its global attributes, ``known`` the scalars that its end
    tells, which spare reading a third of what a dataset keeps.

    xarray takes a twentieth of a second to find out about the hundred variables of a run, of which
    a dataset keeps a part.
    """

    def __init__(self, file: netCDF4.Dataset, known: Mapping[str, Sequence[Any]] | None = None):
        file.set_auto_mask(False)
        self._file = file
        self._read = {name: np.array(values) for name, values in (known or {}).items()}
        self.attrs = {name: file.getncattr(name) for name in file.ncattrs()}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._read:
            self._read[name] = np.asarray(self._file.variables[name][...])
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._file.variables)

    def __len__(self) -> int:
        return len(self._file.variables)

    def __contains__(self, name: object) -> bool:
        return name in self._file.variables

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of the dimensions of a variable."""
        return self._file.variables[name].dimensions

    def variable(self, name: str) -> xr.Variable:
        """Return a variable with its dimensions and attributes."""
        held = self._file.variables[name]
        attrs = {key: held.getncattr(key) for key in held.ncattrs() if key != "_FillValue"}
        return xr.Variable(held.dimensions, self[name], attrs)


class Replicate(Mapping[str, Any]):
    """What a run file holds of one replicate and of all of them, by name."""

    def __init__(self, run: RunFile, index: int):
        self._run, self._index = run, index

    def __getitem__(self, name: str) -> Any:
        values = self._run[name]
        return values[self._index] if "replicate" in self._run.dims(name) else values

    def __iter__(self) -> Iterator[str]:
        return iter(self._run)

    def __len__(self) -> int:
        return len(self._run)

    def __contains__(self, name: object) -> bool:
        return name in self._run
