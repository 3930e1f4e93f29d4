"""A study continued elsewhere from a dataset: only points that the dataset lacks are run."""

import shutil
from pathlib import Path

import pytest
import xarray as xr

from sim.dataset.adopted import adopt
from sim.dataset.build import build
from sim.study.load import load_study
from tests.golden import CLOCK
from tests.made.project import jobs, plan, planned_jobs, points, snakemake
from tests.made.runs import write_run

STUDY = """\
study: small
defaults: {belt: {beads: 10, width: 5, steps_per_cycle: 1000, transient: 1, average: %s}}
series: [{name: beds, system: belt, grid: {frequency: [20, 30, 40, 50]}}]
plots: [{name: velocity, x: frequency, y: velocity}]
"""


@pytest.fixture(scope="module")
def finished_tree(tmp_path_factory) -> Path:
    """Return a folder with a finished study, its dataset, and a dataset of half of its points.

    Its runs are made up.
    """
    tree = tmp_path_factory.mktemp("straight")
    (tree / "small.yaml").write_text(STUDY % 2)
    for point in load_study(tree / "small.yaml", tree / "results").points.values():
        write_run(tree / "results/small/runs", point.parameters)
    build(tree / "small.yaml", tree / "results")
    (tree / "half.yaml").write_text((STUDY % 2).replace(", 40, 50", ""))
    build(tree / "half.yaml", tree / "results", finished=tree / "half.nc")
    return tree


def frequencies(output: str) -> set[str]:
    return {point.split("-")[1].removeprefix("frequency") for point in points(output)}


def test_only_what_the_dataset_has_not_is_run(finished_tree, tmp_path):
    path, results = tmp_path / "small.yaml", tmp_path / "results"
    path.write_text(STUDY % 2)
    adopt(path, finished_tree / "half.nc", results)
    dry_run = plan(tmp_path, study="small.yaml")
    assert frequencies(dry_run) == {"40", "50"}
    assert jobs(dry_run)["dataset"] == jobs(dry_run)["warm"] == 1
    process = snakemake(tmp_path, "dataset", study="small.yaml")
    assert process.returncode == 0, process.stderr
    assert "4 points: 4 done" in process.stderr
    run_files = [
        path
        for path in (results / "small" / "runs").glob("*.nc")
        if "frequency40" in path.name or "frequency50" in path.name
    ]
    assert len(run_files) == 2
    assert planned_jobs(tmp_path, "dataset", study="small.yaml") == {}
    straight = tmp_path / "straight"
    shutil.copytree(finished_tree / "results", straight)
    for file in run_files:
        shutil.copy(file, straight / "small" / "runs")
    build(path, straight)
    groups = [None, "natural", "si", "belt"]
    for group in groups:
        one, other = (
            xr.load_dataset(folder / "small/dataset.nc", group=group)
            for folder in (results, straight)
        )
        times = [name for name in CLOCK if name in one]
        xr.testing.assert_equal(one.drop_vars(times), other.drop_vars(times))
    # More of each point is none of the dataset's; time series need whole runs.
    (tmp_path / "more.yaml").write_text(STUDY % 3)
    assert len(frequencies(plan(tmp_path, study="more.yaml"))) == 4
    series = "y: velocity}, {name: v, kind: time_series, y: velocity}]"
    (tmp_path / "series.yaml").write_text((STUDY % 2).replace("y: velocity}]", series))
    assert frequencies(plan(tmp_path, study="series.yaml")) == {"20", "30"}
    # What Snakemake has recorded of smaller runs does not make larger ones run that are adopted.
    for one in load_study(tmp_path / "more.yaml").points.values():
        write_run(tmp_path / "made" / "small" / "runs", one.parameters)
    adopt(tmp_path / "more.yaml", build(tmp_path / "more.yaml", tmp_path / "made"), results)
    process = snakemake(tmp_path, "runs", study="more.yaml")
    assert (process.returncode, points(process.stderr)) == (0, []), process.stderr


def test_a_dataset_of_all_points_leaves_nothing_to_run(finished_tree, tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(STUDY % 2)
    adopt(path, finished_tree / "results/small/dataset.nc", tmp_path / "results")
    assert planned_jobs(tmp_path, "dataset", study="small.yaml") == {"dataset": 1}
    # Where the runs themselves are, a dataset changes nothing of what is run.
    adopt(finished_tree / "small.yaml", finished_tree / "half.nc", finished_tree / "results")
    assert planned_jobs(finished_tree, "dataset", study="small.yaml") == {"dataset": 1}


def test_what_a_point_that_is_run_starts_from_is_run_too(tmp_path):
    text = "study: small\nseries: [{name: beds, system: belt, cases: [{frequency: 20}%s]}]\n"
    path, results = tmp_path / "small.yaml", tmp_path / "results"
    path.write_text(text % "")
    ((first, point),) = load_study(path, results).points.items()
    write_run(tmp_path / "made" / "small" / "runs", point.parameters)
    adopt(path, build(path, tmp_path / "made"), results)
    assert planned_jobs(tmp_path, "dataset", study="small.yaml") == {"dataset": 1}
    path.write_text(text % f", {{frequency: 40, start_from: {first}}}")
    assert set(points(plan(tmp_path, "dataset", study="small.yaml"))) == {
        *load_study(path, results).points
    }
