"""The progress of a study, from the files in its folder of results, and runs of no point of it."""

import json
import re
import socket
import sys
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

import psutil

from sim.base.errors import InputError, align_table, count_text, duration, printable
from sim.base.files import is_of_system
from sim.base.program import program
from sim.base.seals import UNREADABLE
from sim.dataset.replicates import caveats, layer_orders
from sim.dataset.rounds import points_of_rounds, rounds_to_come
from sim.engine.identity import NUMERICS, numerics_of
from sim.engine.progress import LONGEST_SILENCE, Progress, progress_file, read_progress
from sim.engine.shared_runs import SharedRun, describe, find_runs
from sim.engine.stored_run import has_enough, starts_to_run, summary_of
from sim.parameters import Parameters, amounts, point_id
from sim.report.numbers import template
from sim.study.load import (
    DEFAULT_STUDY,
    ExtraAmounts,
    Study,
    folder_of_results,
    load_study,
    other_engines,
    read_extra_amounts,
    twins,
    with_extra_amounts,
)
from sim.study.model import Need, estimate
from sim.surrogates.storage import summary_lines

STATES = ("done", "failed", "running", "interrupted", "waiting")

#: States in which a point has ended, and in which it may take the run of another study.
ENDED_STATES, WAITING_STATES = STATES[:2], STATES[3:]

#: Names of run files, states and progress files; a point stopped midway may have only the latter.
RUN_FILES = re.compile(r"([^.].*)\.nc|\.([^.].*)\.nc\.(?:state|progress)")

#: Seconds by which the start of a process may seem later than it was: the kernel gives its boot
#: time in whole seconds.
START_ERROR = 2.0

#: Control sequence that clears a terminal, and seconds of a day.
CLEAR = "\x1b[H\x1b[2J"
DAY = 86_400


@dataclass(frozen=True)
class PointStatus:
    """The progress of one point: its ``state``, one of `STATES`, and the ``cores`` of its run.

    ``reason`` says why it failed, ``caveat`` is its caveat. ``progress`` is the last report of a
    run that is running or interrupted. ``core_seconds`` is the wall time (s) of the run of a point
    that has ended, wherever it was made, times its cores; with compiling and waiting. Of an
    ``outdated`` one, other numerics made the run file. ``shared`` is the run of another study that
    a waiting or interrupted point will take.
    """

    state: str
    cores: int
    reason: str = ""
    progress: Progress | None = None
    core_seconds: float = 0.0
    outdated: bool = False
    caveat: str = ""
    shared: SharedRun | None = None


