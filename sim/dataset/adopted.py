"""Datasets that were made elsewhere: the points that they cover are not run again."""

import hashlib
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from json import loads
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np

from sim.base.errors import InputError, count_text
from sim.base.files import atomic_write, read_regular
from sim.base.seals import checked_read, is_damaged
from sim.dataset.rounds import SCALARS, points_of_rounds
from sim.dataset.rows import (
    PARTICLES,
    RUNS,
    Rows,
    points_with_profiles,
    reader_hash,
    stored_names,
    stored_particles,
)
from sim.engine.identity import NUMERICS
from sim.engine.stored_run import has_enough
from sim.parameters import Parameters, amounts, covers
from sim.parameters.variables import ALL
from sim.study.load import load_study
from sim.study.model import Need, Study

#: Folder of the adopted datasets of a study, beside its runs.
FOLDER = "adopted"

#: What messages call such a dataset.
_KIND = "dataset that was adopted"

#: Digits of the SHA-256 of an adopted dataset that are its file name.
DIGITS = 16

#: Most variables that a message names.
MOST_NAMED = 3


class AdoptedPoint(NamedTuple):
    """One point in an adopted dataset.

    Attributes
    ----------
    dataset : Path
        The dataset.
    amounts : mapping
        Amounts of the point that it holds.
    stored : Need
        What it stores of the point besides its scalars.
    caveat : str
        Caveat of the point.
    scalars : mapping
        Scalars that decide the side of a boundary, and ``wall_time`` (s), each over replicates.
    """

    dataset: Path
    amounts: Mapping[str, float]
    stored: Need
    caveat: str
    scalars: Mapping[str, np.ndarray]

    def is_enough_for(self, parameters: Parameters, need: Need) -> bool:
        """Return whether a point may be adopted: its amounts, particles and profiles are stored."""
        needed = amounts(parameters)
        is_covered = needed.keys() <= self.amounts.keys() and covers(self.amounts, needed)
        # The state is that of the first replicate that completed.
        has_state = "completed" in self.wanted_scalars(parameters)["status"]
        has_particles = has_state and self.stored.particles >= need.particles
        has_profiles = self.stored.profiles >= need.profiles
        return is_covered and has_profiles and (has_particles or not need.particles)

    def wanted_scalars(self, parameters: Parameters) -> dict[str, np.ndarray]:
        """Return the scalars of as many replicates as the point has."""
        return {name: values[: parameters.replicates] for name, values in self.scalars.items()}


class AdoptedPoints:
    """The points of a study that are in its adopted datasets.

    Parameters
    ----------
    study : Study
        The study.
    folder : Path
        Its results. ``files`` are the adopted datasets there.

    Raises
    ------
    DamagedError
        When one of the datasets cannot be read. It is set aside, so that its points are run.
    """

    def __init__(self, study: Study, folder: Path):
        self.files = sorted((folder / FOLDER).glob("*.nc"))
        self._runs = folder / "runs"
        self._needs_run_file, self._need = study.needs_run_file, study.need
        self._candidates: dict[str, list[AdoptedPoint]] = defaultdict(list)
        for path in self.files:
            with checked_read(path, _KIND, replaceable=True):
                for point, row in read_points(path).items():
                    self._candidates[point].append(row)

    def source(self, point: str, parameters: Parameters) -> AdoptedPoint | None:
        """Return the adopted row of a point, none where its run file is there or is needed."""
        need = self._need(point)
        rows = [
            row for row in self._candidates.get(point, ()) if row.is_enough_for(parameters, need)
        ]
        run_file = self._runs / f"{point}.nc"
        if not rows or self._needs_run_file(point) or has_enough(run_file, parameters):
            return None
        # A row of exactly these amounts comes first: the numbers of a longer run differ.
        return min(rows, key=lambda row: row.amounts != amounts(parameters))

    def sources(self, points: Mapping[str, Parameters]) -> dict[str, AdoptedPoint]:
        """Return a map from point id to adopted row, without points that other runs start from."""
        rows = {key: row for key, point in points.items() if (row := self.source(key, point))}
        runs = [key for key in points if key not in rows]
        for key in runs:
            start = points[key].start_from
            if rows.pop(start, None):
                runs.append(start)
        return rows

    def rows(self, points: Mapping[str, Parameters]) -> list[Rows]:
        """Return the rows of those points that are adopted, see `source`."""
        # Imported here, because plans of studies do not need the table libraries.
        from sim.dataset.earlier import adopted_rows

        members: dict[Path, dict[str, Parameters]] = defaultdict(dict)
        for key, point in points.items():
            if source := self.source(key, point):
                members[source.dataset][key] = point
        blocks: list[Rows] = []
        for path in sorted(members):
            with checked_read(path, _KIND, replaceable=True):
                blocks += adopted_rows(path, members[path], self._need)
        return blocks


