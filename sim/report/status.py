"""The progress of a study: the state of every point, from the files in its folder of results."""

import re
import socket
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np
import psutil

from sim.base.files import is_of_system
from sim.base.seals import UNREADABLE
from sim.dataset.adopted import AdoptedPoint, AdoptedPoints
from sim.dataset.replicates import caveat_of_run
from sim.dataset.rounds import points_of_rounds, rounds_to_come
from sim.dataset.run_file import summary_of
from sim.engine.identity import NUMERICS, numerics_of
from sim.engine.progress import CREDIT, Progress, may_end_early, progress_file, read_progress
from sim.engine.shared_runs import SharedRun, find_runs
from sim.engine.stored_run import has_enough
from sim.parameters import Parameters, amounts, point_id
from sim.study.cost import PROCESS_TIME, estimate
from sim.study.extra_amounts import (
    ExtraAmounts,
    other_engines,
    read_extra_amounts,
    twins,
    with_extra_amounts,
)
from sim.study.load import Study
from sim.surrogates.answers import summary_lines

STATES = ("done", "failed", "adopted", "running", "interrupted", "waiting")

#: States in which a point has ended.
ENDED_STATES = STATES[:3]

#: States in which a point may take the run of another study.
WAITING_STATES = STATES[4:]

#: Names of run files, states and progress files; a point stopped midway may have only the latter.
RUN_FILES = re.compile(r"([^.].*)\.nc|\.([^.].*)\.nc\.(?:state|progress)")

#: Seconds by which the start of a process may seem later than it was: the kernel gives its boot
#: time in whole seconds.
START_ERROR = 2.0


@dataclass(frozen=True)
class PointStatus:
    """The progress of one point.

    Attributes
    ----------
    state : str
        One of `STATES`.
    threads : int
        Threads of its run.
    reason : str
        Why it failed.
    progress : Progress or None
        Last progress report of its run, while it is running or interrupted.
    core_seconds : float
        Wall time (s) of the run of a point that is done, failed or adopted, wherever it was made,
        times its cores; with compiling and waiting.
    outdated : bool
        Whether other numerics made its run file.
    caveat : str
        Its caveat, empty if there is none.
    shared : SharedRun or None
        The run of another study that a waiting or interrupted point will take.
    """

    state: str
    threads: int
    reason: str = ""
    progress: Progress | None = None
    core_seconds: float = 0.0
    outdated: bool = False
    caveat: str = ""
    shared: SharedRun | None = None


@dataclass(frozen=True)
class Budget:
    """Core hours that rounds of decisions may add in total, and core hours spent."""

    hours: float
    spent: float

    @property
    def hours_left(self) -> float:
        """Core hours that they may still add."""
        return max(0.0, self.hours - self.spent)


@dataclass(frozen=True)
class StudyStatus:
    """The progress of a study.

    Attributes
    ----------
    name, title : str
        As in the study file.
    points : dict
        `PointStatus` by id, in the order of the study.
    core_seconds_left : float
        Estimate for all points that are not done, failed, adopted or run by another study, on one
        core.
    longest_left : float
        Longest time (s) that one of those points still needs on its own threads.
    at_most : bool
        Whether these times are upper bounds, because runs may end early.
    rounds_left : int
        Rounds whose points are not known yet, one where their number is open; these times do not
        include them.
    orphans : tuple of str
        Points no longer in the study that have run files, or states of a stopped run. Empty while
        rounds are to come, as these may need any of them.
    budget : Budget, optional
        The budget of a study with a ``decide`` section.
    answers : tuple of str
        A line for each surrogate that is there.
    """

    name: str
    title: str
    points: dict[str, PointStatus]
    core_seconds_left: float
    longest_left: float
    at_most: bool
    rounds_left: int = 0
    orphans: tuple[str, ...] = ()
    budget: Budget | None = None
    answers: tuple[str, ...] = ()

    @property
    def counts(self) -> dict[str, int]:
        """Number of points in each of `STATES`."""
        states = [point.state for point in self.points.values()]
        return {state: states.count(state) for state in STATES}

    @property
    def caveats(self) -> int:
        """Number of points that carry a caveat."""
        return sum(bool(point.caveat) for point in self.points.values())

    @property
    def is_over(self) -> bool:
        """Whether every point, those of rounds included, is done, failed or adopted."""
        has_ended = all(point.state in ENDED_STATES for point in self.points.values())
        return has_ended and not self.rounds_left

    @property
    def cores(self) -> int:
        """Cores that running points use now."""
        return sum(point.threads for point in self.points.values() if point.state == "running")

    @property
    def core_seconds(self) -> float:
        """Wall time (s), times cores, of the points that are done, failed or adopted."""
        return sum(point.core_seconds for point in self.points.values())

    @property
    def seconds_left(self) -> float | None:
        """Estimated seconds to the end on the cores that are used now; None while none is used."""
        if self.is_over:
            return 0.0
        return max(self.core_seconds_left / self.cores, self.longest_left) if self.cores else None


