"""Rows reused from existing datasets: the earlier one of the study, and adopted ones."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.additions import codes
from sim.base.files import atomic_write
from sim.base.rooms import files_hash, room_hash
from sim.base.seals import UNREADABLE, is_damaged, read_seal
from sim.dataset.gather import STATE_VARIABLES, amounts_text
from sim.dataset.results import PARTICLES, RUNS
from sim.dataset.rows import (
    OF_PROFILES,
    WORDS,
    Rows,
    dimensions,
    row_arrays,
    row_scalars,
    select_rows,
)
from sim.engine import identity
from sim.parameters import Parameters, amounts
from sim.parameters.variables import ALL, OBSERVABLE
from sim.study.plot_kinds import Shown

#: Second name of the last dataset of a study. It stays when the workflow removes ``dataset.nc``,
#: which happens before it makes a new one and when it fails to.
EARLIER_FILE = ".earlier.nc"


def reader_hash() -> str:
    """Return a hash of the code that reads run files; rows that other code has read are read again.

    The names and hashes of observables of plug-ins, if there are any, follow it.
    """
    return f"{_package_hash()} {codes(OBSERVABLE)}".rstrip()


@cache
def _package_hash() -> str:
    package = Path(__file__).parents[1]
    names = [Path(identity.__file__)]
    return f"{room_hash(package, 'dataset')} {files_hash(names)}"


def stored_names(system: str | None = None) -> set[str]:
    """Return the names of all variables that this code stores of a system, or of all systems.

    Observables of plug-ins come with their names and hashes too.
    """
    scalars = row_scalars(system)
    own_codes = (code for code in codes(OBSERVABLE).split() if code.rpartition(".")[0] in scalars)
    return {*scalars, *row_arrays(system), *STATE_VARIABLES, *own_codes}


def missing_variables(group: Any, system: str) -> list[str]:
    """Return the variables that this version stores and the writer of a dataset did not know.

    Parameters
    ----------
    group : netCDF4.Dataset
        Group `RUNS` of the dataset.
    system : str
        The system whose variables are meant.
    """
    reads = group.getncattr("reads") if "reads" in group.ncattrs() else ""
    if system not in ALL:
        # A system of a later version.
        return [system]
    return sorted(stored_names(system) - set(reads.split()))


def keep_dataset(dataset: Path, folder: Path) -> None:
    """Keep a dataset for `EarlierDataset`: a hard link, or a copy where links are impossible."""
    with atomic_write(folder / EARLIER_FILE) as temporary:
        try:
            os.link(dataset, temporary)
        except OSError:
            shutil.copyfile(dataset, temporary)


def stored_particles(states: Mapping[str, netCDF4.Dataset], point: str) -> Shown:
    """Return how much of the particles of a point a dataset stores in its groups of states."""
    if point not in states:
        return Shown.NOTHING
    return Shown.PATH if "path" in states[point].variables else Shown.STATE


class EarlierDataset:
    """The rows of the earlier dataset that equal what their run files would give again.

    Parameters
    ----------
    folder : Path
        Results of the study. There are no such rows without an earlier dataset, or if that is
        damaged or was made by other code.
    particle_need : callable
        Returns how much must be stored of the particles of a point, by its id.
    """

    def __init__(self, folder: Path, particle_need: Callable[[str], Shown]):
        path, runs = folder / EARLIER_FILE, folder / "runs"
        self._blocks: list[Rows] = []

        def is_same(point: str, seal: str, code: str) -> bool:
            return code == reader_hash() and _has_seal(runs / f"{point}.nc", seal)

        with suppress(*UNREADABLE):
            if path.is_file() and not is_damaged(path):
                self._blocks = list(_read_rows(path, is_same, particle_need))

    def rows(self, points: Mapping[str, Parameters]) -> list[Rows]:
        """Return the rows of points with exactly these amounts."""
        texts = {point: amounts_text(amounts(value)) for point, value in points.items()}
        same = {
            point
            for block in self._blocks
            for point, text in zip(block.points, block.origin["wanted"], strict=True)
            if text == texts.get(point)
        }
        return select_rows(self._blocks, same)


def adopted_rows(
    path: Path,
    points: Mapping[str, Parameters],
    particle_need: Callable[[str], Shown],
) -> list[Rows]:
    """Return the rows of points in an adopted dataset, without replicates beyond their amounts.

    Parameters
    ----------
    path : Path
        The dataset, which has at least these amounts. Its stem becomes the origin of the rows.
    points : mapping
        The points, by id.
    particle_need : callable
        Returns how much must be stored of the particles of a point, by its id.
    """
    blocks = _read_rows(path, lambda point, *_: point in points, particle_need)
    return [_trim_replicates(block, points, path.stem) for block in blocks]


def _trim_replicates(block: Rows, points: Mapping[str, Parameters], dataset: str) -> Rows:
    """Return the rows of an adopted dataset with the replicates beyond the amounts left empty."""
    counts = np.array([points[point].replicates for point in block.points])
    values = {}
    for name, array in block.values.items():
        values[name] = array
        if dimensions(name)[0] == "replicate":
            values[name] = array.copy()
            is_beyond = np.arange(array.shape[1]) >= counts[:, np.newaxis]
            values[name][is_beyond] = "" if name in WORDS else np.nan
    texts = [amounts_text(amounts(points[point])) for point in block.points]
    origin = block.origin | {"wanted": texts, "adopted": [dataset] * len(texts)}
    return block._replace(origin=origin, values=values)


def _read_rows(
    path: Path,
    is_selected: Callable[[str, str, str], bool],
    particle_need: Callable[[str], Shown],
) -> Iterator[Rows]:
    """Yield the selected rows of a dataset that store enough of the particles.

    ``is_selected`` gets the id of the point, the seal of its run file, and the hash of the code
    that read it. Variables that the present code does not know are left out.
    """
    with netCDF4.Dataset(path) as file:
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        particles = {point: stored_particles(states, point) for point in states}
    with ExitStack() as stack:

        def open_group(group: str | None) -> xr.Dataset:
            """Open a group without a cache: each access reads the variable from the file."""
            file = xr.open_dataset(path, engine="netcdf4", group=group, cache=False)
            return stack.enter_context(file)

        root, runs = open_group(None), open_group(RUNS)
        known_names = stored_names()
        table = pd.DataFrame({name: root[name].values for name in ("point", "system")})
        columns = [str(name) for name in runs]
        origin = [name for name in columns if name not in ("variables", "adopted")]
        table = table.assign(**{name: runs[name].values for name in columns})
        selection = [
            is_selected(point, seal, runs.attrs["code"])
            and particles.get(point, Shown.NOTHING) >= particle_need(point)
            for point, seal in zip(table["point"], table["seal"], strict=True)
        ]
        groups = table[selection].groupby(["system", "variables"], sort=False)
        for (system, variables), group in groups:
            rows, points = group.index.to_numpy(), group["point"].tolist()
            profile_rows = (profiles := open_group(system)).indexes["run"].get_indexer(points)
            values = {
                name: profiles[name].values[profile_rows]
                if name in OF_PROFILES
                else root[name].values[rows].astype(object if name in WORDS else float)
                for name in variables.split()
                if name in known_names
            }
            yield Rows(
                points=points,
                origin={name: group[name].tolist() for name in origin}
                | {"adopted": [""] * len(points)},
                values=values,
                states={
                    point: open_group(f"{PARTICLES}/{point}").load()
                    for point in points
                    if particle_need(point)
                },
            )


def _has_seal(run: Path, seal: str) -> bool:
    """Return whether a run file has this seal; without a file it has not."""
    try:
        return read_seal(run) == seal
    except OSError:
        return False
