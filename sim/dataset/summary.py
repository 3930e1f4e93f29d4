"""What a run says of itself in a few words, read without opening its file where that can be."""

from pathlib import Path
from typing import Any, NamedTuple

from sim.base.files import is_damaged
from sim.base.summary import read_summary
from sim.engine.observe.scalars import SCALARS


class Summary(NamedTuple):
    """Global attributes of a run file, and its scalars, each over replicates."""

    attrs: dict[str, Any]
    scalars: dict[str, Any]


def summary_of(path: Path) -> Summary:
    """Return the summary of a run file, from its end alone where it has one there.

    Files without are opened. They are not if they are damaged: then this raises ``OSError``, as it
    does, like the library, for files that hold something else.
    """
    if found := read_summary(path):
        return Summary(found["attributes"], found["scalars"])
    if is_damaged(path):
        raise OSError("the checksum is wrong")
    import netCDF4

    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        attrs = {name: file.getncattr(name) for name in file.ncattrs()}
        return Summary(attrs, {name: file[name][:] for name in SCALARS if name in file.variables})
