"""The reader of run files: their point, numerics and amounts, and their arrays by name.

A file is whole, or reduced to the row of a dataset that was adopted: it has no series and no state
to go on from, and may lack profiles and particles. Attribute ``reduced`` says what it has of these,
in the order of a need (`sim.study.model.Need`).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import netCDF4
import numpy as np

from sim.base.additions import codes
from sim.base.errors import InputError
from sim.base.files import file_version
from sim.base.seals import checked_read, is_damaged, read_summary
from sim.engine.identity import NUMERICS, numerics_of
from sim.parameters import (
    SYSTEMS,
    Parameters,
    amounts,
    covers,
    parse_point,
    point_id,
    with_larger_amounts,
)
from sim.parameters.given import remember_text
from sim.parameters.variables import OBSERVABLE, SCALARS, observable_variables

if TYPE_CHECKING:
    import xarray as xr


#: What such a file is called in messages.
_KIND = "run file"

#: Variable with the particles from which the flow started, where they were given.
STATE_TABLE = "initial_state_table"

#: Group of a reduced run file with its particles.
STATE = "state"

#: What must be stored of a point besides scalars, least to most; None where the run must be whole.
Levels = Sequence[int] | None


def has_all(attributes: Mapping[str, Any], need: Levels) -> bool:
    """True where a run file is whole, or has all that is needed of its point."""
    if (held := attributes.get("reduced")) is None:
        return True
    has_levels = need is not None and all(
        have >= level for have, level in zip(held, need, strict=True)
    )
    return has_levels and measured_codes(attributes["system"]) <= {*attributes["measured"].split()}


def measured_codes(system: str | None = None) -> set[str]:
    """Return names and hashes of the observables of plug-ins, of a system or of all.

    A whole run is measured anew for them.
    """
    names = observable_variables(system).keys()
    return {code for code in codes(OBSERVABLE).split() if code.rpartition(".")[0] in names}


def require_all(attributes: Mapping[str, Any], path: Path, need: Levels = None) -> None:
    """Raise `InputError` where a reduced run file lacks something of a need."""
    if not has_all(attributes, need):
        raise InputError(
            f"{path}: only a row of a dataset that was adopted, without the series, particles or "
            "observables that are needed here; rerun the study, which runs its point"
        )


def starts_to_run(
    runs: Path, points: Mapping[str, Parameters], need: Callable[[str], Levels]
) -> set[str]:
    """Return the points whose reduced run file will not do: one that is to be run starts from it.

    ``runs`` is the folder of the run files, ``points`` and what is needed of them are by id.
    """

    def lacks(key: str) -> bool:
        return not has_enough(runs / f"{key}.nc", points[key], need(key))

    to_run = [key for key, one in points.items() if one.start_from in points and lacks(key)]
    found: set[str] = set()
    for key in to_run:
        start = points[key].start_from
        if start not in points or start in found or lacks(start):
            continue
        if not has_enough(runs / f"{start}.nc", points[start]):
            found.add(start)
            to_run.append(start)
    return found


def current_status(path: Path, parameters: Parameters, need: Levels = None) -> str:
    """Return the status of a run file if it is current, else an empty text.

    A file is current if it is undamaged, belongs to the same point and numerics, and has at least
    the amounts of the point: a run would write the same numbers again, besides what a reduced
    file has of the ``need``. Other versions of libraries may round differently, but do not make a
    file old. Raises ``OSError`` where the system does not give the bytes of the file.
    """
    with suppress(InputError), open_run_file(path) as file:
        if has_enough(path, parameters, need):
            return str(file.status)
    return ""


def has_enough(path: Path, parameters: Parameters, need: Levels = None) -> bool:
    """True where a run file of the present numerics has all amounts of its point.

    A reduced one must have what is needed, too. The file is not checked for damage.
    """
    held = read_amounts(path, parameters, need)
    return held is not None and covers(held, amounts(parameters))


def needs_growth(path: Path, parameters: Parameters, need: Levels = None) -> bool:
    """True where a run file of the present numerics has less than is needed of its point."""
    return _read_held(path, parameters) is not None and not has_enough(path, parameters, need)


def is_reduced(path: Path, parameters: Parameters) -> bool:
    """True where a point has a run file of the present numerics that is a row of a dataset."""
    held = _read_held(path, parameters)
    return held is not None and not has_all(held[0], None)


def planned_amounts(path: Path, parameters: Parameters, need: Levels = None) -> dict[str, float]:
    """Return the amounts of a run file after it has grown to those of its point.

    These are its present amounts where they are enough. The file is not checked for damage.
    """
    held = read_amounts(path, parameters, need)
    return amounts(with_larger_amounts(parameters, held) if held else parameters)


def read_amounts(
    path: Path, parameters: Parameters, need: Levels = None
) -> dict[str, float] | None:
    """Return the amounts of a run file of a point.

    None for other numerics, and where a reduced file lacks something of the ``need``. Raises
    ``OSError`` where the system does not give the bytes of the file.
    """
    held = _read_held(path, parameters)
    return held[1] if held and has_all(held[0], need) else None


#: Attributes and amounts of a run file.
_Held = tuple[dict[str, Any], dict[str, float]]


def _read_held(path: Path, parameters: Parameters) -> _Held | None:
    """Return what a run file holds of a point, None where it has none of the present numerics."""
    with suppress(InputError), checked_read(path, _KIND, replaceable=False):
        held = _held_by(path, file_version(path), tuple(amounts(parameters)))
        if is_run_of(held[0], parameters):
            return held
    return None


@lru_cache(100_000)
def _held_by(path: Path, version: tuple[int, ...], names: tuple[str, ...]) -> _Held:
    """Return what a version of a run file holds, from its end alone where that says it."""
    if summary := read_summary(path):
        return summary["attributes"], summary["held"][0]
    with netCDF4.Dataset(path) as file:
        return read_attributes(file), amounts_of(file, names)


def length_of(run: Parameters | Mapping[str, float]) -> dict[str, float]:
    """Return those of the amounts of a run that set the length of its replicates."""
    held = run if isinstance(run, Mapping) else amounts(run)
    return {name: value for name, value in held.items() if name != "replicates"}


def is_alike(first: Sequence[int], second: Sequence[int]) -> bool:
    """True where the replicates that two sequences have in common started at the same sample."""
    return all(a == b for a, b in zip(first, second, strict=False))


def read_origin_samples(path: Path) -> list[int]:
    """Return the samples of each replicate of another run when the replicates started from it.

    Empty for a run that starts as in the paper, and where there is no run file.
    """
    with suppress(InputError), open_run_file(path) as file:
        return [int(number) for number in getattr(file, "origin", "").split()]
    return []


@contextmanager
def open_run_file(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a run file, without masks; an error in the block becomes one line.

    Errors are those of `sim.base.seals.checked_read`.
    """
    read = checked_read(path, _KIND, replaceable=False, sealed=True)
    with read, netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        yield file