def survey(study: Study, results: str | Path = "results") -> StudyStatus:
    """Return the progress of a study; before its start, all points are waiting.

    Parameters
    ----------
    study : Study
        The study.
    results : str or Path
        Folder of all results.

    Raises
    ------
    InputError
        When a file with further points of the study cannot be read.
    """
    folder = Path(results) / study.name
    extra = read_extra_amounts(folder) if study.decide else ExtraAmounts()
    study = replace(study, points=with_extra_amounts(study.points, extra))
    parameters = points_of_rounds(study, folder)
    adopted = AdoptedPoints(study, folder).sources(parameters)
    runs = folder / "runs"
    try:
        present = {path.name for path in runs.iterdir()}
    except OSError:
        present = set()
    points = {
        key: _point_status(key, value, runs, present, adopted.get(key))
        for key, value in parameters.items()
    }
    waiting = {key: parameters[key] for key in points if points[key].state in WAITING_STATES}
    for key, run in find_runs(runs, waiting).items():
        points[key] = replace(points[key], shared=run)
    to_come = rounds_to_come(study, folder)
    stored = {match[1] or match[2] for name in present if (match := RUN_FILES.fullmatch(name))}
    every = (twins(study, other).values() for other in other_engines().values())
    known = points.keys() | set(map(point_id, chain.from_iterable(every)))
    orphans = () if to_come else tuple(sorted(stored - known))
    time_left = _time_left(points, parameters)
    budget = _budget(study.decide.budget, points, extra) if study.decide else None
    return StudyStatus(
        study.name,
        study.title,
        points,
        *time_left,
        to_come,
        orphans,
        budget,
        answers=tuple(summary_lines(study, folder)),
    )


def _budget(hours: float, points: Mapping[str, PointStatus], extra: ExtraAmounts) -> Budget:
    spent = sum(point.core_seconds for point in points.values()) / 3600
    return Budget(hours, max(0.0, spent - extra.before) if extra.amounts else 0.0)


def _point_status(
    key: str, parameters: Parameters, runs: Path, present: set[str], adopted: AdoptedPoint | None
) -> PointStatus:
    """Return the status of one point; a running run takes precedence over an earlier run file."""
    threads = parameters.cores
    path = runs / f"{key}.nc"
    progress = read_progress(path) if progress_file(path).name in present else None
    if progress and progress.point != key:
        progress = None
    if progress and _is_running(progress):
        return PointStatus("running", threads, progress=progress)
    if adopted:
        core_seconds = float(np.nansum(adopted.wanted_scalars(parameters)["wall_time"])) * threads
        return PointStatus("adopted", threads, core_seconds=core_seconds, caveat=adopted.caveat)
    if path.name in present:
        try:
            return _read_ended(path, path.stat().st_mtime_ns, parameters)
        except FileNotFoundError:
            # A damaged file has been set aside in the meantime.
            pass
        except OSError as error:
            return PointStatus("failed", threads, f"{path}: cannot be read: {error.strerror}")
    return PointStatus("interrupted" if progress else "waiting", threads, progress=progress)


