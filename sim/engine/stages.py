"""Reads the records of a run file, so that a longer run can continue from them."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np

from sim.base.seals import is_damaged
from sim.engine.observe.recorder import Record
from sim.engine.observe.run_file import Stage
from sim.engine.stored_run import is_run_of, read_attributes, stage_amounts, stage_groups
from sim.parameters import Parameters, amounts
from sim.parameters.variables import SCALARS, variables_of


def read_stages(path: Path, parameters: Parameters) -> list[Stage]:
    """Return the runs in a run file of the same point and numerics, the longest first.

    The list is empty where there is no such file, or where it is damaged.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                if is_run_of(read_attributes(file), parameters):
                    lengths = stage_amounts(file, amounts(parameters))
                    stages = zip(stage_groups(file), lengths, strict=True)
                    return [_read_stage(group, parameters, length) for group, length in stages]
    return []


def _read_stage(
    group: netCDF4.Dataset, parameters: Parameters, lengths: Mapping[str, float]
) -> Stage:
    values = {name: type(getattr(parameters, name))(value) for name, value in lengths.items()}
    records = [_read_record(group, index) for index in range(group.dimensions["replicate"].size)]
    return Stage(parameters.model_copy(update=values), records)


def _read_record(group: netCDF4.Dataset, index: int) -> Record:
    """Return the record of one replicate from a group of a run file."""
    record = Record({})
    for name, variable in group.variables.items():
        dimensions = variable.dimensions
        if dimensions[:1] != ("replicate",) or name == "replicate":
            continue
        values = variable[index]
        if name in SCALARS:
            record.scalars[name] = str(values) if variable.dtype is str else values.item()
        elif name in variables_of("particle"):
            record.snapshots[name] = list(values) if "frame" in dimensions else [values]
        elif dimensions[1:2] == ("trajectory_time",):
            record.frames[name] = values
        elif name == "path":
            record.path = None if np.isnan(values).all() else values
        elif dimensions == ("replicate", "time"):
            record.series[name] = values
        elif dimensions == ("replicate", "height") and not variables_of("profile")[name].asked_by:
            record.profiles[name] = values
        else:
            record.tables[name] = values
    return record
