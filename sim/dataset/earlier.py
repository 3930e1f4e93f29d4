"""Rows from datasets instead of run files: the earlier dataset of the study, and adopted ones."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import pandas as pd

from sim.base.files import atomic_write
from sim.base.seals import UNREADABLE, is_damaged, read_seal
from sim.dataset.grids import open_group
from sim.dataset.rows import (
    OF_PROFILES,
    PARTICLES,
    RUNS,
    WORDS,
    Rows,
    amounts_text,
    dimensions,
    points_with_profiles,
    reader_hash,
    stored_names,
    stored_particles,
)
from sim.parameters import Parameters, amounts
from sim.study.model import Need
from sim.study.plot_kinds import Shown

#: Second name of the last dataset of a study. It stays when the workflow removes ``dataset.nc``,
#: which happens before it makes a new one and when it fails to.
EARLIER_FILE = ".earlier.nc"


def keep_dataset(dataset: Path, folder: Path) -> None:
    """Keep a dataset for `earlier_rows`: a hard link, or a copy where links are impossible."""
    with atomic_write(folder / EARLIER_FILE) as temporary:
        try:
            os.link(dataset, temporary)
        except OSError:
            shutil.copyfile(dataset, temporary)


def earlier_rows(
    folder: Path, need: Callable[[str], Need], points: Mapping[str, Parameters]
) -> list[Rows]:
    """Return the rows of points in the earlier dataset that equal what their run files would give.

    Parameters
    ----------
    folder : Path
        Results of the study. There are no such rows without an earlier dataset, or if that is
        damaged or was made by other code.
    need : callable
        Returns what must be stored of a point besides its scalars, by its id.
    points : mapping
        The points, by id.
    """
    path = folder / EARLIER_FILE
    texts = {point: amounts_text(amounts(value)) for point, value in points.items()}

    def is_same(point: str, seal: str, wanted: str, code: str) -> bool:
        run = folder / "runs" / f"{point}.nc"
        return wanted == texts.get(point) and code == reader_hash() and _has_seal(run, seal)

    with suppress(*UNREADABLE):
        if path.is_file() and not is_damaged(path):
            return list(_read_rows(path, is_same, need))
    return []


def adopted_rows(
    path: Path,
    points: Mapping[str, Parameters],
    need: Callable[[str], Need],
) -> list[Rows]:
    """Return the rows of points in an adopted dataset, without replicates beyond their amounts.

    Parameters
    ----------
    path : Path
        The dataset, which has at least these amounts. Its stem becomes the origin of the rows.
    points : mapping
        The points, by id.
    need : callable
        Returns what must be stored of a point besides its scalars, by its id.
    """
    blocks = _read_rows(path, lambda point, *_: point in points, need)
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
    is_selected: Callable[[str, str, str, str], bool],
    need: Callable[[str], Need],
) -> Iterator[Rows]:
    """Yield the selected rows of a dataset that store enough of profiles and particles.

    ``is_selected`` gets the id of the point, the seal of its run file, the amounts that were read,
    and the hash of the code that read them. Variables unknown to the present code are left out.
    """
    with netCDF4.Dataset(path) as file:
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        particles = {point: stored_particles(states, point) for point in states}
        with_profiles = points_with_profiles(file)
        # Only now: xarray turns off that characters are read as text.
        root, runs = open_group(file, None), open_group(file, RUNS)
        known_names = stored_names()
        table = pd.DataFrame({name: root[name].values for name in ("point", "system")})
        columns = [str(name) for name in runs]
        origin = [name for name in columns if name not in ("variables", "adopted")]
        table = table.assign(**{name: runs[name].values for name in columns})
        selection = [
            particles.get(point, Shown.NOTHING) >= need(point).particles
            and (point in with_profiles or not need(point).profiles)
            and is_selected(point, seal, wanted, runs.attrs["code"])
            for point, seal, wanted in table[["point", "seal", "wanted"]].itertuples(index=False)
        ]
        groups = table[selection].groupby(["system", "variables"], sort=False)
        for (system, variables), group in groups:
            rows, points = group.index.to_numpy(), group["point"].tolist()
            names = [name for name in variables.split() if name in known_names]
            values = {
                name: root[name].values[rows].astype(object if name in WORDS else float)
                for name in names
                if name not in OF_PROFILES
            }
            if profile_names := [name for name in names if name in OF_PROFILES]:
                profiles = open_group(file, system)
                places = profiles.indexes["run"].get_indexer(points)
                values |= {name: profiles[name].values[places] for name in profile_names}
            yield Rows(
                points=points,
                origin={name: group[name].tolist() for name in origin}
                | {"adopted": [""] * len(points)},
                values=values,
                states={
                    point: open_group(file, f"{PARTICLES}/{point}").load()
                    for point in points
                    if need(point).particles
                },
            )


def _has_seal(run: Path, seal: str) -> bool:
    """Return whether a run file has this seal; without a file it has not."""
    try:
        return read_seal(run) == seal
    except OSError:
        return False
