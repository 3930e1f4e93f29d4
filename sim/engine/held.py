"""What a run file that is there holds, and of how much of its point."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from sim.base.files import is_damaged
from sim.base.summary import read_summary
from sim.engine.identity import NUMERICS, numerics_of
from sim.engine.observe.arrays import SNAPSHOTS, TABLES
from sim.engine.observe.recorder import Record
from sim.engine.observe.run_file import Stage
from sim.engine.observe.scalars import SCALARS
from sim.parameters import Parameters, amounts, covers, more, point_id


def current_status(path: Path, parameters: Parameters) -> str:
    """Return the status of a run file if it is current, else an empty text.

    Current is a whole file of the same point and the same numerics that holds as much as is wanted
    or more: a run would write the same numbers again. Other versions of libraries may round
    otherwise and make no file old.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                ours = _is_of(_attributes(file), parameters)
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
            return told["held"] if _is_of(told["attributes"], parameters) else []
        with netCDF4.Dataset(path) as file:
            if _is_of(_attributes(file), parameters):
                return held_amounts(file, amounts(parameters))
    return []


def _attributes(file: netCDF4.Dataset) -> dict[str, Any]:
    return {name: file.getncattr(name) for name in file.ncattrs()}


def _is_of(held: Mapping[str, Any], parameters: Parameters) -> bool:
    return held["point_id"] == point_id(parameters) and numerics_of(held) == NUMERICS


def held_amounts(file: netCDF4.Dataset, names: Iterable[str]) -> list[dict[str, float]]:
    """Return the amounts that an open run file holds, the longest run first."""
    return [{name: float(group[name][...]) for name in names} for group in _groups(file)]


def answering(file: netCDF4.Dataset, wanted: Mapping[str, float]) -> netCDF4.Dataset | None:
    """Return the group of a run file with the least that covers what is wanted; none without any.

    Of its replicates the first are those wanted.
    """
    number = stage_of(held_amounts(file, wanted), wanted)
    return None if number is None else _groups(file)[number]


def _groups(file: netCDF4.Dataset) -> list[netCDF4.Dataset]:
    """Return the groups of a run file that hold all of a run, the longest run first."""
    return [file, *file.groups.values()]


def read_stages(path: Path, parameters: Parameters) -> list[Stage]:
    """Return what a run file of the same point and numerics holds, the longest run first.

    Empty where there is no such file, or it is damaged.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                if _is_of(_attributes(file), parameters):
                    held = held_amounts(file, amounts(parameters))
                    stages = zip(_groups(file), held, strict=True)
                    return [_stage(group, parameters, one) for group, one in stages]
    return []


def _stage(group: netCDF4.Dataset, parameters: Parameters, held: Mapping[str, float]) -> Stage:
    ran = {name: type(getattr(parameters, name))(value) for name, value in held.items()}
    records = [_record(group, index) for index in range(group.dimensions["replicate"].size)]
    return Stage(parameters.model_copy(update=ran), records)


def _record(group: netCDF4.Dataset, index: int) -> Record:
    """Return what a group holds of a replicate."""
    record = Record({})
    for name, variable in group.variables.items():
        dimensions = variable.dimensions
        if dimensions[:1] != ("replicate",) or name == "replicate":
            continue
        values = variable[index]
        if name in SCALARS:
            record.scalars[name] = str(values) if variable.dtype is str else values.item()
        elif name in SNAPSHOTS:
            record.snapshots[name] = list(values) if "frame" in dimensions else [values]
        elif name in TABLES:
            record.tables[name] = values
        elif name == "path":
            record.path = None if np.isnan(values).all() else values
        elif dimensions == ("replicate", "time"):
            record.series[name] = values
        else:
            record.profiles[name] = values
    return record
