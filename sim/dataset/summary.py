"""The summary of a run, read without opening its file as netCDF where that is possible."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4

from sim.base.seals import is_damaged, read_summary
from sim.dataset.run_file import RunFile
from sim.engine.stored_run import find_stage
from sim.parameters.variables import SCALARS


class Summary(NamedTuple):
    """Global attributes of a run file and its scalars, each over replicates."""

    attrs: dict[str, Any]
    scalars: dict[str, Any]


def summary_of(path: Path, amounts: Mapping[str, float] | None = None) -> Summary:
    """Return the summary of a run file, from its end alone where that has these amounts.

    The summary covers no more than ``amounts``, or all that the file holds if they are omitted.
    A file whose end is not enough is opened. This raises ``OSError`` for a damaged file and, like
    the library, for a file that is no netCDF.
    """
    summary = read_summary(path)
    if summary and (amounts is None or find_stage(summary["held"], amounts) in (0, None)):
        replicates = slice(int(amounts["replicates"]) if amounts else None)
        scalars = {name: values[replicates] for name, values in summary["scalars"].items()}
        return Summary(summary["attributes"], scalars)
    if is_damaged(path):
        raise OSError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        run = RunFile(file, amounts)
        return Summary(run.attrs, {name: run[name] for name in SCALARS if name in run})
