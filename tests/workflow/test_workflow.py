"""The whole way from a study file to the report, in a copy of the tree, with the real engine."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import xarray as xr

from sim.study.catalogue import FIGURES
from sim.study.load import estimate, load_study
from tests.made.project import (
    ROOT,
    STUDY,
    command,
    copy_project,
    planned,
    planned_points,
    snakemake,
)

TINY = load_study(ROOT / "tests" / "data" / STUDY)
POINTS = len(TINY.points)

#: Jobs of each rule that a new dataset entails.
AFTER_IT = {
    "figure": sum(not FIGURES[name].animated for name in TINY.figures),
    "animation": sum(FIGURES[name].animated for name in TINY.figures),
    "claims": 1,
    "report": 1,
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a copy of the project in which the tiny study has run to its end."""
    tree = copy_project(tmp_path_factory.mktemp("tree"))
    done = snakemake(tree)
    assert done.returncode == 0, done.stderr
    return tree


@pytest.fixture
def edited(tree) -> Iterator:
    """Return a function that appends a line to a file of the tree; undone after the test."""
    originals: dict[Path, bytes] = {}

    def edit(name: str, line: str = "# edited") -> None:
        path = tree / name
        originals[path] = path.read_bytes()
        path.write_bytes(originals[path] + f"\n{line}\n".encode())

    yield edit
    for path, content in originals.items():
        path.write_bytes(content)


def test_everything_is_made(tree):
    results = tree / "results" / "tiny"
    study = load_study(tree / STUDY, tree / "results")
    runs = {path.stem for path in (results / "runs").glob("*.nc")}
    assert runs == set(study.points)
    assert list(study.figures) == [name for name, spec in FIGURES.items() if not spec.regimes]
    for name in study.figures:
        for suffix in FIGURES[name].suffixes:
            assert (results / "figures" / f"{name}{suffix}").stat().st_size > 0
    for made in (*(f"runs/{point}" for point in runs), "dataset", "figures/walton_2", "report"):
        assert (results / "logs" / f"{made}.log").is_file()
        assert "s\th:m:s" in (results / "benchmarks" / f"{made}.tsv").read_text()
    assert "Tiny study of the tests" in (results / "report.html").read_text()


def test_a_failed_point_is_recorded_and_leaves_the_rest_standing(tree):
    with xr.open_dataset(tree / "results" / "tiny" / "dataset.nc") as dataset:
        status = dataset["status"].values[:, 0]
        failed = dataset.isel(point=status == "failed")
        assert (failed["frequency"].values == [80.0]).all()
        assert "overlap" in failed["reason"].values[0, 0]
        assert (status == "completed").sum() == dataset.sizes["point"] - 1
    caption = (tree / "results" / "tiny" / "figures" / "gallas_1a.caption.txt").read_text()
    assert "Left out because the run failed: belt-frequency80" in caption
    report = (tree / "results" / "tiny" / "report.html").read_text()
    assert f"1 of {POINTS} points failed" in report


def test_logs_of_runs_say_how_they_went(tree):
    logs = list((tree / "results" / "tiny" / "logs" / "runs").glob("*.log"))
    assert len(logs) == POINTS
    for log in logs:
        first, *_, closing, written = log.read_text().splitlines()
        assert first.startswith(f"{log.stem}: ") and first.endswith("steps")
        assert "velocity" in closing or "failed" in closing
        assert written.endswith("written")


def test_a_workflow_ends_with_a_summary_and_a_dry_run_does_not(tree):
    made = snakemake(tree, "report", "--forcerun", "report")
    assert made.returncode == 0, made.stderr
    assert f"{POINTS} points: {POINTS - 1} done, 1 failed" in made.stderr
    dry = snakemake(tree, "-n", "report", "--forcerun", "report")
    assert dry.returncode == 0
    assert f"{POINTS} points" not in dry.stdout + dry.stderr


def test_a_workflow_that_fails_ends_with_a_summary(tree):
    broken = tree / "sim" / "report" / "page.py"
    content = broken.read_bytes()
    broken.write_text("raise SystemExit(1)")
    failed = snakemake(tree, "report")
    broken.write_bytes(content)
    made = snakemake(tree, "report")
    assert failed.returncode != 0 and made.returncode == 0
    assert f"{POINTS} points: {POINTS - 1} done, 1 failed" in failed.stderr


def test_nothing_is_left_to_do(tree):
    assert planned(tree) == {}


def test_a_study_without_boundaries_knows_no_rounds(tree):
    assert not (tree / "results" / "tiny" / "rounds").exists()
    assert "checkpoint" not in snakemake(tree, "-n", "--forceall").stdout


