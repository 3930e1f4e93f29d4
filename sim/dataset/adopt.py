"""Adopting a dataset that was made elsewhere: what it has of a study is not run again."""

import hashlib
from pathlib import Path

import netCDF4

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.base.files import read_regular, replacing
from sim.base.words import counted
from sim.dataset.adopted import FOLDER, rows_of
from sim.dataset.earlier import adopted_rows, names_unknown
from sim.dataset.results import RUNS
from sim.dataset.rounds import known_points
from sim.engine.identity import NUMERICS
from sim.parameters import amounts
from sim.study.figure_points import needs_run_file, particles_shown
from sim.study.load import load_study

#: Digits of the SHA-256 of a dataset that name it once it is adopted.
DIGITS = 16

#: Most variables that a message names.
MOST_NAMED = 3


def adopt(study_path: Path, dataset_path: Path, results: Path) -> str:
    """Put a dataset into ``results/<study>/adopted``, from where its rows are taken.

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
        How many points of the study it covers, and where it is now.

    Raises
    ------
    InputError
        When it is missing, damaged, of other numerics or without enough of any point. Nothing is
        written then.
    """
    study = load_study(study_path, results)
    folder = results / study.name
    points = known_points(study, folder)
    is_needed, shown = needs_run_file(study), particles_shown(study)
    with checked_read(dataset_path, "dataset", replaceable=False, sealed=True):
        content = read_regular(dataset_path)
        _require_origin(dataset_path)
        held = rows_of(dataset_path)
        wanted = {
            key: amounts(one)
            for key, one in points.items()
            if key in held and held[key].answers(one, shown(key)) and not is_needed(key)
        }
        adopted_rows(dataset_path, wanted, shown)
    if not wanted:
        there = len(points.keys() & held.keys())
        raise InputError(
            f"{dataset_path}: covers no point of {study.path}: of {counted(len(points), 'point')} "
            f"it has {there:,}, none with all that is wanted of it"
        )
    output = folder / FOLDER / f"{hashlib.sha256(content).hexdigest()[:DIGITS]}.nc"
    if not output.is_file() or read_regular(output) != content:
        output.parent.mkdir(parents=True, exist_ok=True)
        with replacing(output) as temporary:
            temporary.write_bytes(content)
    covered = f"covers {len(wanted):,} of {counted(len(points), 'point')}"
    return f"{study.name}: {dataset_path} {covered}; adopted as {output}"


def _require_origin(path: Path) -> None:
    """Refuse what is no dataset, or not of the present numerics, or without what is kept now.

    Of several systems those without are left out.
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
        lacking = [names_unknown(file.groups[RUNS], system) for system in systems]
    if str(NUMERICS) not in numerics.split(", "):
        raise InputError.of_value(path, "numerics", numerics, str(NUMERICS))
    if lacking and all(lacking):
        names = ", ".join(lacking[0][:MOST_NAMED])
        allowed = "one whose program knew them; make it again from its runs"
        raise InputError.of_value(path, "", f"a dataset that cannot have {names}", allowed)
