"""The records that a run file holds, for a run to go on from them."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np

from sim.base.files import is_damaged
from sim.engine.observe.recorder import Record
from sim.engine.observe.run_file import Stage
from sim.engine.stored_run import attributes, groups, held_amounts, is_of
from sim.parameters import Parameters, amounts
from sim.parameters.variables import SCALARS, variables


def read_stages(path: Path, parameters: Parameters) -> list[Stage]:
    """Return the runs in a run file of the same point and numerics, the longest first.

    Empty where there is no such file, or it is damaged.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                if is_of(attributes(file), parameters):
                    held = held_amounts(file, amounts(parameters))
                    stages = zip(groups(file), held, strict=True)
                    return [_stage(group, parameters, one) for group, one in stages]
    return []


def _stage(group: netCDF4.Dataset, parameters: Parameters, held: Mapping[str, float]) -> Stage:
    ran = {name: type(getattr(parameters, name))(value) for name, value in held.items()}
    records = [_record(group, index) for index in range(group.dimensions["replicate"].size)]
    return Stage(parameters.model_copy(update=ran), records)


def _record(group: netCDF4.Dataset, index: int) -> Record:
    """Return all that a group of a run file holds of one replicate."""
    record = Record({})
    for name, variable in group.variables.items():
        dimensions = variable.dimensions
        if dimensions[:1] != ("replicate",) or name == "replicate":
            continue
        values = variable[index]
        if name in SCALARS:
            record.scalars[name] = str(values) if variable.dtype is str else values.item()
        elif name in variables("particle"):
            record.snapshots[name] = list(values) if "frame" in dimensions else [values]
        elif dimensions[1:2] == ("trajectory_time",):
            record.frames[name] = values
        elif name == "path":
            record.path = None if np.isnan(values).all() else values
        elif dimensions == ("replicate", "time"):
            record.series[name] = values
        elif dimensions == ("replicate", "height") and not variables("profile")[name].asked_by:
            record.profiles[name] = values
        else:
            record.tables[name] = values
    return record