def test_an_added_grid_value_runs_the_new_points_alone(tree):
    text = (tree / STUDY).read_text().replace("depth: [0.5, 1]", "depth: [0.5, 1, 2]")
    (tree / "wider.yaml").write_text(text)
    jobs = planned(tree, study="wider.yaml")
    assert jobs == {"run": 2, "dataset": 1, **AFTER_IT}
    points = planned_points(tree, study="wider.yaml")
    assert {point.split("-")[1] for point in points} == {"depth2"}


def test_a_changed_parameter_runs_the_points_it_touches(tree):
    text = (tree / STUDY).read_text().replace("friction: 0.5", "friction: 0.6")
    (tree / "changed.yaml").write_text(text)
    points = planned_points(tree, study="changed.yaml")
    assert [point.rpartition("-")[0] for point in points] == [
        "chute-depth1-friction0.6-restitution0.85-stiffness100"
    ]


def test_an_edit_of_the_engine_runs_nothing_while_the_numerics_stay(tree, edited):
    edited("sim/engine/contact/damping.py")
    assert planned(tree) == {}


def test_other_numerics_run_everything(tree, edited):
    edited("sim/engine/identity.py", "NUMERICS = 2")
    assert planned(tree) == {"warm": 1, "run": POINTS, "dataset": 1, **AFTER_IT}


def test_an_edit_of_a_figure_redraws_that_figure(tree, edited):
    edited("sim/study/catalogue/__init__.py", 'FIGURES["gallas_1a"].options["edited"] = 1')
    assert planned(tree) == {"figure": 1, "report": 1}


def test_an_edit_of_the_dataset_runs_nothing(tree, edited):
    edited("sim/dataset/build/build.py")
    jobs = planned(tree)
    assert "run" not in jobs
    assert jobs["dataset"] == 1


def test_an_edit_of_the_report_writes_the_report(tree, edited):
    edited("sim/templates/report.html.j2", "<!-- edited -->")
    assert planned(tree) == {"report": 1}


@pytest.mark.parametrize(
    ("target", "jobs"),
    [
        ("dataset", {"dataset": 1}),
        ("report", {"report": 1}),
        ("results/tiny/figures/gallas_1b.svg", {"figure": 1}),
    ],
)
def test_targets_are_asked_for_by_name(tree, target, jobs):
    rule = next(iter(jobs))
    assert planned(tree, target, "--forcerun", rule) == jobs


def test_both_entry_points_know_the_same_work(tree):
    dry = snakemake(tree, "-n", "--snakefile", "workflow/Snakefile", "--forcerun", "report")
    assert dry.returncode == 0, dry.stderr
    assert re.search(r"^report +1$", dry.stdout, re.M)


def test_the_default_study_is_the_quick_one(tree):
    dry = subprocess.run(
        [sys.executable, "-m", "snakemake", "-n"], cwd=tree, capture_output=True, text=True
    )
    assert dry.returncode == 0, dry.stderr
    assert "results/quick/report.html" in dry.stdout + dry.stderr
    assert "results/tiny" not in dry.stdout + dry.stderr


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("study: bad\nseries: [{name: a, system: chute, base: {restitution: 0}}]\n", "restitution"),
        ("study: bad\nseries: []\n", "series"),
        ("study: bad\nsurprise: 1\n", "surprise"),
    ],
)
def test_a_bad_study_gives_one_line_and_no_work(tree, content, words):
    (tree / "bad.yaml").write_text(content)
    done = snakemake(tree, study="bad.yaml")
    assert done.returncode == 2
    (line,) = (line for line in done.stderr.splitlines() if "profile" not in line)
    assert line.startswith("error: bad.yaml: ")
    assert words in line
    assert not (tree / "results" / "bad").exists()


def test_single_values_cannot_be_overridden_behind_the_study(tree):
    done = snakemake(tree, "-n", "--config", "title=other")
    assert done.returncode == 2
    assert "error: --config" in done.stderr


def test_a_study_may_lie_anywhere(tree):
    place = tree / "{point}" / "{x} y"
    place.mkdir(parents=True)
    shutil.copy(tree / STUDY, place / STUDY)
    assert planned(tree, study=str(place / STUDY)) == {}
    made = snakemake(tree, "report", "--forcerun", "report", study=str(place / STUDY))
    assert made.returncode == 0, made.stderr


def test_a_bad_environment_gives_one_line_and_no_work(tree, monkeypatch):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", "abc")
    done = snakemake(tree)
    assert done.returncode == 2
    (line,) = (line for line in done.stderr.splitlines() if "profile" not in line)
    assert line.startswith("error: environment: TALUS_CHECKPOINT_SECONDS: got 'abc'")


def test_lint_finds_nothing(tree):
    lint = subprocess.run(
        [sys.executable, "-m", "snakemake", "--lint"], cwd=tree, capture_output=True, text=True
    )
    assert lint.returncode == 0, lint.stderr


