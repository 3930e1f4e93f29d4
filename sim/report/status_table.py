"""The progress of a study, as text for a screen and as JSON, and runs of no point of it."""

import json
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sim.base.errors import InputError, count_text, duration, printable
from sim.base.program import program
from sim.engine.shared_runs import describe
from sim.report.points import align_table
from sim.report.status import ENDED_STATES, PointStatus, StudyStatus, survey
from sim.study.load import DEFAULT_STUDY, load_study

#: Control sequence that clears a terminal, and seconds of a day.
CLEAR = "\x1b[H\x1b[2J"
DAY = 86_400

#: Most lines for points that are running or were interrupted, and for those that failed.
MOST_STARTED = 8
MOST_FAILED = 5

_HEADINGS = ("point", "state", "done", "rate", "elapsed", "time left")
_RIGHT = {"done", "rate", "elapsed", "time left"}

#: Length of the hash of a point with its hyphen, which shortened names keep.
_HASH = 9


def show(
    study_path: Path | None,
    results: Path,
    format: str,
    watch: float | None,
    orphans: bool = False,
    remove: bool = False,
) -> list[str] | None:
    """Print the progress of a study as ``text`` or ``json``; every ``watch`` seconds until its end.

    With ``orphans`` return lines on runs of no point of it instead, see `list_orphans`.

    Raises
    ------
    InputError
        When ``watch`` is out of range, or ``results`` is not a folder.
    """
    if watch is not None and not 1 <= watch <= DAY:
        raise InputError.of_value("--watch", "", watch, f"a number in [1, {DAY}]")
    if results.exists() and not results.is_dir():
        raise InputError.of_value("--results", "", str(results), "a folder")
    study_path = study_path or DEFAULT_STUDY
    if orphans:
        return list_orphans(study_path, results, remove)
    study = load_study(study_path, None)
    is_terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if is_terminal else None
    while True:
        status = survey(study, results)
        text = printable(as_json(status) if format == "json" else as_text(status, width))
        print(f"{CLEAR}{text}" if is_terminal and watch else text, flush=True)
        if watch is None or status.is_over:
            return None
        time.sleep(watch)


def as_text(status: StudyStatus, width: int | None = None) -> str:
    """Return counts, running and failed points, and the time left as text.

    Parameters
    ----------
    status : StudyStatus
        The progress of the study.
    width : int, optional
        Columns of the screen, to which names and reasons are shortened. If omitted, they are whole.
    """
    counts = ", ".join(f"{count:,} {state}" for state, count in status.counts.items() if count)
    if status.caveats:
        counts += f"; {status.caveats:,} with a caveat"
    name = f"{status.name}: {status.title}" if status.title else status.name
    sections = [
        [name, f"{count_text(len(status.points), 'point')}: {counts}"],
        _started_lines(status, width),
        _failed_lines(status, width),
        _closing_lines(status),
        list(status.answers),
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines)


def as_json(status: StudyStatus) -> str:
    """Return the counts, every point and the time left (s; null while nothing runs) as JSON."""
    document = {
        "study": status.name,
        "title": status.title,
        "counts": status.counts,
        "caveats": status.caveats,
        "points": [_point_entry(key, point) for key, point in status.points.items()],
        "cores": status.cores,
        "core_seconds": round(status.core_seconds, 3),
        "core_seconds_left": round(status.core_seconds_left, 3),
        "seconds_left": _round_seconds(status.seconds_left),
        "at_most": status.at_most,
        "rounds_left": status.rounds_left,
        "orphans": list(status.orphans),
        "budget": _budget(status),
        "answers": list(status.answers),
    }
    return json.dumps(document, indent=2, ensure_ascii=False)


def _started_lines(status: StudyStatus, width: int | None) -> list[str]:
    """Return a line per point that is running or was interrupted, running ones first."""
    started = [
        (key, point)
        for state in ("running", "interrupted")
        for key, point in status.points.items()
        if point.state == state
    ]
    if not started:
        return []
    rows = [_row(key, point) for key, point in started[:MOST_STARTED]]
    if width is not None:
        others = len(align_table(_HEADINGS, [("", *row[1:]) for row in rows], _RIGHT)[0]) - len(
            "point"
        )
        rows = [(shortened(row[0], width - others), *row[1:]) for row in rows]
    unit = "rate in million particle-steps per second"
    return [*align_table(_HEADINGS, rows, _RIGHT), *_more_line(started, MOST_STARTED), unit]


def _row(key: str, point: PointStatus) -> tuple[str, ...]:
    progress = point.progress
    assert progress is not None, "what has started has said how far it is"
    return (
        key,
        point.state,
        f"{progress.percent} %",
        f"{progress.rate / 1e6:.1f}",
        duration(progress.elapsed),
        progress.remaining_time if point.state == "running" else "-",
    )


