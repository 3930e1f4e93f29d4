"""Adopt a dataset that was made elsewhere: the points that it covers are not run again."""

import hashlib
from pathlib import Path

import netCDF4

from sim.base.errors import InputError
from sim.base.files import atomic_write, read_regular
from sim.base.seals import checked_read
from sim.base.words import count_text
from sim.dataset.adopted import FOLDER, read_points
from sim.dataset.earlier import adopted_rows, missing_variables
from sim.dataset.results import RUNS
from sim.dataset.rounds import known_points
from sim.engine.identity import NUMERICS
from sim.study.load import load_study

#: Digits of the SHA-256 of an adopted dataset that are its file name.
DIGITS = 16

#: Most variables that a message names.
MOST_NAMED = 3


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
    study = load_study(study_path, results)
    folder = results / study.name
    points = known_points(study, folder)
    is_run_file_needed, particle_need = study.needs_run_file, study.particles_needed
    with checked_read(dataset_path, "dataset", replaceable=False, sealed=True):
        content = read_regular(dataset_path)
        _require_origin(dataset_path)
        rows = read_points(dataset_path)
        covered = {
            key: point
            for key, point in points.items()
            if key in rows
            and rows[key].is_enough_for(point, particle_need(key))
            and not is_run_file_needed(key)
        }
        adopted_rows(dataset_path, covered, particle_need)
    if not covered:
        common = len(points.keys() & rows.keys())
        raise InputError(
            f"{dataset_path}: covers no point of {study.path}: "
            f"of {count_text(len(points), 'point')} it has {common:,}, "
            "none with all that is wanted of it"
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
        allowed = "one whose program knew them; make it again from its runs"
        raise InputError.of_value(path, "", f"a dataset that cannot have {names}", allowed)
