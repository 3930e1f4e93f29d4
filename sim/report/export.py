"""Export the particles of a run in a format of other programs, see `sim.report.formats`."""

import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import netCDF4
import numpy as np

from sim.base.errors import InputError, count_text
from sim.base.files import require_writable, temporary_folder
from sim.base.seals import checked_read
from sim.engine.stored_run import parameters_of, read_attributes, require_all
from sim.parameters import RUN_FILE, Parameters
from sim.parameters.spheres import SphereParameters
from sim.report.formats import FORMATS
from sim.report.movie import MOST_FRAMES, Frame, Frames, write_movie
from sim.report.table import TABLES, write_table
from sim.study.command import YAML_SUFFIXES
from sim.study.load import folder_of_results, load_study

if TYPE_CHECKING:
    import pandas as pd

#: Variables of the frames of a trajectory, and of the first and last state of any run.
_TRAJECTORY_VARIABLES = ("trajectory_position", "trajectory_velocity", "trajectory_spin")
_END_VARIABLES = ("position", "particle_velocity", "particle_spin")

#: Packages without which a format cannot be written.
_PACKAGES = {"vtk": "meshio", "xlsx": "openpyxl"}

#: Longest part of the name of a file that tells a point of a study apart.
MOST_LETTERS = 60


def frames_of(file: netCDF4.Dataset, parameters: Parameters, replicate: int) -> Frames:
    """Return the frames of a replicate: its trajectory, or without one its first and last state.

    The run file is open and without masks; ``replicate`` counts from 0. States with positions that
    are not finite, after a blow-up, are left out. A run wraps positions into the cell only now and
    then; here all are.

    Raises `InputError` when the run has no such replicate, or the replicate blew up before its
    first frame.
    """
    count = file.dimensions["replicate"].size
    if not 0 <= replicate < count:
        allowed = f"a replicate of the run, 0 to {count - 1}"
        raise InputError.of_value("--replicate", "", replicate, allowed)
    has_trajectory = "trajectory_position" in file.variables
    names = _TRAJECTORY_VARIABLES if has_trajectory else _END_VARIABLES
    samples = np.isfinite(file["mean_velocity"][replicate]).sum()
    ends = np.array([0.0, file["time"][samples - 1] if samples else 0.0])
    radius, height = file["radius"][replicate], file[names[0]][replicate, :, :, -1]
    places = np.flatnonzero(np.isfinite(height).all(axis=1))
    if not places.size:
        allowed = "a replicate that did not blow up before the first frame of its trajectory"
        raise InputError.of_value("--replicate", "", replicate, allowed)
    low, high, periodic = _cell(parameters, radius, height[places])
    times = (file["trajectory_time"][:] if has_trajectory else ends)[places]
    has_spin, columns = names[-1] in file.variables, ["xyz".index(axis) for axis in file["axis"][:]]

    def vectors(name: str, number: int) -> np.ndarray:
        held = file[name][replicate, int(places[number])]
        padded = np.zeros((len(held), 3), held.dtype)
        padded[:, columns] = held
        return padded

    def read(number: int) -> Frame:
        position, velocity = (vectors(name, number) for name in names[:2])
        length = np.where(periodic, high - low, np.inf)
        position = position - np.where(periodic, length, 0.0) * np.floor(position / length)
        spin = vectors(names[-1], number) if has_spin else None
        return Frame(float(times[number]), position, velocity, spin)

    return Frames(
        radius=radius,
        kind=np.where(file["fixed"][replicate], 2, 1)
        if "fixed" in file.variables
        else np.ones(len(radius), int),
        low=low,
        high=high,
        periodic=periodic,
        times=times,
        steps=np.round(times / parameters.time_step).astype(int),
        has_spin=has_spin,
        read=read,
    )


def _cell(
    parameters: Parameters, radius: np.ndarray, height: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[bool, bool, bool]]:
    bottom = min(0.0, float((height - radius).min(initial=0.0)))
    top = float((height + radius).max(initial=parameters.diameter))
    side = parameters.period
    if isinstance(parameters, SphereParameters) and not parameters.is_flat:
        across = parameters.breadth * parameters.diameter
        return np.array([0.0, 0.0, bottom]), np.array([side, across, top]), (True, True, False)
    thick = float(radius.max())
    high = np.array([side, thick, top])
    return np.array([0.0, -thick, bottom]), high, (True, False, False)