@dataclass(frozen=True)
class StudyStatus:
    """The progress of a study, whose ``points`` are by id in the order of the study.

    ``core_seconds_left`` is the estimated core time of the points that are missing, times measured
    over estimated time of those that are done. It does not include the points of ``rounds_left``:
    rounds whose points are not known yet, one where their number is open. ``orphans`` are points no
    longer in the study that have run files, or states of a stopped run; there are none while rounds
    are to come, as these may need any of them. ``budget`` has the core hours that rounds of
    decisions may add in total, ``hours``, those ``spent`` and ``left``, of a study with a
    ``decide`` section. ``answers`` has a line for each surrogate that is there.
    """

    study: str
    title: str
    points: dict[str, PointStatus]
    core_seconds_left: float
    rounds_left: int
    orphans: tuple[str, ...]
    budget: dict[str, float] | None
    answers: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of points in each of `STATES`."""
        states = [point.state for point in self.points.values()]
        return {state: states.count(state) for state in STATES}

    @property
    def is_over(self) -> bool:
        """Whether every point, those of rounds included, is done or failed."""
        has_ended = all(point.state in ENDED_STATES for point in self.points.values())
        return has_ended and not self.rounds_left

    @property
    def totals(self) -> dict[str, Any]:
        """Points with ``caveats``, ``cores`` in use, and core time (s) and time left (s).

        The time left is that on the cores in use, None while none is.
        """
        points = self.points.values()
        cores = sum(point.cores for point in points if point.state == "running")
        left = self.core_seconds_left / cores if cores else None
        return {
            "caveats": sum(bool(point.caveat) for point in points),
            "cores": cores,
            "core_seconds": sum(point.core_seconds for point in points),
            "seconds_left": 0.0 if self.is_over else left,
        }


def survey(study: Study, results: str | Path = "results") -> StudyStatus:
    """Return the progress of a study in a folder of results; before its start, all points wait.

    It is an `InputError` when a file with further points of the study cannot be read.
    """
    folder = Path(results) / study.name
    extra = read_extra_amounts(folder) if study.decide else ExtraAmounts()
    study = replace(study, points=with_extra_amounts(study.points, extra))
    parameters = points_of_rounds(study, folder)
    runs = folder / "runs"
    starts = starts_to_run(runs, parameters, study.need)
    present = set()
    with suppress(OSError):
        present = {path.name for path in runs.iterdir()}
    points = {
        key: _point_status(key, value, runs, present, None if key in starts else study.need(key))
        for key, value in parameters.items()
    }
    waiting = {key: parameters[key] for key in points if points[key].state in WAITING_STATES}
    for key, run in find_runs(runs, waiting).items():
        points[key] = replace(points[key], shared=run)
    to_come = rounds_to_come(study, folder)
    budget = None
    if study.decide:
        hours = sum(point.core_seconds for point in points.values()) / 3600
        spent = max(0.0, hours - extra.before) if extra.amounts else 0.0
        left = max(0.0, study.decide.budget - spent)
        budget = {"hours": study.decide.budget, "spent": spent, "left": left}
    return StudyStatus(
        study.name,
        study.title,
        points,
        _core_seconds_left(points, parameters),
        to_come,
        () if to_come else _orphans(study, points, present),
        budget,
        answers=tuple(summary_lines(study, folder)),
    )


def _orphans(study: Study, points: Iterable[str], present: Iterable[str]) -> tuple[str, ...]:
    """Return the points of files that are neither of the study nor twins by another engine."""
    stored = {match[1] or match[2] for name in present if (match := RUN_FILES.fullmatch(name))}
    every = (twins(study, other).values() for other in other_engines().values())
    return tuple(sorted(stored - {*points, *map(point_id, chain.from_iterable(every))}))


def _point_status(
    key: str, parameters: Parameters, runs: Path, present: set[str], need: Need | None
) -> PointStatus:
    """Return the status of one point; a running run takes precedence over an earlier run file."""
    cores, path = parameters.cores, runs / f"{key}.nc"
    progress = read_progress(path) if progress_file(path).name in present else None
    if progress and progress.point != key:
        progress = None
    if progress and _is_running(progress):
        return PointStatus("running", cores, progress=progress)
    if path.name in present:
        try:
            return _read_ended(path, path.stat().st_mtime_ns, parameters, need)
        except FileNotFoundError:
            # A damaged file has been set aside in the meantime.
            pass
        except OSError as error:
            return PointStatus("failed", cores, f"{path}: cannot be read: {error.strerror}")
    return PointStatus("interrupted" if progress else "waiting", cores, progress=progress)


def _is_running(progress: Progress) -> bool:
    """Return whether the process that wrote a progress file is alive, as far as is visible here."""
    if progress.host != socket.gethostname():
        return (datetime.now(UTC) - progress.updated).total_seconds() < LONGEST_SILENCE
    try:
        process = psutil.Process(progress.pid)
        # A process that started after the last report has reused the process id.
        is_older = process.create_time() <= progress.updated.timestamp() + START_ERROR
        return is_older and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


@cache
def _read_ended(path: Path, changed: int, parameters: Parameters, need: Need | None) -> PointStatus:
    """Return the status of a point from its run file.

    ``changed`` (ns) is the time of the file. It is part of the cache key, so that each version of a
    file is opened once.
    """
    cores, caveat = parameters.cores, ""
    try:
        run = summary_of(path, amounts(parameters))
        attributes = run.attrs
        scalars = run.scalars | {"layer_order": layer_orders(path, parameters)}
        caveat = caveats(attributes.get("caveat", ""), scalars, parameters)
        core_seconds = max(0.0, float(attributes.get("wall_time", 0.0))) * cores
    except UNREADABLE as error:
        if is_of_system(error):
            raise
        attributes = {}
    state = {"completed": "done", "failed": "failed"}.get(str(attributes.get("status")))
    if attributes.get("point_id") != path.stem or not state:
        reason = f"{path}: not the run file of this point; delete it and rerun"
        return PointStatus("failed", cores, reason)
    outdated = numerics_of(attributes) != NUMERICS
    if not outdated and not has_enough(path, parameters, need):
        # The run must still grow.
        return PointStatus("waiting", cores)
    reason = str(attributes.get("reason", ""))
    return PointStatus(state, cores, reason, None, core_seconds, outdated, caveat)


def _core_seconds_left(
    points: Mapping[str, PointStatus], parameters: Mapping[str, Parameters]
) -> float:
    measured, estimated, missing = 0.0, 0.0, 0.0
    for key, point in points.items():
        cost = estimate(parameters[key]).core_seconds
        if point.state == "done" and point.core_seconds > 0:
            measured, estimated = measured + point.core_seconds, estimated + cost
        elif point.state not in ENDED_STATES and not (point.shared and point.shared.is_enough):
            done = point.progress.done / point.progress.total if point.progress else 0.0
            missing += cost * max(0.0, 1.0 - done)
    return missing * (measured / estimated if estimated else 1.0)


def show(
    study_path: Path | None,
    format: str,
    watch: float | None,
    orphans: bool = False,
    remove: bool = False,
    results: Path = Path("results"),
) -> list[str] | None:
    """Print the progress of a study as ``text`` or ``json``; every ``watch`` seconds until its end.

    With ``orphans`` return lines on runs of no point of it instead, see `list_orphans`.
    """
    if watch is not None and not 1 <= watch <= DAY:
        raise InputError.of_value("--watch", "", watch, f"a number in [1, {DAY}]")
    if remove and not orphans:
        raise InputError.of_value("--remove", "", remove, "with --orphans")
    study = load_study(study_path or DEFAULT_STUDY, results if orphans else None)
    results = folder_of_results(study, results)
    if orphans:
        return list_orphans(study, results, remove)
    while True:
        status = survey(study, results)
        text = printable(as_json(status) if format == "json" else as_text(status))
        print(f"{CLEAR}{text}" if sys.stdout.isatty() and watch else text, flush=True)
        if watch is None or status.is_over:
            return None
        time.sleep(watch)


def as_text(status: StudyStatus) -> str:
    """Return counts, running and failed points, and the time left as text."""
    rows = [
        (
            point.state,
            f"{point.progress.percent} %",
            f"{point.progress.rate / 1e6:.1f}",
            duration(point.progress.elapsed),
            point.progress.remaining_time if point.state == "running" else "-",
            key,
        )
        for state in ("running", "interrupted")
        for key, point in status.points.items()
        if point.state == state and point.progress
    ]
    headings = ("state", "done", "rate", "elapsed", "time left", "point")
    points = status.points.items()
    text = template("status.txt.j2").render(
        status=status,
        counts=", ".join(f"{count:,} {state}" for state, count in status.counts.items() if count),
        started=align_table(headings, rows, set(headings[1:5])),
        failed=[f"{k}: {' '.join(p.reason.split())}" for k, p in points if p.state == "failed"],
        outdated=sum(point.outdated for _, point in points),
        shared=describe(point.shared for _, point in points if point.shared),
        program=program(),
        **status.totals,
    )
    return text.strip()


def as_json(status: StudyStatus) -> str:
    """Return the counts, every point and the time left (s; null while nothing runs) as JSON."""
    points = []
    for key, point in status.points.items():
        entry = {"id": key} | {name: value for name, value in vars(point).items() if value}
        if point.progress:
            known = point.progress.model_dump(include={"done", "total", "rate", "elapsed"})
            entry["progress"] = known | {"seconds_left": point.progress.remaining_seconds}
        if point.shared:
            entry["shared"] = str(point.shared.path)
        points.append(entry)
    document = vars(status) | {"counts": status.counts} | status.totals | {"points": points}
    return json.dumps(document, indent=2, ensure_ascii=False)


def list_orphans(study: Study, results: Path, remove: bool) -> list[str]:
    """Return a line per orphaned run of a study with its size, and a line with the total.

    With ``remove`` run files, states and logs of these points are removed. It is an `InputError`
    while rounds of refinement are to come, as these may need any of the present runs.
    """
    status = survey(study, results)
    if status.rounds_left:
        allowed = "a study whose rounds of refinement are known; run it first"
        key = "boundaries" if study.boundaries else "surrogate"
        raise InputError.of_value(study.path, key, f"{status.rounds_left} to come", allowed)
    folder, sizes = results / study.name, {}
    for name in status.orphans:
        run = folder / "runs" / f"{name}.nc"
        others = (run.with_name(f".{run.name}.{kind}") for kind in ("state", "progress"))
        log = folder / "logs" / "runs" / f"{name}.log"
        files = [path for path in (run, *others, log) if path.exists()]
        sizes[name] = sum(path.stat().st_size for path in files) / 1e6
        for path in files if remove else ():
            path.unlink()
    word = "removed" if remove else "of no point of the study; --remove removes them"
    total = f"{count_text(len(sizes), 'run')}, {sum(sizes.values()):.1f} MB: {word}"
    lines = [f"{name}  {size:.1f} MB" for name, size in sizes.items()]
    return [*lines, total] if lines else ["none"]
