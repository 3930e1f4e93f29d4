"""Points whose rows come from datasets that were made elsewhere, so that they are not run here."""

from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from json import loads
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np

from sim.base.damage import checked_read
from sim.base.files import is_damaged
from sim.dataset.boundary_side import SCALARS
from sim.engine.identity import NUMERICS
from sim.engine.stored_run import holds
from sim.parameters import Parameters, amounts, covers
from sim.study.catalogue import Shown
from sim.study.figure_points import needs_run_file, particles_shown
from sim.study.load import Study

#: Folder of the adopted datasets of a study, beside its runs.
FOLDER = "adopted"


class Held(NamedTuple):
    """What a dataset says of one of its points.

    Attributes
    ----------
    dataset : Path
        The dataset.
    amounts : mapping
        How much of the point it holds.
    particles : Shown
        What it has of the particles.
    caveat : str
        What to know before trusting the point.
    scalars : mapping
        Those that tell on which side of a boundary the point is, and ``wall_time`` (s), each over
        replicates.
    """

    dataset: Path
    amounts: Mapping[str, float]
    particles: Shown
    caveat: str
    scalars: Mapping[str, np.ndarray]

    def answers(self, parameters: Parameters, shown: Shown) -> bool:
        """Return whether this is enough of a point of whose particles so much is ``shown``."""
        wanted = amounts(parameters)
        enough = wanted.keys() <= self.amounts.keys() and covers(self.amounts, wanted)
        # The state is that of the first replicate that completed.
        is_there = "completed" in self.scalars_of(parameters)["status"]
        return enough and ((is_there and self.particles >= shown) or not shown)

    def scalars_of(self, parameters: Parameters) -> dict[str, np.ndarray]:
        """Return the scalars of the replicates that are wanted of the point."""
        return {name: held[: parameters.replicates] for name, held in self.scalars.items()}


class Adopted:
    """The points of a study that its adopted datasets stand for.

    Parameters
    ----------
    study : Study
        The study.
    folder : Path
        Its results. ``files`` are the adopted datasets there.

    Raises
    ------
    DamagedError
        When one of them cannot be read. It is set aside, so that its points are run.
    """

    def __init__(self, study: Study, folder: Path):
        self.files = sorted((folder / FOLDER).glob("*.nc"))
        self._runs = folder / "runs"
        self._needed, self._shown = needs_run_file(study), particles_shown(study)
        self._held: dict[str, list[Held]] = defaultdict(list)
        for path in self.files:
            with checked_read(path, "dataset that was adopted", replaceable=True):
                for point, held in rows_of(path).items():
                    self._held[point].append(held)

    def source(self, point: str, parameters: Parameters) -> Held | None:
        """Return what a point is taken from, nothing where its run file is there or needed."""
        shown = self._shown(point)
        found = [held for held in self._held.get(point, ()) if held.answers(parameters, shown)]
        if not found or self._needed(point) or holds(self._runs / f"{point}.nc", parameters):
            return None
        # Of a longer run the numbers are others.
        return min(found, key=lambda held: held.amounts != amounts(parameters))

    def sources(self, points: Mapping[str, Parameters]) -> dict[str, Held]:
        """Return what points are taken from, by id, but those that others are run from."""
        found = {key: held for key, one in points.items() if (held := self.source(key, one))}
        run = [key for key in points if key not in found]
        for key in run:
            start = points[key].start_from
            if found.pop(start, None):
                run.append(start)
        return found


def rows_of(path: Path) -> dict[str, Held]:
    """Return what a dataset has of its points, where it has all that would be read of a run file.

    Raises ``ValueError`` where it is damaged, and what the library does where it is no dataset.
    """
    # The libraries of tables, which studies without adopted datasets do without.
    from sim.dataset.earlier import reading_code

    return _rows_of(path, path.stat().st_mtime_ns, reading_code())


@cache
def _rows_of(path: Path, changed: int, code: str) -> dict[str, Held]:
    """Read the rows once; ``changed`` (ns) tells one file of a name from the next."""
    from sim.dataset.earlier import names_unknown, particles_held
    from sim.dataset.results import PARTICLES, RUNS

    if is_damaged(path):
        raise ValueError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        made = file.groups[RUNS]
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        scalars = {name: file[name][:] for name in (*SCALARS, "wall_time")}
        columns = (file["point"], file["system"], made["wanted"], made["numerics"], file["caveat"])
        table: Any = list(zip(*(column[:].tolist() for column in columns), strict=True))
        known = {system for _, system, *_ in table if not names_unknown(made, system)}
        return {
            point: Held(
                dataset=path,
                amounts={name: float(value) for name, value in loads(wanted).items()},
                particles=particles_held(states, point),
                caveat=caveat,
                scalars={name: values[row] for name, values in scalars.items()},
            )
            for row, (point, system, wanted, numerics, caveat) in enumerate(table)
            if numerics == str(NUMERICS) and system in known
        }
