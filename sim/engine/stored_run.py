"""What an existing run file holds: its point, its numerics, how much of the point was run."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import netCDF4

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.base.files import is_damaged
from sim.base.summary import read_summary
from sim.engine.identity import NUMERICS, numerics_of
from sim.parameters import SYSTEMS, Parameters, amounts, covers, more, parse_point, point_id


def current_status(path: Path, parameters: Parameters) -> str:
    """Return the status of a run file if it is current, else an empty text.

    Current is a whole file of the same point and the same numerics that holds as much as is wanted
    or more: a run would write the same numbers again. Other versions of libraries may round
    otherwise and make no file old.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                ours = is_of(attributes(file), parameters)
                if ours and answering(file, amounts(parameters)):
                    return file.status
    return ""


def stage_of(held: Sequence[Mapping[str, float]], wanted: Mapping[str, float]) -> int | None:
    """Return which of the stages that are held, the longest first, has the least of what is enough.

    None where none has. Of its replicates the first are those wanted.
    """
    found = [number for number, stage in enumerate(held) if covers(stage, wanted)]
    return found[-1] if found else None


def holds(path: Path, parameters: Parameters) -> bool:
    """Return whether a run file of the present numerics has all that is wanted of its point.

    Whether it is whole is not looked at.
    """
    return stage_of(_told(path, parameters), amounts(parameters)) is not None


def is_to_grow(path: Path, parameters: Parameters) -> bool:
    """Return whether a run file of the present numerics has less than is wanted of its point."""
    held = _told(path, parameters)
    return bool(held) and stage_of(held, amounts(parameters)) is None


def planned_amounts(path: Path, parameters: Parameters) -> dict[str, float]:
    """Return how much a run file will hold once there is all that is wanted of its point.

    That is as much as it holds now, where this is enough. Whether it is whole is not looked at.
    """
    held = _told(path, parameters)
    return amounts(more(parameters, held[0]) if held else parameters)


def _told(path: Path, parameters: Parameters) -> list[dict[str, float]]:
    """Return the amounts that a run file of a point and of the present numerics says it holds."""
    with suppress(OSError, LookupError, ValueError):
        if told := read_summary(path):
            return told["held"] if is_of(told["attributes"], parameters) else []
        with netCDF4.Dataset(path) as file:
            if is_of(attributes(file), parameters):
                return held_amounts(file, amounts(parameters))
    return []


def started_at(path: Path) -> list[int]:
    """Return how many samples the replicates of another run had taken that these started from.

    Empty for a run that starts as in the paper, and where there is no run file.
    """
    with suppress(OSError, ValueError), netCDF4.Dataset(path) as file:
        return [int(number) for number in getattr(file, "origin", "").split()]
    return []


@contextmanager
def opened(path: Path, replaceable: bool = False) -> Iterator[netCDF4.Dataset]:
    """Open a run file, without masks; whatever goes wrong in the block becomes one line.

    Raises as `sim.base.damage.checked_read` does, which says what ``replaceable`` is.
    """
    with checked_read(path, "run file", replaceable, sealed=True), netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        yield file


def read_parameters(path: Path) -> Parameters:
    """Return the point of a run file, with how much of it the file holds.

    Raises
    ------
    InputError
        When there is no such file, or it is not a run file.
    """
    with opened(path) as file:
        return parameters_of(file, path)


def parameters_of(file: netCDF4.Dataset, path: Path) -> Parameters:
    """Return the point of an open run file, from the scalar variables named like its parameters.

    Raises `InputError` for a dataset, ``ValueError`` for what else is no run file.
    """
    if "study" in file.ncattrs():
        raise InputError(f"{path}: the dataset of study {file.study}, not a run file")
    if not {"point_id", "system", "status"} <= set(file.ncattrs()):
        raise ValueError("no point in it")
    values = {}
    for name, field in SYSTEMS[file.getncattr("system")].model_fields.items():
        if name in file.variables:
            value = file.variables[name][...]
            value = value if isinstance(value, str) else value.item()
            values[name] = bool(value) if field.annotation is bool else value
    return parse_point(values, path)


def attributes(file: netCDF4.Dataset) -> dict[str, Any]:
    """Return the global attributes of an open run file."""
    return {name: file.getncattr(name) for name in file.ncattrs()}


def is_of(held: Mapping[str, Any], parameters: Parameters) -> bool:
    """Return whether a run file with these attributes is of a point and of the present numerics."""
    return held["point_id"] == point_id(parameters) and numerics_of(held) == NUMERICS


def held_amounts(file: netCDF4.Dataset, names: Iterable[str]) -> list[dict[str, float]]:
    """Return the amounts that an open run file holds, the longest run first."""
    return [{name: float(group[name][...]) for name in names} for group in groups(file)]


def answering(file: netCDF4.Dataset, wanted: Mapping[str, float]) -> netCDF4.Dataset | None:
    """Return the group of a run file with the least that covers what is wanted; none without any.

    Of its replicates the first are those wanted.
    """
    number = stage_of(held_amounts(file, wanted), wanted)
    return None if number is None else groups(file)[number]


def groups(file: netCDF4.Dataset) -> list[netCDF4.Dataset]:
    """Return the groups of a run file that hold all of a run, the longest run first."""
    return [file, *file.groups.values()]
