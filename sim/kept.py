"""Whether a run file that is already there is what a run would write."""

from contextlib import suppress
from pathlib import Path

import netCDF4

from sim import __version__
from sim.files import is_damaged
from sim.parameters import Parameters, point_id
from sim.provenance import library_versions, source_hash


def kept_status(path: Path, parameters: Parameters) -> str:
    """Return the status of a whole run file of the same point, code and libraries, or nothing.

    The same code makes the same bits of the same point, so such a file need not be made again:
    what started its run may have ended before the run did.
    """
    wanted = {
        "point_id": point_id(parameters),
        "engine_version": __version__,
        "source_hash": source_hash(),
        "versions": " ".join(f"{name} {number}" for name, number in library_versions().items()),
    }
    with suppress(OSError, AttributeError):
        if not is_damaged(path):
            with netCDF4.Dataset(path) as file:
                if all(file.getncattr(name) == value for name, value in wanted.items()):
                    return file.status
    return ""
