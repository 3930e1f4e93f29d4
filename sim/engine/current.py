"""Whether a run file that is already there is what a run would write."""

from contextlib import suppress
from pathlib import Path

import netCDF4

from sim.base.files import is_damaged
from sim.engine.identity import NUMERICS, numerics_of
from sim.parameters import Parameters, point_id


def current_status(path: Path, parameters: Parameters) -> str:
    """Return the status of a run file if it is current, else an empty text.

    Current is a whole file of the same point and the same numerics: a run would write the same
    numbers again. Other versions of libraries may round otherwise and make no file old.
    """
    with suppress(OSError, LookupError, ValueError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                held = {name: file.getncattr(name) for name in file.ncattrs()}
            if held["point_id"] == point_id(parameters) and numerics_of(held) == NUMERICS:
                return held["status"]
    return ""
