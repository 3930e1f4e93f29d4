"""List or remove the runs of points that are no longer in a study."""

from pathlib import Path

from sim.base.errors import InputError
from sim.report.status import survey
from sim.study.load import load_study


def show(study_path: Path, results: Path, remove: bool) -> list[str]:
    """Return a line per orphaned run of a study with its size, and a line with the total.

    Parameters
    ----------
    study_path : Path
        The study file.
    results : Path
        Folder of all results.
    remove : bool
        Also remove run files, states and logs of these points.

    Raises
    ------
    InputError
        When rounds of refinement are still to come, as these may need any of the present runs.
    """
    study = load_study(study_path, results)
    status = survey(study, results)
    if status.rounds_left:
        allowed = "a study whose rounds of refinement are known; run it first"
        raise InputError.of_value(
            study_path, "boundaries", f"{status.rounds_left} to come", allowed
        )
    folder = results / study.name
    lines, total = [], 0
    for name in status.orphans:
        files = [path for path in _files(folder, name) if path.exists()]
        size = sum(path.stat().st_size for path in files)
        total += size
        lines.append(f"{name}  {_megabytes(size)}")
        for path in files if remove else ():
            path.unlink()
    count = f"{len(lines):,} run" + "s" * (len(lines) > 1)
    word = "removed" if remove else "of no point of the study; --remove removes them"
    return [*lines, f"{count}, {_megabytes(total)}: {word}"] if lines else ["none"]


def _files(folder: Path, name: str) -> list[Path]:
    """Return run file, state, progress file and log of a point, the run file first."""
    runs = folder / "runs"
    return [
        runs / f"{name}.nc",
        runs / f".{name}.nc.state",
        runs / f".{name}.nc.progress",
        folder / "logs" / "runs" / f"{name}.log",
    ]


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"