def read_points(path: Path) -> dict[str, AdoptedPoint]:
    """Return a map from point id to the row of a dataset, for rows as good as their run file.

    A row is left out if its numerics differ or if the writer of the dataset did not know a variable
    that is stored now. Raises ``ValueError`` when the file is damaged, and errors of the library
    when it is no dataset.
    """
    return _read_points(path, path.stat().st_mtime_ns, reader_hash())


@cache
def _read_points(path: Path, changed: int, code: str) -> dict[str, AdoptedPoint]:
    """Read the rows once; ``changed`` (ns) tells successive files of the same name apart."""
    if is_damaged(path):
        raise ValueError("its checksum is wrong or missing")
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        runs = file.groups[RUNS]
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        with_profiles = points_with_profiles(file)
        scalars = {name: file[name][:] for name in (*SCALARS, "wall_time")}
        columns = (file["point"], file["system"], runs["wanted"], runs["numerics"], file["caveat"])
        table: Any = list(zip(*(column[:].tolist() for column in columns), strict=True))
        complete = {system for _, system, *_ in table if not missing_variables(runs, system)}
        return {
            point: AdoptedPoint(
                dataset=path,
                amounts={name: float(value) for name, value in loads(point_amounts).items()},
                stored=Need(stored_particles(states, point), point in with_profiles),
                caveat=caveat,
                scalars={name: values[row] for name, values in scalars.items()},
            )
            for row, (point, system, point_amounts, numerics, caveat) in enumerate(table)
            if numerics == str(NUMERICS) and system in complete
        }


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


def adopt(study_path: Path, dataset_path: Path, results: Path) -> str:
    """Copy a dataset into ``results/<study>/adopted``, from where the study takes its rows.

    Parameters
    ----------
    study_path : Path
        The study file.
    dataset_path : Path
        The dataset, of this study or of another one that has some of its points.
    results : Path
        Folder of all results.

    Returns
    -------
    str
        A message: how many points of the study it covers, and where it is now.

    Raises
    ------
    InputError
        When the dataset is missing or damaged, has other numerics, or covers no point. Nothing is
        written then.
    """
    # Imported here, because plans of studies do not need the table libraries.
    from sim.dataset.earlier import adopted_rows

    study = load_study(study_path, results)
    folder = results / study.name
    points = points_of_rounds(study, folder)
    is_run_file_needed = study.needs_run_file
    with checked_read(dataset_path, "dataset", replaceable=False, sealed=True):
        content = read_regular(dataset_path)
        _require_origin(dataset_path)
        rows = read_points(dataset_path)
        covered = {
            key: point
            for key, point in points.items()
            if key in rows
            and rows[key].is_enough_for(point, study.need(key))
            and not is_run_file_needed(key)
        }
        adopted_rows(dataset_path, covered, study.need)
    if not covered:
        common = len(points.keys() & rows.keys())
        raise InputError(
            f"{dataset_path}: covers no point of {study.path}: "
            f"of {count_text(len(points), 'point')} it has {common:,}, "
            "none with the wanted replicates and length"
        )
    output = folder / FOLDER / f"{hashlib.sha256(content).hexdigest()[:DIGITS]}.nc"
    if not output.is_file() or read_regular(output) != content:
        output.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(output) as temporary:
            temporary.write_bytes(content)
    number = f"{len(covered):,} of {count_text(len(points), 'point')}"
    return f"{study.name}: {dataset_path} covers {number}; adopted as {output}"


def _require_origin(path: Path) -> None:
    """Refuse a file that is no dataset, has other numerics, or lacks variables that are stored now.

    A dataset of several systems is refused for lacking variables only if all of them lack some.
    """
    with netCDF4.Dataset(path) as file:
        if "study" not in file.ncattrs():
            raise ValueError("no study in it")
        if RUNS not in file.groups or "wanted" not in file.groups[RUNS].variables:
            raise InputError(
                f"{path}: does not say how much of each point it holds; make it again from its runs"
            )
        numerics = str(file.getncattr("numerics"))
        systems = sorted(set(file["system"][:].tolist()))
        lacking = [missing_variables(file.groups[RUNS], system) for system in systems]
    if str(NUMERICS) not in numerics.split(", "):
        raise InputError.of_value(path, "numerics", numerics, str(NUMERICS))
    if lacking and all(lacking):
        names = ", ".join(lacking[0][:MOST_NAMED])
        allowed = "one with them; make it again from its runs"
        raise InputError.of_value(path, "", f"a dataset that cannot have {names}", allowed)
