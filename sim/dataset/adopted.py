"""Datasets that were made elsewhere: their rows become run files, so that no point is run again."""

import hashlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from filelock import Timeout

from sim.base.errors import InputError, count_text
from sim.base.files import atomic_write, date_back_readers, file_lock, read_regular
from sim.base.seals import append_summary, checked_read, seal
from sim.dataset.grids import Values, open_group
from sim.dataset.results import parameters_of_row, with_all_parameters
from sim.dataset.rounds import points_of_rounds
from sim.dataset.rows import OF_PROFILES, RUNS, Row, dimensions
from sim.dataset.sources import read_rows
from sim.engine.identity import NUMERICS
from sim.engine.stored_run import STATE, has_enough, is_reduced, measured_codes, read_amounts
from sim.parameters import Parameters, amounts, canonical_values, covers, point_id
from sim.parameters.variables import ALL, SCALARS
from sim.study.load import load_study
from sim.study.model import Need
from sim.study.plottable import Shown

#: Digits of the SHA-256 of an adopted dataset that are its name in run files and datasets.
DIGITS = 16

#: Most variables that a message names.
MOST_NAMED = 3

#: What a reduced run file takes over from the file that the row was read from.
_KEPT = ("seal", "engine_version", "source_hash", "versions", "created", "caveat")


def unknown_observables(group: Any, system: str) -> list[str]:
    """Return the observables of plug-ins that a dataset's writer did not know, of a system.

    ``group`` is the group `RUNS` of the dataset. What earlier versions of the package did not
    store is not in their run files either; its observables are measured from what a row has.
    """
    if system not in ALL:
        # It is one of a later version.
        return [system]
    reads = group.getncattr("reads") if "reads" in group.ncattrs() else ""
    return sorted(measured_codes(system) - set(reads.split()))


def adopt(study_path: Path, dataset_path: Path, results: Path = Path("results")) -> str:
    """Make the rows of a dataset reduced run files of a study.

    A run file that is there stays where it holds enough of its point, or something that the row
    does not hold. Where rounds may add points to the study, rows of any point become run files. The
    dataset may be of another study that has some of the points. Returns a message: how many points
    of the study it covers. Raises `InputError` when the dataset is missing or damaged, has other
    numerics, or covers no point. Nothing is written then.
    """
    study = load_study(study_path, results)
    folder = results / study.name
    points = points_of_rounds(study, folder)
    with checked_read(dataset_path, "dataset", replaceable=False, sealed=True):
        content = read_regular(dataset_path)
        stored = _read_points(dataset_path)
        wanted = stored if study.rounds else stored.keys() & points.keys()
        usable = {
            key: stored[key]
            for key in wanted
            if key not in points or covers(amounts(stored[key]), amounts(points[key]))
        }
        rows = list(
            read_rows(
                dataset_path,
                lambda row, _: row.point in usable,
                lambda point: study.need(point)._replace(series=False),
            )
        )
    covered = [row for row in rows if row.point in points and not study.need(row.point).series]
    if not covered:
        common = len(points.keys() & stored.keys())
        raise InputError(
            f"{dataset_path}: covers no point of {study.path}: "
            f"of {count_text(len(points), 'point')} it has {common:,}, "
            "none with all that is wanted of it"
        )
    name = hashlib.sha256(content).hexdigest()[:DIGITS]
    runs = folder / "runs"
    runs.mkdir(parents=True, exist_ok=True)
    for row in rows:
        key, path = row.point, runs / f"{row.point}.nc"
        # A run that holds the lock is making the file.
        with suppress(Timeout), file_lock(path, wait=False):
            if not _stays(path, points.get(key), usable[key], study.need(key)):
                _write_run(path, usable[key], row, name)
    date_back_readers(folder)
    number = f"{len(covered):,} of {count_text(len(points), 'point')}"
    return f"{study.name}: {dataset_path} covers {number}; in {runs}, from {name}"


def _read_points(path: Path) -> dict[str, Parameters]:
    """Return the points of a dataset by id, with the amounts that it holds, as good as run files.

    A row is left out if its numerics differ or if the writer of the dataset did not know an
    observable of its system that a plug-in declares. Raises an error where that leaves out all
    rows, or where the file is no dataset.
    """
    with netCDF4.Dataset(path) as file:
        if "study" not in file.ncattrs():
            raise ValueError("no study in it")
        if RUNS not in file.groups or "wanted" not in file.groups[RUNS].variables:
            raise InputError(
                f"{path}: does not say how much of each point it holds; make it again from its runs"
            )
        runs, systems = file.groups[RUNS], file["system"][:].tolist()
        if str(NUMERICS) not in (numerics := str(file.getncattr("numerics"))).split(", "):
            raise InputError.of_value(path, "numerics", numerics, str(NUMERICS))
        lacking = {system: unknown_observables(runs, system) for system in sorted({*systems})}
        if all(lacking.values()):
            names = ", ".join(next(iter(lacking.values()))[:MOST_NAMED])
            allowed = "one with them; make it again from its runs"
            raise InputError.of_value(path, "", f"a dataset that cannot have {names}", allowed)
        rows = [
            row
            for row, (system, number) in enumerate(zip(systems, runs["numerics"][:], strict=True))
            if not lacking[system] and number == str(NUMERICS)
        ]
        root = open_group(file, None)
        table = with_all_parameters(root.drop_vars(list(root.data_vars)).isel(point=rows).load())
    columns = {str(name): values.values for name, values in table.coords.items()}
    points: dict[str, Parameters] = {}
    for row in range(len(rows)):
        # A law may be one of a plug-in that is not loaded.
        with suppress(InputError):
            point = parameters_of_row(columns, row)
            points[point_id(point)] = point
    return points


def _stays(path: Path, wanted: Parameters | None, row: Parameters, need: Need) -> bool:
    """Return whether a run file stays: it is whole, and large enough or no smaller than a row."""
    point = wanted or row
    if is_reduced(path, point):
        return False
    held = read_amounts(path, point)
    return has_enough(path, point, need) or (held is not None and not covers(amounts(row), held))


def _write_run(path: Path, point: Parameters, row: Row, dataset: str) -> None:
    """Write a row as a reduced run file; its particles go into a group."""
    _, origin, values, state = row
    shown = Shown.NOTHING if state is None else Shown.PATH if "path" in state else Shown.STATE
    attributes = {name: origin[name] for name in _KEPT} | {
        "title": f"Talus run {point_id(point)}, its row in a dataset",
        "system": point.system,
        "point_id": point_id(point),
        "numerics": NUMERICS,
        "status": "failed" if "failed" in values["status"] else "completed",
        "reason": "; ".join(filter(None, values["reason"])),
        "steps": float(np.nansum(values["steps"])),
        "wall_time": float(np.nansum(values["wall_time"])),
        "reduced": [int(shown), int(bool(values.keys() & OF_PROFILES.keys())), 0],
        "adopted": dataset,
        "variables": " ".join(values),
        "measured": " ".join(sorted(measured_codes(point.system))),
    }
    root = xr.Dataset(
        {**canonical_values(point), "particles": point.particles, "time_step": point.time_step}
        | {name: (dimensions(name), array) for name, array in values.items()},
        attrs=attributes,
    )
    scalars = {name: array.tolist() for name, array in values.items() if name in SCALARS}
    with atomic_write(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            writer = Values()
            writer.define(root, file)
            if state is not None:
                writer.define(state, file.createGroup(STATE))
            writer.fill()
        summary = {"attributes": attributes, "held": [amounts(point)], "scalars": scalars}
        append_summary(temporary, summary)
        seal(temporary)