def _is_running(progress: Progress) -> bool:
    """Return whether the process that wrote a progress file is alive, as far as is visible here."""
    if progress.host != socket.gethostname():
        return progress.updated - timedelta(seconds=CREDIT) <= datetime.now(UTC) <= progress.expires
    try:
        process = psutil.Process(progress.pid)
        # A process that started after the last report has reused the process id.
        is_older = process.create_time() <= progress.updated.timestamp() + START_ERROR
        return is_older and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


@cache
def _read_ended(path: Path, changed: int, parameters: Parameters) -> PointStatus:
    """Return the status of a point from its run file.

    ``changed`` (ns) is the time of the file. It is part of the cache key, so that each version of a
    file is opened once.
    """
    threads = parameters.cores
    try:
        run = summary_of(path, amounts(parameters))
        attributes, caveat = run.attrs, caveat_of_run(run, parameters)
        wall_time = float(attributes.get("wall_time", 0.0))
    except UNREADABLE as error:
        if is_of_system(error):
            raise
        attributes = {}
    if attributes.get("point_id") != path.stem or attributes.get("status") not in (
        "completed",
        "failed",
    ):
        reason = f"{path}: not the run file of this point; delete it and rerun"
        return PointStatus("failed", threads, reason)
    outdated = numerics_of(attributes) != NUMERICS
    if not outdated and not has_enough(path, parameters):
        # The run must still grow.
        return PointStatus("waiting", threads)
    return PointStatus(
        "done" if attributes["status"] == "completed" else "failed",
        threads,
        reason=str(attributes.get("reason", "")),
        core_seconds=max(0.0, wall_time) * threads,
        outdated=outdated,
        caveat=caveat,
    )


def _time_left(
    points: Mapping[str, PointStatus], parameters: Mapping[str, Parameters]
) -> tuple[float, float, bool]:
    """Return `core_seconds_left`, `longest_left` and `at_most` of a study."""
    factors = _factors(points, parameters)
    total, longest, at_most = 0.0, 0.0, False
    for key, point in points.items():
        if point.state in ENDED_STATES or (point.shared and point.shared.is_enough):
            continue
        values = parameters[key]
        seconds_left = (
            point.progress.remaining_seconds
            if point.progress and point.state == "running"
            else None
        )
        if seconds_left is None:
            factor = factors.get(_kind(values))
            core_seconds = PROCESS_TIME + _computing_seconds(values) * (factor or 1.0)
            is_bound = factor is None
        else:
            core_seconds, is_bound = seconds_left * point.threads, True
        total += core_seconds
        longest = max(longest, core_seconds / point.threads)
        at_most |= is_bound and may_end_early(values)
    return total, longest, at_most


def _factors(
    points: Mapping[str, PointStatus], parameters: Mapping[str, Parameters]
) -> dict[tuple[str, bool], float]:
    """Return by kind the ratio of measured to estimated time, over the points that are done."""
    measured: dict[tuple[str, bool], float] = {}
    estimated: dict[tuple[str, bool], float] = {}
    for key, point in points.items():
        if point.state == "done" and point.core_seconds > 0:
            kind, computing = _kind(parameters[key]), _computing_seconds(parameters[key])
            measured[kind] = measured.get(kind, 0.0) + point.core_seconds
            estimated[kind] = estimated.get(kind, 0.0) + computing
    return {kind: measured[kind] / estimated[kind] for kind in measured}


def _kind(parameters: Parameters) -> tuple[str, bool]:
    """Return the kind of a point: points of one kind share the ratio in `_factors`."""
    return parameters.system, may_end_early(parameters)


def _computing_seconds(parameters: Parameters) -> float:
    """Return the estimated core seconds of a run without the start of its process.

    The times in run files exclude that start, too.
    """
    return estimate(parameters).core_seconds - PROCESS_TIME
