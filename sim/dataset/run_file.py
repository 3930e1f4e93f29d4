"""A run file as arrays by name, each read when it is first asked for."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np

from sim.engine.stored_run import answering

if TYPE_CHECKING:
    import xarray as xr


#: Attributes that say how values are stored.
_ENCODING = ("_FillValue", "_Encoding")


class RunFile(Mapping[str, np.ndarray]):
    """An open run file as if no more had been run than is wanted; ``attrs`` are its attributes.

    Where it holds less, all that there is, and ``is_enough`` is false. ``known`` are the scalars of
    its longest run as its end tells them, which spare reading a third of what a dataset keeps.

    xarray takes a twentieth of a second to find out about the hundred variables of a run, of which
    a dataset keeps a part.
    """

    def __init__(
        self,
        file: netCDF4.Dataset,
        wanted: Mapping[str, float] | None = None,
        known: Mapping[str, Sequence[Any]] | None = None,
    ):
        file.set_auto_mask(False)
        found = answering(file, wanted) if wanted else file
        self.is_enough, group = found is not None, found or file
        self._first = slice(int(wanted["replicates"]) if wanted else None)
        self._variables = {**file.variables, **group.variables}
        told = known if known and group is file else {}
        self._read = {name: np.array(values)[self._first] for name, values in told.items()}
        self.attrs = {name: file.getncattr(name) for name in file.ncattrs()}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._read:
            held = self._variables[name]
            several = held.dimensions[:1] == ("replicate",)
            values = np.asarray(held[self._first] if several else held[...])
            # Whoever works on them in place would change what others read.
            values.flags.writeable = False
            self._read[name] = values
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def __contains__(self, name: object) -> bool:
        return name in self._variables

    def part(self, name: str, place: Any) -> np.ndarray:
        """Return what stands at a place of a variable of all replicates; no more is read."""
        return np.asarray(self._variables[name][place])

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of the dimensions of a variable, those of letters left out."""
        return self._variables[name].dimensions[: self[name].ndim]

    def variable(self, name: str) -> "xr.Variable":
        """Return a variable with its dimensions and attributes."""
        # Not for those who want numbers alone: it takes a third of a second to import.
        import xarray as xr

        held = self._variables[name]
        attrs = {key: held.getncattr(key) for key in held.ncattrs() if key not in _ENCODING}
        return xr.Variable(self.dims(name), self[name], attrs)


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
