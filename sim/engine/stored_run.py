"""Inspection of an existing run file: its point, its numerics and its amounts."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import netCDF4

from sim.base.errors import InputError
from sim.base.seals import checked_read, read_summary
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

#: What such a file is called in messages.
_KIND = "run file"


def current_status(path: Path, parameters: Parameters) -> str:
    """Return the status of a run file if it is current, else an empty text.

    A file is current if it is undamaged, belongs to the same point and numerics, and has at least
    the amounts of the point: a run would write the same numbers again. Other versions of libraries
    may round differently, but do not make a file old. Raises ``OSError`` where the system does not
    give the bytes of the file.
    """
    with suppress(InputError), open_run_file(path) as file:
        if is_run_of(read_attributes(file), parameters) and find_group(file, amounts(parameters)):
            return str(file.getncattr("status"))
    return ""


def find_stage(stages: Sequence[Mapping[str, float]], minimum: Mapping[str, float]) -> int | None:
    """Return the number of the shortest stage with at least the amounts ``minimum``.

    ``stages`` are amounts, the longest run first; None where all are too short. The first
    replicates of the stage are those of a run of the ``minimum``.
    """
    numbers = [number for number, stage in enumerate(stages) if covers(stage, minimum)]
    return numbers[-1] if numbers else None


def has_enough(path: Path, parameters: Parameters) -> bool:
    """True where a run file of the present numerics has all amounts of its point.

    The file is not checked for damage.
    """
    return find_stage(read_stage_amounts(path, parameters), amounts(parameters)) is not None


def needs_growth(path: Path, parameters: Parameters) -> bool:
    """True where a run file of the present numerics has less than the amounts of its point."""
    stages = read_stage_amounts(path, parameters)
    return bool(stages) and find_stage(stages, amounts(parameters)) is None


def planned_amounts(path: Path, parameters: Parameters) -> dict[str, float]:
    """Return the amounts of a run file after it has grown to those of its point.

    These are its present amounts where they are enough. The file is not checked for damage.
    """
    stages = read_stage_amounts(path, parameters)
    return amounts(with_larger_amounts(parameters, stages[0]) if stages else parameters)


def read_stage_amounts(path: Path, parameters: Parameters) -> list[dict[str, float]]:
    """Return the amounts of each stage of a run file of a point; empty for other numerics.

    Raises ``OSError`` where the system does not give the bytes of the file.
    """
    with suppress(InputError), checked_read(path, _KIND, replaceable=False):
        if summary := read_summary(path):
            return summary["held"] if is_run_of(summary["attributes"], parameters) else []
        with netCDF4.Dataset(path) as file:
            if is_run_of(read_attributes(file), parameters):
                return stage_amounts(file, amounts(parameters))
    return []


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
def open_run_file(path: Path, replaceable: bool = False) -> Iterator[netCDF4.Dataset]:
    """Open a run file, without masks; an error in the block becomes one line.

    Errors and ``replaceable`` are those of `sim.base.seals.checked_read`.
    """
    with checked_read(path, _KIND, replaceable, sealed=True), netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        yield file


def read_parameters(path: Path) -> Parameters:
    """Return the point of a run file, with the amounts in the file.

    Raises
    ------
    InputError
        When there is no such file, or when it is not a run file.
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
    for name, field in SYSTEMS[file.getncattr("system")].model_fields.items():
        if name in file.variables:
            value = file.variables[name][...]
            value = value if isinstance(value, str) else value.item()
            values[name] = bool(value) if field.annotation is bool else value
    return parse_point(values, path)


def read_attributes(file: netCDF4.Dataset) -> dict[str, Any]:
    """Return the global attributes of an open run file."""
    return {name: file.getncattr(name) for name in file.ncattrs()}


def is_run_of(attributes: Mapping[str, Any], parameters: Parameters) -> bool:
    """True where the attributes of a run file name a point and the present numerics."""
    return attributes["point_id"] == point_id(parameters) and numerics_of(attributes) == NUMERICS


def stage_amounts(file: netCDF4.Dataset, names: Iterable[str]) -> list[dict[str, float]]:
    """Return the amounts of each stage of an open run file, the longest run first."""
    return [{name: float(group[name][...]) for name in names} for group in stage_groups(file)]


def find_group(file: netCDF4.Dataset, minimum: Mapping[str, float]) -> netCDF4.Dataset | None:
    """Return the group of the shortest run with at least the amounts ``minimum``, else None.

    The first replicates of the group are those of a run of the ``minimum``.
    """
    number = find_stage(stage_amounts(file, minimum), minimum)
    return None if number is None else stage_groups(file)[number]


def stage_groups(file: netCDF4.Dataset) -> list[netCDF4.Dataset]:
    """Return the groups of a run file with one complete run each, the longest run first."""
    return [file, *file.groups.values()]
