"""Rows that an earlier dataset of the study has: run files that are the same are not read again."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import netCDF4
import pandas as pd
import xarray as xr

from sim.base.additions import codes
from sim.base.damage import UNREADABLE
from sim.base.files import is_damaged, read_seal, replacing
from sim.base.rooms import files_hash, room_hash
from sim.dataset.results import PARTICLES
from sim.dataset.rows import OF_PROFILES, WORDS, Rows
from sim.engine import identity
from sim.engine.observe import arrays
from sim.parameters.own import OBSERVABLE

#: Group of a dataset that says of each row which run file it was read from, and which variables
#: that had.
RUNS = "runs"

#: Second name of the last dataset of a study, which stays when the workflow, before it makes a new
#: one or when it cannot, removes the first.
EARLIER = ".earlier.nc"


def reading_code() -> str:
    """Return a hash of the code that reads run files; what other code has read is read again.

    Where there are observables of plug-ins, their names and hashes stand behind it.
    """
    return f"{_own_code()} {codes(OBSERVABLE)}".rstrip()


@cache
def _own_code() -> str:
    package = Path(__file__).parents[1]
    names = (Path(module.__file__ or "") for module in (identity, arrays))
    return f"{room_hash(package, 'dataset')} {files_hash(names)}"


def keep(dataset: Path, folder: Path) -> None:
    """Keep a dataset, without its taking room twice where links can be made, for `earlier_rows`."""
    with replacing(folder / EARLIER) as temporary:
        try:
            os.link(dataset, temporary)
        except OSError:
            shutil.copyfile(dataset, temporary)


def earlier_rows(folder: Path, is_shown: Callable[[str], bool]) -> list[Rows]:
    """Return the rows of an earlier dataset that reading their run files again would give.

    Parameters
    ----------
    folder : Path
        Results of the study. Without an earlier dataset, or with one that is damaged or made by
        other code, there are no such rows.
    is_shown : callable
        Tells whether the state of the particles of a point must be there.
    """
    path = folder / EARLIER
    try:
        if path.is_file() and not is_damaged(path):
            return list(_rows(path, folder / "runs", is_shown))
    except UNREADABLE:
        pass
    return []


def _rows(path: Path, runs: Path, is_shown: Callable[[str], bool]) -> Iterator[Rows]:
    with netCDF4.Dataset(path) as file:
        states = set(file.groups[PARTICLES].groups) if PARTICLES in file.groups else set()
    with ExitStack() as stack:

        def opened(group: str | None) -> xr.Dataset:
            """Return a group, of which each variable is read whenever it is asked for."""
            file = xr.open_dataset(path, engine="netcdf4", group=group, cache=False)
            return stack.enter_context(file)

        root, made = opened(None), opened(RUNS)
        if made.attrs["code"] != reading_code():
            return
        table = pd.DataFrame({name: root[name].values for name in ("point", "system")})
        words = [str(name) for name in made]
        table = table.assign(**{name: made[name].values for name in words})
        same = [
            _is_of(runs / f"{point}.nc", seal) and (point in states or not is_shown(point))
            for point, seal in zip(table["point"], table["seal"], strict=True)
        ]
        for (system, variables), some in table[same].groupby(["system", "variables"], sort=False):
            rows, points = some.index.to_numpy(), some["point"].tolist()
            lines = (profiles := opened(system)).indexes["run"].get_indexer(points)
            values = {
                name: profiles[name].values[lines]
                if name in OF_PROFILES
                else root[name].values[rows].astype(object if name in WORDS else float)
                for name in variables.split()
            }
            yield Rows(
                points=points,
                origin={name: some[name].tolist() for name in words if name != "variables"},
                values=values,
                states={
                    point: opened(f"{PARTICLES}/{point}").load()
                    for point in points
                    if is_shown(point)
                },
            )


def _is_of(run: Path, seal: str) -> bool:
    """Return whether a run file still is the one with this seal."""
    try:
        return read_seal(run) == seal
    except OSError:
        return False