def _failed_lines(status: StudyStatus, width: int | None) -> list[str]:
    """Return a line per point that failed, with its reason."""
    failed = [(key, point) for key, point in status.points.items() if point.state == "failed"]
    lines = ["failed"] if failed else []
    for key, point in failed[:MOST_FAILED]:
        reason = " ".join(point.reason.split())
        line = f"{key}: {reason}"
        if width is not None and len(line) > width:
            line = f"{shortened(key, width - len(reason) - 2)}: {reason}"[:width]
        lines.append(line)
    return [*lines, *_more_line(failed, MOST_FAILED)]


def _more_line(entries: Sequence[Any], most: int) -> list[str]:
    return [f"and {len(entries) - most:,} more"] if len(entries) > most else []


def _closing_lines(status: StudyStatus) -> list[str]:
    """Return lines on the time left or taken, rounds, budget, outdated points and orphans."""
    lines = []
    about = "at most" if status.at_most else "about"
    if status.is_over:
        lines.append(
            f"time of all runs {duration(status.core_seconds)}, with compiling and waiting"
        )
    elif status.seconds_left is None:
        time = duration(status.core_seconds_left)
        lines.append(f"nothing is running; core time left {about} {time}")
    else:
        cores = f"{status.cores:,} core" + "s" * (status.cores > 1)
        lines.append(f"time left {about} {duration(status.seconds_left)} on {cores}")
    if line := describe(filter(None, (point.shared for point in status.points.values()))):
        lines.append(line)
    if status.rounds_left:
        lines.append(f"rounds of refinement to come, not counted: {status.rounds_left}")
    if status.budget:
        budget = status.budget
        hours = (
            f"{budget.spent:.2g} of {budget.hours:g} core hours spent, {budget.hours_left:.2g} left"
        )
        lines.append(f"decisions: {hours}")
    outdated = sum(point.outdated for point in status.points.values())
    if outdated:
        lines.append(f"of other numerics, to be run again: {count_text(outdated, 'point')}")
    if status.orphans:
        how = f"{program()} status --orphans lists them"
        lines.append(f"runs of no point of the study: {len(status.orphans):,}; {how}")
    return lines


def shortened(name: str, width: int) -> str:
    """Shorten the readable part of the name of a point, and keep its hash.

    >>> shortened("chute-depth5-friction0.4-0123abcd", 20)
    'chute-dept…-0123abcd'
    """
    width = max(width, 2 * _HASH)
    return name if len(name) <= width else f"{name[: width - _HASH - 1]}…{name[-_HASH:]}"


def _point_entry(key: str, point: PointStatus) -> dict[str, Any]:
    progress = point.progress
    entry: dict[str, Any] = {"id": key, "state": point.state}
    if progress:
        entry |= {
            "done": progress.done,
            "total": progress.total,
            "particle_steps_per_second": round(progress.rate),
            "elapsed": _round_seconds(progress.elapsed),
            "seconds_left": _round_seconds(progress.remaining_seconds)
            if point.state == "running"
            else None,
            "at_most": progress.at_most,
        }
    if point.shared:
        entry |= {"shared": str(point.shared.path)}
    if point.state in ENDED_STATES:
        entry |= {"core_seconds": round(point.core_seconds, 3), "outdated": point.outdated}
        entry |= {"reason": point.reason} if point.reason else {}
        entry |= {"caveat": point.caveat} if point.caveat else {}
    return entry


def _budget(status: StudyStatus) -> dict[str, float] | None:
    """Return the budget of decisions in core hours, or None without one."""
    if status.budget is None:
        return None
    budget = status.budget
    return {
        "hours": budget.hours,
        "spent": round(budget.spent, 4),
        "left": round(budget.hours_left, 4),
    }


def _round_seconds(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds, 3)


def list_orphans(study_path: Path, results: Path, remove: bool) -> list[str]:
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
        key = "boundaries" if study.boundaries else "surrogate"
        raise InputError.of_value(study_path, key, f"{status.rounds_left} to come", allowed)
    folder = results / study.name
    lines, total = [], 0
    for name in status.orphans:
        files = [path for path in _orphan_files(folder, name) if path.exists()]
        size = sum(path.stat().st_size for path in files)
        total += size
        lines.append(f"{name}  {_megabytes(size)}")
        for path in files if remove else ():
            path.unlink()
    count = f"{len(lines):,} run" + "s" * (len(lines) > 1)
    word = "removed" if remove else "of no point of the study; --remove removes them"
    return [*lines, f"{count}, {_megabytes(total)}: {word}"] if lines else ["none"]


def _orphan_files(folder: Path, name: str) -> list[Path]:
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
