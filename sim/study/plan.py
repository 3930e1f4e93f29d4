"""The plan of a workflow: which points of a study it runs, in which jobs, and at which cost."""

import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from heapq import heappop, heappush
from math import ceil
from operator import attrgetter
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from sim.base.errors import InputError
from sim.base.files import age, atomic_write, lock_of, read_regular
from sim.parameters import RUN_FILE, Parameters, canonical_json
from sim.parameters.given import STATES, write_states
from sim.parameters.laws import engine_of
from sim.study.model import Estimate, Need, Study, estimate

#: Limits on the computing time (s) of a batch. Between them, there is one batch for every core.
#: A point that takes more than half of the maximum has a process of its own. And maximum number of
#: points in a batch: for each point, Snakemake looks through the whole batch.
MIN_BATCH_SECONDS, MAX_BATCH_SECONDS, MAX_BATCH_POINTS = 3.0, 60.0, 50


def plan_batches(points: Mapping[str, Parameters], cores: float | None) -> dict[str, list[str]]:
    """Return a map from the name of each batch of short points to their ids, longest first.

    A point is in no batch if it takes long, needs several threads or would be the only one of its
    batch. If the number of ``cores`` is unknown, as on a cluster, batches are as long as allowed:
    there, each batch is a job, which takes seconds to start.
    """
    seconds = {}
    for name, point in points.items():
        cost = estimate(point)
        if cost.threads == 1 and cost.core_seconds <= MAX_BATCH_SECONDS / 2:
            seconds[name] = cost.core_seconds
    total = sum(seconds.values())
    share = max(total / cores, MIN_BATCH_SECONDS) if cores else MAX_BATCH_SECONDS
    batch_seconds = min(share, MAX_BATCH_SECONDS)
    number = max(ceil(total / batch_seconds), ceil(len(seconds) / MAX_BATCH_POINTS))
    batches: list[list[str]] = [[] for _ in range(number)]
    open_batches = [(0.0, index) for index in range(number)]
    # Longest points first, each to the shortest batch: all batches end at about the same time.
    for name in sorted(seconds, key=lambda name: (-seconds[name], name)):
        seconds_taken, index = heappop(open_batches)
        batches[index].append(name)
        if len(batches[index]) < MAX_BATCH_POINTS:
            heappush(open_batches, (seconds_taken + seconds[name], index))
    shared = [members for members in batches if len(members) > 1]
    hashes = (hashlib.sha256(" ".join(members).encode()).hexdigest() for members in shared)
    return {f"batch_{one[:8]}": members for one, members in zip(hashes, shared, strict=True)}