def test_snakemake_writes_its_own_report(tree):
    done = snakemake(tree, "--report", "report.zip")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(tree / "report.zip") as archive:
        names = archive.namelist()
        page = archive.read("report/report.html").decode()
    assert any(name.endswith("gallas_1a.svg") for name in names)
    assert "drawn from" in page


class Killed:
    """A workflow over all points on one core, killed in the middle of its runs."""

    def __init__(self, tree: Path):
        shutil.copy(tree / STUDY, tree / "killed.yaml")
        text = (tree / STUDY).read_text().replace("study: tiny", "study: killed")
        (tree / "killed.yaml").write_text(text)
        self.runs = tree / "results" / "killed" / "runs"
        with (tree / "killed.log").open("w") as log:
            process = subprocess.Popen(
                command("runs", "--cores", "1", study="killed.yaml"),
                cwd=tree,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
            self._wait_for_runs(process, 3)
            self.second = snakemake(tree, "runs", study="killed.yaml")
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        self.before = {path: path.stat().st_mtime_ns for path in self.runs.glob("*.nc")}
        self.log = (tree / "killed.log").read_text()
        self.resumed = snakemake(tree, "runs", study="killed.yaml")

    def _wait_for_runs(self, process: subprocess.Popen, count: int) -> None:
        limit = time.monotonic() + 120
        while len(list(self.runs.glob("*.nc"))) < count:
            assert process.poll() is None, "ended before it could be killed"
            assert time.monotonic() < limit
            time.sleep(0.05)


@pytest.fixture(scope="module")
def killed(tree) -> Killed:
    return Killed(tree)


def test_a_killed_workflow_resumes_by_itself(tree, killed):
    study = load_study(tree / "killed.yaml", tree / "results")
    assert len(killed.before) < len(study.points)
    assert killed.resumed.returncode == 0, killed.resumed.stderr
    assert {path.stem for path in killed.runs.glob("*.nc")} == set(study.points)
    rerun = [path for path, changed in killed.before.items() if path.stat().st_mtime_ns != changed]
    assert len(rerun) <= 1
    assert not list(killed.runs.glob("*.part"))


def test_a_living_workflow_keeps_its_lock(killed):
    assert killed.second.returncode != 0
    assert "cannot be locked" in killed.second.stdout + killed.second.stderr


def test_the_longest_points_start_first(tree, killed):
    study = load_study(tree / "killed.yaml", tree / "results")
    started = re.findall(r"wildcards: point=(\S+)", killed.log)
    costs = [estimate(study.points[point].parameters).core_seconds for point in started]
    everything = [estimate(point.parameters).core_seconds for point in study.points.values()]
    assert len(costs) >= 3
    assert costs == sorted(everything, reverse=True)[: len(costs)]


def test_a_damaged_run_is_named_and_computed_again_by_a_rerun(tree):
    results = tree / "results" / "tiny"
    path = next((results / "runs").glob("belt-*.nc"))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    first = snakemake(tree)
    assert first.returncode != 0
    assert f"error: results/tiny/runs/{path.name}: damaged" in first.stdout + first.stderr
    assert path.with_name(f"{path.name}.damaged").exists()
    assert planned_points(tree) == {path.stem}
    again = snakemake(tree)
    assert again.returncode == 0, again.stderr
    assert len(path.read_bytes()) == pytest.approx(len(whole), rel=0.01)
    assert planned(tree) == {}


def test_a_clock_that_was_ahead_makes_nothing_old_and_hides_nothing(tree):
    results = tree / "results" / "tiny"
    ahead = time.time() + 1e8
    for path in results.rglob("*"):
        os.utime(path, (ahead, ahead))
    assert planned(tree) == {}
    assert all(path.stat().st_mtime < ahead for path in results.rglob("*") if path.is_file())
    run = next((results / "runs").glob("belt-*.nc"))
    whole = run.read_bytes()
    os.utime(results / "dataset.nc", (ahead, ahead))
    run.write_bytes(whole + b"changed")
    assert planned(tree)["dataset"] == 1
    run.write_bytes(whole)
    assert planned(tree) == {}


def test_a_second_study_of_the_same_name_is_pointed_out(tree):
    text = (tree / STUDY).read_text()
    (tree / "copy.yaml").write_text(text)
    assert "warning" not in snakemake(tree, "-n", study="copy.yaml").stderr
    (tree / "other.yaml").write_text(text.replace("depth: [0.5, 1]", "depth: [0.5, 3]"))
    warned = snakemake(tree, "-n", study="other.yaml")
    assert warned.returncode == 0
    assert "warning: other.yaml: study: tiny is also the name of" in warned.stderr