def read_parameters(path: Path) -> Parameters:
    """Return the point of a run file, with the amounts in the file.

    Raises `InputError` where there is no such file, or where it is no run file.
    """
    with open_run_file(path) as file:
        return parameters_of(file, path)


def parameters_of(file: netCDF4.Dataset, path: Path) -> Parameters:
    """Return the point of an open run file, from the scalar variables named like its parameters.

    Raises `InputError` for a dataset, ``ValueError`` for other files that are no run files.
    """
    if "study" in file.ncattrs():
        raise InputError(f"{path}: the dataset of study {file.study}, not a run file")
    if not {"point_id", "system", "status"} <= set(file.ncattrs()):
        raise ValueError("it has no point")
    values = {}
    system = str(file.getncattr("system"))
    if system not in SYSTEMS:
        allowed = f"one of {', '.join(SYSTEMS)}, or that of a plug-in that TALUS_PLUGINS names"
        raise InputError.of_value(path, "system", system, allowed)
    for name, field in SYSTEMS[system].model_fields.items():
        if name in file.variables:
            value = file.variables[name][...]
            value = value if isinstance(value, str) else value.item()
            values[name] = bool(value) if field.annotation is bool else value
    if STATE_TABLE in file.variables:
        remember_text(str(file.variables[STATE_TABLE][...]), path)
    return parse_point(values, path)


