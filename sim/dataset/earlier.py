"""Rows that datasets have already: an earlier one of the study, and adopted ones."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.additions import codes
from sim.base.damage import UNREADABLE
from sim.base.files import is_damaged, read_seal, replacing
from sim.base.rooms import files_hash, room_hash
from sim.dataset.gather import STATE, as_text
from sim.dataset.results import PARTICLES, RUNS
from sim.dataset.rows import OF_PROFILES, WORDS, Rows, dimensions, row_arrays, row_scalars
from sim.engine import identity
from sim.parameters.own import OBSERVABLE, own_observables
from sim.parameters.variables import ALL
from sim.study.catalogue import Shown

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
    names = [Path(identity.__file__)]
    return f"{room_hash(package, 'dataset')} {files_hash(names)}"


def names_read(system: str | None = None) -> set[str]:
    """Return the names of all variables that this code reads from run files of a system, or of all.

    Those of an observable of a plug-in are its name, and its name with the hash of the plug-in.
    """
    own = own_observables(system)
    coded = (code for code in codes(OBSERVABLE).split() if code.rpartition(".")[0] in own)
    return {*row_scalars(system), *row_arrays(system), *STATE, *coded}


def names_unknown(made: Any, system: str) -> list[str]:
    """Return the variables that this code reads and that the writer of a dataset did not know.

    Parameters
    ----------
    made : netCDF4.Dataset
        Its group `RUNS`.
    system : str
        The system whose runs it is of.
    """
    known = made.getncattr("reads") if "reads" in made.ncattrs() else ""
    if system not in ALL:
        # One that a later version has.
        return [system]
    return sorted(names_read(system) - set(known.split()))


def keep(dataset: Path, folder: Path) -> None:
    """Keep a dataset, without its taking room twice where links can be made, for `earlier_rows`."""
    with replacing(folder / EARLIER) as temporary:
        try:
            os.link(dataset, temporary)
        except OSError:
            shutil.copyfile(dataset, temporary)


def particles_held(states: Mapping[str, netCDF4.Dataset], point: str) -> Shown:
    """Return what the groups of states in a dataset have of the particles of a point."""
    if point not in states:
        return Shown.NOTHING
    return Shown.PATH if "path" in states[point].variables else Shown.STATE


def earlier_rows(folder: Path, shown: Callable[[str], Shown]) -> list[Rows]:
    """Return the rows of an earlier dataset that reading their run files again would give.

    Parameters
    ----------
    folder : Path
        Results of the study. Without an earlier dataset, or with one that is damaged or made by
        other code, there are no such rows.
    shown : callable
        Tells what must be there of the particles of a point.
    """
    path, runs = folder / EARLIER, folder / "runs"

    def is_same(point: str, seal: str, code: str) -> bool:
        return code == reading_code() and _is_of(runs / f"{point}.nc", seal)

    try:
        if path.is_file() and not is_damaged(path):
            return list(_rows(path, is_same, shown))
    except UNREADABLE:
        pass
    return []


def adopted_rows(
    path: Path, wanted: Mapping[str, Mapping[str, float]], shown: Callable[[str], Shown]
) -> list[Rows]:
    """Return the rows of points in an adopted dataset, as if no more replicates had been run.

    Parameters
    ----------
    path : Path
        The dataset, which has all that is wanted; its name ends in the origin of the rows.
    wanted : mapping
        How much is wanted of each of these points, by id.
    shown : callable
        Tells what must be there of the particles of a point.
    """
    blocks = _rows(path, lambda point, *_: point in wanted, shown)
    return [_as_wanted(block, wanted, path.stem) for block in blocks]


def _as_wanted(block: Rows, wanted: Mapping[str, Mapping[str, float]], adopted: str) -> Rows:
    """Return rows of an adopted dataset without the replicates that are not wanted."""
    counts = np.array([wanted[point]["replicates"] for point in block.points])
    values = {}
    for name, held in block.values.items():
        values[name] = held
        if dimensions(name)[0] == "replicate":
            values[name] = held.copy()
            beyond = np.arange(held.shape[1]) >= counts[:, np.newaxis]
            values[name][beyond] = "" if name in WORDS else np.nan
    texts = [as_text(wanted[point]) for point in block.points]
    origin = block.origin | {"wanted": texts, "adopted": [adopted] * len(texts)}
    return block._replace(origin=origin, values=values)


def _rows(
    path: Path, is_taken: Callable[[str, str, str], bool], shown: Callable[[str], Shown]
) -> Iterator[Rows]:
    """Yield the rows of a dataset that are taken, told by point, seal and code that has read it.

    What the present code does not know is left out.
    """
    with netCDF4.Dataset(path) as file:
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        particles = {point: particles_held(states, point) for point in states}
    with ExitStack() as stack:

        def opened(group: str | None) -> xr.Dataset:
            """Return a group, of which each variable is read whenever it is asked for."""
            file = xr.open_dataset(path, engine="netcdf4", group=group, cache=False)
            return stack.enter_context(file)

        root, made = opened(None), opened(RUNS)
        known = names_read()
        table = pd.DataFrame({name: root[name].values for name in ("point", "system")})
        words = [str(name) for name in made]
        origin = [name for name in words if name not in ("variables", "adopted")]
        table = table.assign(**{name: made[name].values for name in words})
        same = [
            is_taken(point, seal, made.attrs["code"])
            and particles.get(point, Shown.NOTHING) >= shown(point)
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
                if name in known
            }
            yield Rows(
                points=points,
                origin={name: some[name].tolist() for name in origin}
                | {"adopted": [""] * len(points)},
                values=values,
                states={
                    point: opened(f"{PARTICLES}/{point}").load() for point in points if shown(point)
                },
            )


def _is_of(run: Path, seal: str) -> bool:
    """Return whether a run file still is the one with this seal."""
    try:
        return read_seal(run) == seal
    except OSError:
        return False