def export(
    path: Path, to: str | None, output: Path | None, replicate: int, of: Sequence[str] = ()
) -> str:
    """Write the trajectory of a replicate, or its first and last state, or the table of a study.

    ``path`` is a run file; or the results of a study or its file, for all its runs. ``to`` is one
    of `FORMATS`, or of `TABLES` of a study, by default that of the suffix of ``output``. This is
    the file to write, or the folder for those of a study. It must not exist; by default it is named
    like the run file, or like the study and the format, in the present folder. A file needs a
    suffix of the format, by which other programs recognise it. ``of`` are the observables in a
    table, by default all that have a value. Returns a line on the written files. Raises
    `InputError` when a run file cannot be read, has no such replicate, or the output cannot be
    written.
    """
    if to is None:
        every = {name: ends for name, (ends, _) in FORMATS.items()}
        every |= {name: (f".{name}",) for name in TABLES}
        fitting = [name for name, ends in every.items() if output and output.suffix.lower() in ends]
        if not fitting:
            allowed = f"one of {', '.join(every)}, or -o FILE that ends as files of a format do"
            got = output.suffix if output else None
            raise InputError.of_value("--to", "", got, allowed)
        (to,) = fitting
    if path.suffix in YAML_SUFFIXES:
        study = load_study(path)
        path = folder_of_results(study, Path("results")) / study.name
    if to in TABLES:
        output = output or Path(f"{path.resolve().name}.{to}")
        _require_output(output, to, (f".{to}",))
        return write_table(_table(path, of), to, output)
    if of:
        raise InputError.of_value("--of", "", ", ".join(of), f"--to {' or '.join(TABLES)} with it")
    return (_export_study if path.is_dir() else _export_run)(path, to, output, replicate)


def _require_output(output: Path, to: str, endings: Sequence[str]) -> None:
    """Refuse a file that cannot be written anew in a format."""
    if output.is_dir():
        allowed = f"the name of a file; {output} is a folder"
        raise InputError.of_value("--output", "", str(output), allowed)
    if output.suffix.lower() not in endings:
        allowed = f"a name that ends in {' or '.join(endings)}, as {to} does"
        raise InputError.of_value("--output", "", str(output), allowed)
    if (package := _PACKAGES.get(to, "")) and not find_spec(package):
        allowed = f"another format, or {to} once {package} is there (pip install {package})"
        raise InputError.of_value("--to", "", to, allowed)
    for one in (output, output.with_suffix("")) if to == "vtk" else (output,):
        if one.exists():
            raise InputError(f"{one}: is there already, and stays as it is; -o names another file")
    require_writable(output.parent, "--output")


def _table(results: Path, of: Sequence[str]) -> "pd.DataFrame":
    # Imported here: particles are exported without it.
    from sim.report.results import load

    with warnings.catch_warnings():
        # The table has a row for each point whose runs failed, too.
        warnings.simplefilter("ignore")
        return load(results).table(of=of)


def _export_study(results: Path, to: str, output: Path | None, replicate: int) -> str:
    """Export all runs in a folder of results into a folder, which appears when it is complete."""
    runs = sorted((results / "runs").glob(f"*{RUN_FILE}"))
    if not runs:
        raise InputError.of_value("export", "", str(results), "a run file, or results with runs")
    output = output or Path(f"{results.resolve().name}-{to}")
    if output.exists():
        raise InputError.of_value("--output", "", str(output), "a folder that is not there")
    require_writable(output.parent, "--output")
    output.parent.mkdir(parents=True, exist_ok=True)
    names = _short_names([run.stem for run in runs])
    with temporary_folder(output) as folder:
        for run, name in zip(runs, names, strict=True):
            _export_run(run, to, folder / output.name / f"{name}{FORMATS[to][0][0]}", replicate)
        (folder / output.name).rename(output)
    return f"{output}: {count_text(len(runs), 'run')}"


def _short_names(ids: Sequence[str]) -> list[str]:
    """Return a name for each of several points: what tells it apart, and the hash of its id.

    >>> _short_names(["belt-frequency20-beads9-0ab5f3d1", "belt-frequency30-beads9-77ae0c52"])
    ['frequency20-0ab5f3d1', 'frequency30-77ae0c52']
    """
    parts = [one.split("-") for one in ids]
    common = set(parts[0]).intersection(*parts) if len(ids) > 1 else set(parts[0][1:-1])
    kept = ["-".join(one for one in own[:-1] if one not in common) for own in parts]
    return [f"{text[:MOST_LETTERS]}-{own[-1]}" for text, own in zip(kept, parts, strict=True)]


def _export_run(path: Path, to: str, output: Path | None, replicate: int) -> str:
    endings, write = FORMATS[to]
    output = output or Path(path.with_suffix(endings[0]).name)
    _require_output(output, to, endings)
    with ExitStack() as opened:
        with checked_read(path, "run file", replaceable=False, sealed=True):
            file = opened.enter_context(netCDF4.Dataset(path))
            file.set_auto_mask(False)
            require_all(read_attributes(file), path)
            frames = frames_of(file, parameters_of(file, path), replicate)
        output.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(output, frames)
        except RuntimeError as error:
            # The library raises this on a full disk.
            raise OSError(f"{output}: cannot be written: {error}") from None
    count, most = len(frames.times), MOST_FRAMES if write is write_movie else len(frames.times)
    frames_told = f"{most} of {count:,} frames" if count > most else count_text(count, "frame")
    return f"{output}: {frames_told} of {len(frames.radius):,} particles"