def read_attributes(file: netCDF4.Dataset) -> dict[str, Any]:
    """Return the global attributes of an open run file."""
    return {name: file.getncattr(name) for name in file.ncattrs()}


def is_run_of(attributes: Mapping[str, Any], parameters: Parameters) -> bool:
    """True where the attributes of a run file name a point and the present numerics."""
    return attributes["point_id"] == point_id(parameters) and numerics_of(attributes) == NUMERICS


def amounts_of(file: netCDF4.Dataset, names: Iterable[str]) -> dict[str, float]:
    """Return the amounts of an open run file."""
    return {name: float(file[name][...]) for name in names}


# Run files as arrays by name, each read at its first access, and the summary at their end.

#: Attributes that say how values are stored.
_ENCODING = ("_FillValue", "_Encoding")


class _Arrays(Mapping[str, Any]):
    """Names of the variables of an open run file; subclasses read their arrays."""

    _variables: dict[str, netCDF4.Variable]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def __contains__(self, name: object) -> bool:
        return name in self._variables


class RunFile(_Arrays):
    """An open run file, limited to some amounts; ``attrs`` are its global attributes.

    A file that holds less gives all it has, and ``is_enough`` is false. Of a longer run it gives
    the first replicates. xarray would take a twentieth of a second to look at the hundred variables
    of a run. ``amounts`` are those that are wanted (`sim.parameters.points`), by default
    everything. ``summary_scalars``, those of the summary at the end of the file, spare reading a
    third of what a dataset stores.
    """

    def __init__(
        self,
        file: netCDF4.Dataset,
        amounts: Mapping[str, float] | None = None,
        summary_scalars: Mapping[str, Sequence[Any]] | None = None,
    ):
        file.set_auto_mask(False)
        self.is_enough = not amounts or covers(amounts_of(file, amounts), amounts)
        self._replicates = slice(int(amounts["replicates"]) if amounts else None)
        self._variables = file.variables
        scalars = (summary_scalars or {}).items()
        self._cache = {name: np.array(values)[self._replicates] for name, values in scalars}
        self.attrs = read_attributes(file)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._cache:
            variable = self._variables[name]
            has_replicates = variable.dimensions[:1] == ("replicate",)
            values = np.asarray(variable[self._replicates] if has_replicates else variable[...])
            # The array is shared: a change in place would change what other callers read.
            values.flags.writeable = False
            self._cache[name] = values
        return self._cache[name]

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


class Replicate(_Arrays):
    """The arrays of one replicate of a run file, and those that all replicates share, by name."""

    def __init__(self, run: RunFile, index: int):
        self._run, self._index, self._variables = run, index, run._variables

    def __getitem__(self, name: str) -> Any:
        values = self._run[name]
        return values[self._index] if "replicate" in self._run.dims(name) else values


class NamedValues(Protocol):
    """A mapping, a dataset, a place of a claim: any object with values by name."""

    def __getitem__(self, name: str, /) -> Any: ...


class Summary(NamedTuple):
    """Global attributes of a run file and its scalars, each over replicates."""

    attrs: dict[str, Any]
    scalars: dict[str, Any]


def summary_of(path: Path, amounts: Mapping[str, float] | None = None) -> Summary:
    """Return the summary of a run file, from its end alone where that has these amounts.

    The summary has no more replicates than ``amounts``, or all if they are omitted. A file whose
    end does not say it is opened. This raises ``OSError`` for a damaged file and, like the library,
    for a file that is no netCDF.
    """
    summary = read_summary(path)
    if summary:
        replicates = slice(int(amounts["replicates"]) if amounts else None)
        scalars = {name: values[replicates] for name, values in summary["scalars"].items()}
        return Summary(summary["attributes"], scalars)
    if is_damaged(path):
        raise OSError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        run = RunFile(file, amounts)
        return Summary(run.attrs, {name: run[name] for name in SCALARS if name in run})
