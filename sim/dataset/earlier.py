"""Rows of datasets: those of the earlier dataset spare reading run files."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import netCDF4

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
    reader_hash,
    stored_names,
)
from sim.parameters import SYSTEMS, Parameters, amounts
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
        with suppress(OSError):
            return row.wanted == wanted and code == reader_hash() and read_seal(run) == row.seal
        return False

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
        root, runs = (open_group(file, name).load() for name in (None, RUNS))
        groups = {name: open_group(file, name).load() for name in SYSTEMS if name in file.groups}
        places = {
            point: place
            for group in groups.values()
            for place, point in enumerate(group["run"].values)
        }
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        known_names = stored_names()
        origin = [str(name) for name in runs if name not in ("variables", "adopted")]
        labels = {name: root[name].values for name in ("point", "system")}
        for number, row in enumerate(runs.to_dataframe().assign(**labels).itertuples()):
            wanted, particles = need(row.point), Shown.NOTHING
            if row.point in states:
                has_path = "path" in states[row.point].variables
                particles = Shown.PATH if has_path else Shown.STATE
            has_enough = particles >= wanted.particles and (
                row.point in places or not wanted.profiles
            )
            if not (has_enough and is_selected(row, runs.attrs["code"])):
                continue
            values = {}
            for name in filter(known_names.__contains__, row.variables.split()):
                if name in OF_PROFILES:
                    stored = groups[row.system].variables[name].values
                    values[name] = stored[places[row.point]]
                else:
                    kind = object if name in WORDS else float
                    values[name] = root.variables[name].values[number].astype(kind)
            state = None
            if particles:
                state = open_group(file, f"{PARTICLES}/{row.point}").load()
            known = {name: getattr(row, name) for name in origin} | {"adopted": ""}
            yield Row(row.point, known, values, state).without_padding()
