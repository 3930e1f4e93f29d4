"""What a run says of itself in a few words, read without opening its file where that can be."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4

from sim.base.files import is_damaged
from sim.base.summary import read_summary
from sim.dataset.run_file import RunFile
from sim.engine.stored_run import stage_of
from sim.parameters.variables import SCALARS


class Summary(NamedTuple):
    """Global attributes of a run file, and its scalars, each over replicates."""

    attrs: dict[str, Any]
    scalars: dict[str, Any]


def summary_of(path: Path, wanted: Mapping[str, float] | None = None) -> Summary:
    """Return the summary of a run file, from its end alone where it has what is wanted there.

    It is as if no more than ``wanted`` had been run; of all that the file holds if omitted. Other
    files are opened. They are not if they are damaged: then this raises ``OSError``, as it does,
    like the library, for files that hold something else.
    """
    found = read_summary(path)
    if found and (wanted is None or stage_of(found["held"], wanted) in (0, None)):
        first = slice(int(wanted["replicates"]) if wanted else None)
        scalars = {name: values[first] for name, values in found["scalars"].items()}
        return Summary(found["attributes"], scalars)
    if is_damaged(path):
        raise OSError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        run = RunFile(file, wanted)
        return Summary(run.attrs, {name: run[name] for name in SCALARS if name in run})
