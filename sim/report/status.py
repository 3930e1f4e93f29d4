"""How far a study is: the state of every point, from what lies in its folder of results."""

import re
import socket
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np
import psutil

from sim.base.damage import UNREADABLE
from sim.dataset.adopted import Adopted, Held
from sim.dataset.caveats import caveat_of_run
from sim.dataset.rounds import known_points, round_files
from sim.dataset.summary import summary_of
from sim.engine.identity import NUMERICS, numerics_of
from sim.engine.progress import CREDIT, Progress, may_end_early, progress_file, read_progress
from sim.engine.stored_run import holds
from sim.parameters import Parameters, amounts
from sim.study.cost import PROCESS_TIME, estimate
from sim.study.extra_amounts import ExtraAmounts, read_extra_amounts, with_extra_amounts
from sim.study.load import Study

STATES = ("done", "failed", "adopted", "running", "interrupted", "waiting")

#: Those that a point comes to.
ENDED = STATES[:3]

#: Names of run files, and of states and progress files, of which a point that was stopped midway
#: may have nothing else.
RUN_FILES = re.compile(r"([^.].*)\.nc|\.([^.].*)\.nc\.(?:state|progress)")

#: Seconds by which the start of a process may seem later than it was: the kernel tells the time of
#: its own start in whole seconds.
START_ERROR = 2.0


@dataclass(frozen=True)
class PointStatus:
    """How far one point is.

    Attributes
    ----------
    state : str
        One of `STATES`.
    threads : int
        Threads of its run.
    reason : str
        Why it failed.
    progress : Progress or None
        What its run said last, while it is running or interrupted.
    core_seconds : float
        What its run took, wherever it was made: of a point that is done, failed or adopted.
    outdated : bool
        Whether other numerics made its run file.
    caveat : str
        What to know before trusting it, empty if nothing.
    """

    state: str
    threads: int
    reason: str = ""
    progress: Progress | None = None
    core_seconds: float = 0.0
    outdated: bool = False
    caveat: str = ""


@dataclass(frozen=True)
class Budget:
    """What rounds of decisions may add and have added, both in core hours."""

    hours: float
    spent: float

    @property
    def left(self) -> float:
        """Core hours that they may still add."""
        return max(0.0, self.hours - self.spent)


@dataclass(frozen=True)
class StudyStatus:
    """How far a study is.

    Attributes
    ----------
    name, title : str
        As in the study file.
    points : dict
        `PointStatus` by id, in the order of the study.
    core_seconds_left : float
        Estimate for all that is not done, failed or adopted, on one core.
    longest_left : float
        Longest time (s) that one of those points still takes on its own threads.
    at_most : bool
        Whether these times are bounds, because runs may end before their total.
    rounds_left : int
        Rounds of refinement whose points are not known yet, and in none of these times.
    orphans : tuple of str
        Points no longer in the study that have run files, or states of a run that was stopped. None
        as long as rounds are to come, which may ask for any.
    budget : Budget, optional
        That of a study that decides something.
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

    @property
    def counts(self) -> dict[str, int]:
        """Number of points in each of `STATES`."""
        found = [point.state for point in self.points.values()]
        return {state: found.count(state) for state in STATES}

    @property
    def caveats(self) -> int:
        """Number of points that carry a caveat."""
        return sum(bool(point.caveat) for point in self.points.values())

    @property
    def is_over(self) -> bool:
        """Whether every point, those of rounds included, is done, failed or adopted."""
        ended = all(point.state in ENDED for point in self.points.values())
        return ended and not self.rounds_left

    @property
    def cores(self) -> int:
        """Cores that running points use now."""
        return sum(point.threads for point in self.points.values() if point.state == "running")

    @property
    def core_seconds(self) -> float:
        """What the points that are done, failed or adopted took, on one core."""
        return sum(point.core_seconds for point in self.points.values())

    @property
    def left(self) -> float | None:
        """Estimated seconds to the end on as many cores as are used now; none while none is."""
        if self.is_over:
            return 0.0
        return max(self.core_seconds_left / self.cores, self.longest_left) if self.cores else None


def survey(study: Study, results: str | Path = "results") -> StudyStatus:
    """Look how far a study is. A study that has not been started has all its points waiting.

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
    parameters = known_points(study, folder)
    adopted = Adopted(study, folder).sources(parameters)
    runs = folder / "runs"
    try:
        present = {path.name for path in runs.iterdir()}
    except OSError:
        present = set()
    points = {
        key: _look(key, value, runs, present, adopted.get(key)) for key, value in parameters.items()
    }
    to_come = study.rounds - len(round_files(study, folder))
    there = {found[1] or found[2] for name in present if (found := RUN_FILES.fullmatch(name))}
    orphans = () if to_come else tuple(sorted(there - points.keys()))
    left = _left(points, parameters)
    budget = _budget(study.decide.budget, points, extra) if study.decide else None
    return StudyStatus(study.name, study.title, points, *left, to_come, orphans, budget)


