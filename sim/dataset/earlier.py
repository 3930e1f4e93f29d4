"""Rows of datasets: those of the earlier dataset spare reading run files."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

import netCDF4
import pandas as pd

from sim.base.files import atomic_write
from sim.base.seals import UNREADABLE, is_damaged, read_seal
from sim.dataset.grids import open_group
from sim.dataset.rows import (
    OF_PROFILES,
    PARTICLES,
    RUNS,
    WORDS,
    Row,
    amounts_text,
    points_with_profiles,
    reader_hash,
    stored_names,
    stored_particles,
)
from sim.parameters import Parameters, amounts
from sim.study.model import Need
from sim.study.plottable import Shown

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
) -> list[Row]:
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

    def is_same(row: Any, code: str) -> bool:
        run, wanted = folder / "runs" / f"{row.point}.nc", texts.get(row.point)
        return row.wanted == wanted and code == reader_hash() and _has_seal(run, row.seal)

    with suppress(*UNREADABLE):
        if path.is_file() and not is_damaged(path):
            return list(read_rows(path, is_same, need))
    return []


def read_rows(
    path: Path, is_selected: Callable[[Any, str], bool], need: Callable[[str], Need]
) -> Iterator[Row]:
    """Yield the selected rows of a dataset that store enough of profiles and particles.

    ``is_selected`` gets the id of a point, its system and what the group `RUNS` says of it, by
    name, and the hash of the code that read it. Variables unknown to the present code are left out.
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
            and is_selected(row, runs.attrs["code"])
            for row in table.itertuples(index=False)
            for point in [row.point]
        ]
        values_of = cache(lambda name: root[name].values)
        profiles_of = cache(partial(open_group, file))
        profile_of = cache(lambda system, name: profiles_of(system)[name].values)
        points_of = cache(lambda system: profiles_of(system).indexes["run"])
        for number, row in table[selection].iterrows():
            values = {}
            for name in filter(known_names.__contains__, row["variables"].split()):
                if name in OF_PROFILES:
                    place = points_of(row["system"]).get_loc(row["point"])
                    values[name] = profile_of(row["system"], name)[place]
                else:
                    kind = object if name in WORDS else float
                    values[name] = values_of(name)[number].astype(kind)
            state = None
            if row["point"] in particles:
                state = open_group(file, f"{PARTICLES}/{row['point']}").load()
            known = {name: row[name] for name in origin} | {"adopted": ""}
            yield Row(row["point"], known, values, state).without_padding()


def _has_seal(run: Path, seal: str) -> bool:
    """Return whether a run file has this seal; without a file it has not."""
    try:
        return read_seal(run) == seal
    except OSError:
        return False
