"""The workflow from a study file to the report, with the real engine."""

import json
import shutil
import zipfile
from pathlib import Path

import netCDF4
import pytest
import xarray as xr

from sim.study.load import load_study
from tests.made.processes import ROOT
from tests.made.project import (
    STUDY,
    bare_folder,
    jobs,
    plan,
    planned_jobs,
    planned_points,
    points,
    snakemake,
)

TINY = load_study(ROOT / "tests" / "data" / STUDY)
POINTS = len(TINY.points)

#: Jobs of each rule that a new dataset entails, and those of a new study.
JOBS_AFTER_DATASET = {"figures": 1, "claims": 1, "report": 1}
ALL_JOBS = {"warm": 1, "batch": 1, "dataset": 1, **JOBS_AFTER_DATASET}


@pytest.fixture(scope="module")
def messages() -> list[str]:
    """Messages of the workflow that has run the tiny study to its end."""
    return []


@pytest.fixture(scope="module")
def tree(tmp_path_factory, messages) -> Path:
    """Return a folder in which the tiny study has run to its end."""
    tree = bare_folder(tmp_path_factory.mktemp("tree"))
    process = snakemake(tree)
    assert process.returncode == 0, process.stderr
    messages.append(process.stderr)
    return tree


def test_everything_is_made(tree):
    results = tree / "results" / "tiny"
    runs = {path.stem for path in (results / "runs").glob("*.nc")}
    assert runs == set(TINY.points)
    for name, one in TINY.entries.items():
        for suffix in one.suffixes:
            assert (results / "figures" / f"{name}{suffix}").stat().st_size > 0
    for made in ("dataset", "figures", "report"):
        assert (results / "logs" / f"{made}.log").is_file()
        assert "s\th:m:s" in (results / "benchmarks" / f"{made}.tsv").read_text()
    logs = {path.stem: path.read_text().splitlines() for path in (results / "logs/runs").iterdir()}
    assert logs.keys() == runs
    for name, (first, *_, closing, written) in logs.items():
        assert first.startswith(f"{name}: ") and first.endswith("steps")
        assert "velocity" in closing or "to see the failure again" in closing
        assert written.endswith("written")
    assert "Tiny study of the tests" in (results / "report.html").read_text()
    assert not (results / "rounds").exists()


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


def test_a_workflow_does_what_it_announces_and_ends_with_a_summary(tree, messages):
    assert jobs(messages[0]) == ALL_JOBS
    assert f"{POINTS} points: {POINTS - 1} done, 1 failed" in messages[0]


def test_nothing_is_left_to_do_and_a_dry_run_sums_nothing_up(tree):
    dry_run = plan(tree)
    assert jobs(dry_run) == {}
    assert f"{POINTS} points" not in dry_run
    # A study without boundaries knows no rounds.
    dry_run = plan(tree, "--forceall")
    assert jobs(dry_run) == {"warm": 1, "run": POINTS, "dataset": 1, **JOBS_AFTER_DATASET}
    assert "checkpoint" not in dry_run


def test_new_points_share_a_batch_and_those_of_which_more_is_wanted_are_run_on_alone(tree):
    """Of a study with an added value of a grid, a changed parameter and a point that grows."""
    text = (tree / STUDY).read_text()
    for old, new in (
        ("frequency: [20, 60]", "frequency: [20, 40, 60]"),
        ("shear_damping: 1}", "shear_damping: 2}"),
        ("{frequency: 20}", "{frequency: 20, replicates: 2}"),
    ):
        assert old in text
        text = text.replace(old, new)
    (tree / "more.yaml").write_text(text)
    dry_run = plan(tree, study="more.yaml")
    names = {"-".join(point.split("-")[1:2] + point.split("-")[5:6]) for point in points(dry_run)}
    assert names == {"frequency40-shear50", "frequency10-shear2", "frequency20-shear50"}
    assert len(set(points(dry_run)) & set(TINY.points)) == 1
    assert jobs(dry_run) == {"batch": 1, "run": 1, "dataset": 1, **JOBS_AFTER_DATASET}


def test_where_less_is_wanted_or_other_figures_nothing_is_run(tree):
    text = (tree / STUDY).read_text()
    for old, new in (("average: 2", "average: 1"), ("figures: [gallas_1a]", "figures: []")):
        assert old in text
        (tree / "less.yaml").write_text(text.replace(old, new))
        old_jobs = planned_jobs(tree, study="less.yaml")
        assert old_jobs["dataset"] == 1 and old_jobs.keys() <= {"dataset", *JOBS_AFTER_DATASET}


def test_targets_are_asked_for_by_name(tree):
    assert planned_jobs(tree, "report", "--forcerun", "report") == {"report": 1}
    figure = "results/tiny/figures/gallas_4c.svg"
    assert planned_jobs(tree, figure, "--forcerun", "figures") == {"figures": 1}