def _budget(hours: float, points: Mapping[str, PointStatus], extra: ExtraAmounts) -> Budget:
    taken = sum(point.core_seconds for point in points.values()) / 3600
    return Budget(hours, max(0.0, taken - extra.before) if extra.amounts else 0.0)


def _look(
    key: str, parameters: Parameters, runs: Path, present: set[str], adopted: Held | None
) -> PointStatus:
    """Find the state of one point. A run that goes on counts more than an earlier one's file."""
    threads = parameters.cores
    path = runs / f"{key}.nc"
    said = read_progress(path) if progress_file(path).name in present else None
    if said and said.point != key:
        said = None
    if said and _goes_on(said):
        return PointStatus("running", threads, progress=said)
    if adopted:
        took = float(np.nansum(adopted.scalars_of(parameters)["wall_time"])) * threads
        return PointStatus("adopted", threads, core_seconds=took, caveat=adopted.caveat)
    if path.name in present:
        try:
            return _finished(path, path.stat().st_mtime_ns, parameters)
        except FileNotFoundError:
            # Damaged, it has been set aside in between.
            pass
    return PointStatus("interrupted" if said else "waiting", threads, progress=said)


def _goes_on(said: Progress) -> bool:
    """Return whether the process that wrote a progress file still lives, as far as one can see."""
    if said.host != socket.gethostname():
        return said.updated - timedelta(seconds=CREDIT) <= datetime.now(UTC) <= said.expires
    try:
        process = psutil.Process(said.pid)
        # A process that started after the last word of the run has got its number.
        is_older = process.create_time() <= said.updated.timestamp() + START_ERROR
        return is_older and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


@cache
def _finished(path: Path, changed: int, parameters: Parameters) -> PointStatus:
    """Read from its file how the run of a point ended.

    ``changed`` (ns) tells one file of a name from the next, so that a watch opens each file once.
    """
    threads = parameters.cores
    try:
        run = summary_of(path, amounts(parameters))
        held, caveat = run.attrs, caveat_of_run(run, parameters)
        wall_time = float(held.get("wall_time", 0.0))
    except FileNotFoundError:
        raise
    except UNREADABLE:
        held = {}
    if held.get("point_id") != path.stem or held.get("status") not in ("completed", "failed"):
        reason = f"{path}: not the run file of this point; delete it and rerun"
        return PointStatus("failed", threads, reason)
    outdated = numerics_of(held) != NUMERICS
    if not outdated and not holds(path, parameters):
        # It is to grow.
        return PointStatus("waiting", threads)
    return PointStatus(
        "done" if held["status"] == "completed" else "failed",
        threads,
        reason=str(held.get("reason", "")),
        core_seconds=max(0.0, wall_time) * threads,
        outdated=outdated,
        caveat=caveat,
    )


def _left(
    points: Mapping[str, PointStatus], parameters: Mapping[str, Parameters]
) -> tuple[float, float, bool]:
    """Return `core_seconds_left`, `longest_left` and `at_most` of a study."""
    factors = _factors(points, parameters)
    total, longest, at_most = 0.0, 0.0, False
    for key, point in points.items():
        if point.state in ENDED:
            continue
        values = parameters[key]
        known = point.progress.left if point.progress and point.state == "running" else None
        if known is None:
            factor = factors.get(_kind(values))
            core_seconds = PROCESS_TIME + _computing(values) * (factor or 1.0)
            is_bound = factor is None
        else:
            core_seconds, is_bound = known * point.threads, True
        total += core_seconds
        longest = max(longest, core_seconds / point.threads)
        at_most |= is_bound and may_end_early(values)
    return total, longest, at_most


def _factors(
    points: Mapping[str, PointStatus], parameters: Mapping[str, Parameters]
) -> dict[tuple[str, bool], float]:
    """Return by kind how many times as long as estimated the points took that are done."""
    took: dict[tuple[str, bool], float] = {}
    estimated: dict[tuple[str, bool], float] = {}
    for key, point in points.items():
        if point.state == "done" and point.core_seconds > 0:
            kind, computing = _kind(parameters[key]), _computing(parameters[key])
            took[kind] = took.get(kind, 0.0) + point.core_seconds
            estimated[kind] = estimated.get(kind, 0.0) + computing
    return {kind: took[kind] / estimated[kind] for kind in took}


def _kind(parameters: Parameters) -> tuple[str, bool]:
    """Return which points tell how long this one takes: those that end early do so alone."""
    return parameters.system, may_end_early(parameters)


def _computing(parameters: Parameters) -> float:
    """Return the estimated core seconds of a run without the start of its process.

    That is what a run file tells of.
    """
    return estimate(parameters).core_seconds - PROCESS_TIME