class Plan:
    """What the rules of the workflow ask of a study, whose results are in ``folder``.

    Points are given by their ids. The module ``run_files`` says how much run files hold
    (`sim.engine.stored_run`), and ``read_round`` reads the points that a round of refinement adds.
    ``shared_runs`` takes runs of other studies (`sim.engine.shared_runs`), where points lack a run
    file that has enough; they count as run files of this study, also before `take_shared`.
    """

    def __init__(
        self,
        study: Study,
        folder: Path,
        run_files: Any,
        read_round: Callable[[Path], Mapping[str, Parameters]],
        shared_runs: Any = None,
    ):
        self.study, self.folder = study, folder
        self._run_files, self._read_round = run_files, read_round
        self._shared_runs, self._shared = shared_runs, dict[str, Any]()
        for path in sorted((folder / "adopted").glob("*.nc")):
            raise InputError(
                f"{path}: adopted by an earlier version; to take its rows over into run files, "
                f"run: talus job adopt {study.path} {path}; then remove it"
            )
        #: Points that are to be run since others start from them, though they have been adopted.
        self._starts = set[str]()
        self._reduced: list[str] = []
        points = self._points()
        self._look_up(points, points)
        self._amount_texts: dict[str, str] = {}
        #: Points of each round by its file and when that was written.
        self._rounds: dict[tuple[Path, int], Mapping[str, Parameters]] = {}
        self._owner, self._batches = folder / ".study", folder / "runs" / ".batches"
        points_code = hashlib.sha256(" ".join(sorted(study.points)).encode()).hexdigest()
        self._own_note = os.fsencode(study.path.resolve()) + b"\n" + points_code.encode()

    def _points(self) -> dict[str, Parameters]:
        return {key: point.parameters for key, point in self.study.points.items()}

    def parameters(self, point: str) -> Parameters:
        """Return the parameters of a point, from the study or any round of refinement."""
        if point in self.study.points:
            return self.study.points[point].parameters
        for path in sorted((self.folder / "rounds").glob("*.json")):
            version = path, path.stat().st_mtime_ns
            if version not in self._rounds:
                self._rounds[version] = self._read_round(path)
            if added := self._rounds[version].get(point):
                return added
        raise InputError(f"{point}: no point of {self.study.path}")

    def run_file(self, point: str) -> str:
        """Return the path of the run file of a point."""
        return f"{self.folder}/runs/{point}.nc"

    def origin_files(self, point: str) -> list[str]:
        """Return a list with the run file that a point starts from; for most points it is empty."""
        start = self.parameters(point).start_from
        return [start if start.endswith(RUN_FILE) else self.readable_file(start)] if start else []

    def readable_file(self, point: str) -> str:
        """Return the run file of a point, or the one of another study that will be taken."""
        shared = self._shared.get(point)
        return str(shared.path) if shared and shared.is_enough else self.run_file(point)

    @property
    def shared_line(self) -> str:
        """Line on the points that other studies have; empty where there are none."""
        return self._shared_runs.describe(self._shared.values()) if self._shared_runs else ""

    def take_shared(self, forget: Callable[[str], object]) -> None:
        """Take the runs of other studies; ``forget`` what is recorded of run files of these names.

        What is damaged is run. Run files of adopted points have come from elsewhere, too.
        """
        for point in self._reduced:
            forget(self.run_file(point))
        self._reduced = []
        shared, self._shared = self._shared, {}
        if self._shared_runs and shared:
            for point in self._shared_runs.take_runs(self.folder / "runs", shared):
                forget(self.run_file(point))
        for point in shared:
            self._amount_texts.pop(point, None)
            self.needs_run(point)

    def _look_up(self, new: Mapping[str, Parameters], points: Mapping[str, Parameters]) -> None:
        """Look up which new ones of all points are adopted or have been run elsewhere."""
        runs = self.folder / "runs"
        self._starts |= self._run_files.starts_to_run(runs, points, self.study.need)
        if self._shared_runs:
            is_reduced = self._run_files.is_reduced
            self._reduced += [key for key in new if is_reduced(runs / f"{key}.nc", new[key])]
            self._shared |= self._shared_runs.find_runs(runs, new, self._need)

    def _need(self, point: str) -> Need | None:
        """Return what is needed of a point; None where others that are to be run start from it."""
        return None if point in self._starts else self.study.need(point)

    def files_to_gather(
        self, rounds: Iterable[Path], forget: Callable[[str], object] | None = None
    ) -> list[str]:
        """Return the run files of the study and of some rounds.

        The files of ``rounds`` are read one by one; a round that adds no point is the last one.
        With ``forget``, `take_shared` is called.
        """
        points = self._points()
        for path in rounds:
            if not (added := self._read_round(path)):
                break
            points |= added
            self._look_up(added, points)
            for point in added:
                self.needs_run(point)
        if forget:
            self.take_shared(forget)
        return list(map(self.readable_file, points))

    def needs_run(self, point: str) -> bool:
        """True where a point lacks a run file with the present numerics and large enough amounts.

        A file that has less is dated back until it suffices. Snakemake records the
        parameters of a failed job as if it were done, so they cannot show that the file must grow.
        """
        if shared := self._shared.get(point):
            return not shared.is_enough
        path, parameters = Path(self.run_file(point)), self.parameters(point)
        need = self._need(point)
        is_enough = self._run_files.has_enough(path, parameters, need)
        age(path, not is_enough and self._run_files.needs_growth(path, parameters, need))
        return not is_enough

    def amount_text(self, point: str) -> str:
        """Return a text with the amounts that the run file of a point has, or will have.

        That of one with large enough amounts stays, so Snakemake only reruns others.
        """
        if point not in self._amount_texts:
            shared, parameters = self._shared.get(point), self.parameters(point)
            path = shared.path if shared else Path(self.run_file(point))
            planned = self._run_files.planned_amounts(path, parameters, self._need(point))
            self._amount_texts[point] = json.dumps(planned, sort_keys=True)
        return self._amount_texts[point]

    def points_json(self, points: Iterable[str]) -> str:
        """Return the parameters of points as a JSON list."""
        return f"[{','.join(canonical_json(self.parameters(point)) for point in points)}]"

    def batches_to_run(self, cores: float | None) -> dict[str, list[str]]:
        """Return short points to run or to continue, by the names of their batches.

        The points of a batch have the same planned amounts, which are a parameter of the rule, and
        start from no other point. ``cores`` is that of `plan_batches`.
        """
        points_by_amount: dict[str, dict[str, Parameters]] = defaultdict(dict)
        for point in self.study.points:
            if self.needs_run(point) and not self.origin_files(point):
                points_by_amount[self.amount_text(point)][point] = self.parameters(point)
        batches = (plan_batches(points, cores) for points in points_by_amount.values())
        return {name: members for each in batches for name, members in each.items()}

    def read_batches(self) -> dict[str, list[str]]:
        """Return the batches planned by the main Snakemake, for a job on a cluster."""
        return json.loads(read_regular(self._batches))

    def start(self, batches: Mapping[str, Sequence[str]]) -> FileLock:
        """Write notes for jobs and later workflows; return the lock of the results.

        Keep the lock while the workflow lives: the kernel releases it with the process. On a file
        system without locks, there is none. Raises ``InputError`` when another workflow has it.
        """
        self._batches.parent.mkdir(parents=True, exist_ok=True)
        lock = lock_of(self.folder / ".lock")
        try:
            lock.acquire(blocking=False)
        except Timeout:
            what = "its workflow is running; talus status tells how far it is"
            raise InputError(f"{self.folder}: cannot be locked: {what}") from None
        except OSError:
            pass  # no locks on this file system
        write_states(self._batches.parent / STATES, self._points().values())
        notes = {self._owner: self._own_note, self._batches: json.dumps(batches).encode()}
        for path, content in notes.items():
            with atomic_write(path) as temporary:
                temporary.write_bytes(content)
        return lock

    def estimates(self, points: Iterable[str]) -> list[Estimate]:
        """Return the estimated costs of points."""
        return [estimate(self.parameters(point)) for point in points]

    @property
    def ranks(self) -> dict[str, int]:
        """Number of processes of the points of the study that run as more than one."""
        ranks = {key: getattr(point, "ranks", 1) for key, point in self._points().items()}
        return {key: number for key, number in ranks.items() if number > 1}

    def require_engines(self) -> None:
        """Raise `InputError` where a point to run is one of an engine that is not installed."""
        for key, point in self._points().items():
            has_engine = getattr(point, "engine", "") and point.option("engine").module
            if has_engine and self.needs_run(key):
                engine_of(point)

    def core_seconds(self, points: Iterable[str]) -> float:
        """Return the time (s) that points take together on one core."""
        return sum(cost.core_seconds for cost in self.estimates(points))

    def minutes(self, points: Iterable[str]) -> int:
        """Return the run time (min) of a job: 10 min plus three times the estimate."""
        return 10 + int(self.core_seconds(points) / 20)

    def memory(self, megabytes: int) -> int:
        """Return the memory (MB) of a job: on a cluster, two Snakemakes besides its command."""
        return 400 + len(self.study.points) // 50 + megabytes

    @property
    def reader_resources(self) -> dict[str, int]:
        """Resources of jobs that read all runs or their dataset."""
        count = len(self.study.points)
        return {"mem_mb": self.memory(700 + count // 5), "runtime": 20 + count // 200}

    @property
    def figure_files(self) -> list[tuple[str, str, str]]:
        """Path, figure and kind of each figure's files; no kind if not in Snakemake's report."""
        kinds = {".csv": "data", ".svg": "picture", ".gif": "animation"}
        files = []
        for name, spec in self.study.entries.items():
            for suffix in spec.suffixes:
                kind = "" if spec.animated and suffix == ".csv" else kinds.get(suffix, "")
                files.append((f"{self.folder}/figures/{name}{suffix}", name, kind))
        return files

    @property
    def answer_files(self) -> list[str]:
        """Paths of the files with the answers to the questions of the study."""
        return [f"{self.folder}/{one.file}" for one in self.study.questions]

    @property
    def questions(self) -> list[tuple[Any, ...]]:
        """Settings of the questions of the study; rules rerun when they change."""
        asked, series = self.study.questions, self.study.series
        return [(one.settings, self.points_json(series[one.of.series][:1])) for one in asked]

    @property
    def boundary_searches(self) -> list[tuple[Any, ...]]:
        """Settings of the boundaries of the study; rules rerun when they change."""
        search = attrgetter("name", "of", "along", "low", "high", "tolerance")
        return [
            (*search(one), canonical_json(one.parameters_at(one.low)), one.figures)
            for one in self.study.boundaries
        ]

    @property
    def namesake_warning(self) -> str:
        """Warning that another study file has its results in the same folder, or an empty text.

        Names of run files derive from their points. So the two studies share the runs of common
        points and keep all others; the rest of the folder follows the study file that was run last.
        """
        # A damaged note names no study; the workflow rewrites it.
        with suppress(OSError, ValueError):
            notes = read_regular(self._owner), self._own_note
            (path, points), (own_path, own_points) = (one.rsplit(b"\n", 1) for one in notes)
            other = Path(os.fsdecode(path))
            if path != own_path and points != own_points and other.is_file():
                return (
                    f"warning: {self.study.path}: study: {self.study.name} is also the name of "
                    f"{other}; dataset, figures and report will be those of the former"
                )
        return ""