def test_snakemake_writes_its_own_report(tree):
    process = snakemake(tree, "--report", "report.zip")
    assert process.returncode == 0, process.stderr
    with zipfile.ZipFile(tree / "report.zip") as archive:
        names = archive.namelist()
        page = archive.read("report/report.html").decode()
    assert any(name.endswith("gallas_1a.svg") for name in names)
    assert "drawn from" in page


def test_a_second_study_of_the_same_name_is_pointed_out(tree):
    text = (tree / STUDY).read_text()
    (tree / "copy.yaml").write_text(text)
    assert "warning" not in plan(tree, study="copy.yaml")
    (tree / "other.yaml").write_text(text.replace("frequency: [20, 60]", "frequency: [20, 30]"))
    assert "warning: other.yaml: study: tiny is also the name of" in plan(tree, study="other.yaml")


def test_a_job_on_a_cluster_knows_the_batches_of_the_workflow_that_planned(tmp_path):
    """There each job is a Snakemake of its own, started when other run files are there already."""
    tree = bare_folder(tmp_path)
    started = snakemake(tree, "--until", "warm")
    assert started.returncode == 0, started.stderr
    runs = tree / "results" / "tiny" / "runs"
    ((batch, members),) = json.loads((runs / ".batches").read_text()).items()
    (runs / f"{members[0]}.nc").touch()
    options = ("--mode", "remote", "--target-jobs", f"{batch}:", "--allowed-rules", batch)
    process = snakemake(tree, *options, "--nolock", "--force")
    assert process.returncode == 0, process.stderr
    assert {path.stem for path in runs.glob("*.nc")} == set(members) == set(TINY.points)
    assert f"{POINTS} points: " not in process.stderr


def test_the_scheduler_is_woken_by_jobs_that_end_alone(tree):
    """Its usual limit of starts per second would wake it once a second for each job that ended.

    The study may lie anywhere.
    """
    print_limit = 'print("limit", workflow.scheduler.job_rate_limiter, file=sys.stderr)'
    text = f'include: "{ROOT}/workflow/Snakefile"\n\nonsuccess:\n    {print_limit}\n'
    (tree / "told.smk").write_text(text)
    place = tree / "{point}" / "{x} y"
    place.mkdir(parents=True, exist_ok=True)
    shutil.copy(tree / STUDY, place / STUDY)
    options = ("--snakefile", "told.smk", "--forcerun", "report")
    process = snakemake(tree, *options, study=str(place / STUDY))
    assert process.returncode == 0, process.stderr
    assert jobs(process.stderr) == {"report": 1}
    assert "limit None" in process.stderr, process.stderr


#: A point that starts from another.
ORIGIN = """\
study: origin
series:
  - name: beds
    system: belt
    base: {{beads: 5, width: 5, transient: 1, average: 1}}
    cases: [{{frequency: 20}}{case}]
"""


def test_what_a_point_starts_from_runs_first(tmp_path):
    file = tmp_path / "origin.yaml"
    file.write_text(ORIGIN.format(case=""))
    (first,) = load_study(file, tmp_path).points
    file.write_text(ORIGIN.format(case=f", {{frequency: 40, start_from: {first}}}"))
    _, then = load_study(file, tmp_path).points
    assert planned_points(tmp_path, "runs", study="origin.yaml") == {first, then}
    process = snakemake(tmp_path, "runs", study="origin.yaml")
    assert process.returncode == 0, process.stderr
    assert points(process.stdout + process.stderr) == [first, then]
    runs = tmp_path / "results" / "origin" / "runs"
    assert all((runs / f"{point}.nc").exists() for point in (first, then))
    # Longer, the first one ends elsewhere, and so does what starts from it.
    text = file.read_text()
    file.write_text(text.replace("{frequency: 20}", "{frequency: 20, average: 3}"))
    process = snakemake(tmp_path, "runs", study="origin.yaml")
    assert process.returncode == 0, process.stderr
    with (
        netCDF4.Dataset(runs / f"{first}.nc") as source,
        netCDF4.Dataset(runs / f"{then}.nc") as run,
    ):
        assert run.origin == str(source.dimensions["time"].size)
    assert planned_points(tmp_path, "runs", study="origin.yaml") == set()


BRACES = """\
study: braces
title: Velocity $v_{x}$ of {what} and {}
readings: {belt: {damping_mass: [own, reduced]}}
series: [{name: a, system: belt, grid: {frequency: [20, 50]}, figures: [readings_1a]}]
plots: [{kind: curves, name: speed, series: [a], x: frequency, y: velocity, title: "{of} a belt"}]
"""


def test_braces_in_an_entry_of_the_catalogue_are_no_wildcards(tmp_path):
    folder = tmp_path / "{x}"
    folder.mkdir()
    (folder / "braces.yaml").write_text(BRACES)
    jobs = planned_jobs(tmp_path, study=str(folder / "braces.yaml"))
    assert jobs["figures"] == jobs["report"] == jobs["dataset"] == 1
