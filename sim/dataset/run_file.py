"""Run files as arrays by name, the summary at their end, and those that points start from.

Each array is read at its first access.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import netCDF4
import numpy as np

from sim.base.errors import InputError
from sim.base.seals import is_damaged, read_summary
from sim.engine.stored_run import find_group, find_stage, read_parameters, require_all
from sim.parameters import RUN_FILE, Parameters, require_compatible_source
from sim.parameters.variables import SCALARS
from sim.study.model import Study

if TYPE_CHECKING:
    import xarray as xr


#: Attributes that say how values are stored.
_ENCODING = ("_FillValue", "_Encoding")


class RunFile(Mapping[str, np.ndarray]):
    """An open run file, limited to some amounts; ``attrs`` are its global attributes.

    A file that holds less gives all it has, and ``is_enough`` is false.

    This does without xarray, which takes a twentieth of a second to look at the hundred variables
    of a run. A dataset stores only some of them.

    Parameters
    ----------
    file : netCDF4.Dataset
        The run file.
    amounts : mapping, optional
        The amounts to read, see `sim.parameters.points`; everything if omitted.
    summary_scalars : mapping, optional
        Scalars of the longest run, from the summary at the end of the file. They spare reading a
        third of what a dataset stores.
    """

    def __init__(
        self,
        file: netCDF4.Dataset,
        amounts: Mapping[str, float] | None = None,
        summary_scalars: Mapping[str, Sequence[Any]] | None = None,
    ):
        file.set_auto_mask(False)
        stage = find_group(file, amounts) if amounts else file
        self.is_enough, group = stage is not None, stage or file
        self._replicates = slice(int(amounts["replicates"]) if amounts else None)
        self._variables = {**file.variables, **group.variables}
        scalars = summary_scalars if summary_scalars and group is file else {}
        self._cache = {name: np.array(values)[self._replicates] for name, values in scalars.items()}
        self.attrs = {name: file.getncattr(name) for name in file.ncattrs()}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._cache:
            variable = self._variables[name]
            has_replicates = variable.dimensions[:1] == ("replicate",)
            values = np.asarray(variable[self._replicates] if has_replicates else variable[...])
            # The array is shared: a change in place would change what other callers read.
            values.flags.writeable = False
            self._cache[name] = values
        return self._cache[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def __contains__(self, name: object) -> bool:
        return name in self._variables

    def require_whole(self, path: Path) -> None:
        """Raise `InputError` where the file is reduced, so that it has no series and no states."""
        require_all(self.attrs, path)

    def read_slice(self, name: str, index: Any) -> np.ndarray:
        """Read one slice of a variable, over all its replicates, without loading the rest."""
        return np.asarray(self._variables[name][index])

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the names of the dimensions of a variable, without those of letters."""
        return self._variables[name].dimensions[: self[name].ndim]

    def variable(self, name: str) -> "xr.Variable":
        """Return a variable with its dimensions and attributes."""
        # Imported here, because it takes a third of a second and most callers need numbers only.
        import xarray as xr

        stored = self._variables[name]
        attrs = {key: stored.getncattr(key) for key in stored.ncattrs() if key not in _ENCODING}
        return xr.Variable(self.dims(name), self[name], attrs)


class Replicate(Mapping[str, Any]):
    """The arrays of one replicate of a run file, and those that all replicates share, by name."""

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


class NamedValues(Protocol):
    """A mapping, a dataset, a place of a claim: any object with values by name."""

    def __getitem__(self, name: str, /) -> Any: ...


class Summary(NamedTuple):
    """Global attributes of a run file and its scalars, each over replicates."""

    attrs: dict[str, Any]
    scalars: dict[str, Any]


def summary_of(path: Path, amounts: Mapping[str, float] | None = None) -> Summary:
    """Return the summary of a run file, from its end alone where that has these amounts.

    The summary covers no more than ``amounts``, or all that the file holds if they are omitted.
    A file whose end is not enough is opened. This raises ``OSError`` for a damaged file and, like
    the library, for a file that is no netCDF.
    """
    summary = read_summary(path)
    if summary and (amounts is None or find_stage(summary["held"], amounts) in (0, None)):
        replicates = slice(int(amounts["replicates"]) if amounts else None)
        scalars = {name: values[replicates] for name, values in summary["scalars"].items()}
        return Summary(summary["attributes"], scalars)
    if is_damaged(path):
        raise OSError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        run = RunFile(file, amounts)
        return Summary(run.attrs, {name: run[name] for name in SCALARS if name in run})


def require_start_files(study: Study) -> None:
    """Refuse a run file that a point of a study cannot start from.

    Points that start from other points of the study were checked when the study was loaded.

    Raises
    ------
    InputError
        When it is damaged or no run file, or a flow of the point cannot go on from its flow.
    """

    @cache
    def read_start(start: str) -> Parameters:
        try:
            return read_parameters(Path(start))
        except InputError as error:
            raise InputError(f"{study.path}: start_from: {error}") from None

    for point in study.points.values():
        if (start := point.parameters.start_from).endswith(RUN_FILE):
            require_compatible_source(point.parameters, read_start(start), str(study.path))
