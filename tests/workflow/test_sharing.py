"""What one study has run, no other study of the same results runs again."""

import json
import os
from pathlib import Path

import pytest
import xarray as xr

from sim.base.seals import is_damaged
from sim.dataset.sources import EARLIER_FILE
from sim.engine.command import batch
from sim.parameters import canonical_values
from sim.study.load import load_study
from tests.golden import CLOCK
from tests.made.project import jobs, plan, planned_jobs, planned_points, snakemake

STUDY = """\
study: %s
defaults: {belt: {beads: 10, width: 5, steps_per_cycle: 1000, transient: 1, average: %d}}
series: [{name: beds, system: belt, grid: {frequency: %s}}]
"""


def write(tree: Path, name: str, average: int = 2, frequencies: str = "[20, 30]") -> str:
    (tree / f"{name}.yaml").write_text(STUDY % (name, average, frequencies))
    return f"{name}.yaml"


def run_files(tree: Path, name: str) -> dict[str, Path]:
    return {path.stem: path for path in (tree / "results" / name / "runs").glob("*.nc")}


def read_runs(tree: Path, name: str) -> dict[str, tuple[bytes, int]]:
    """Return contents and times of the run files of a study."""
    files = run_files(tree, name).items()
    return {key: (path.read_bytes(), path.stat().st_mtime_ns) for key, path in files}


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder with a finished study of two points."""
    tree = tmp_path_factory.mktemp("tree")
    process = snakemake(tree, "dataset", study=write(tree, "first"))
    assert process.returncode == 0, process.stderr
    return tree


def test_a_copy_of_a_finished_study_runs_nothing(tree):
    study = write(tree, "copy")
    dry_run = plan(tree, "dataset", study=study)
    assert jobs(dry_run) == {"dataset": 1}
    assert "2 points in other studies, not to be run: first (2)" in dry_run
    assert not (tree / "results" / "copy").exists()
    process = snakemake(tree, "dataset", study=study)
    assert process.returncode == 0, process.stderr
    assert jobs(process.stderr) == {"dataset": 1}
    first, copy = run_files(tree, "first"), run_files(tree, "copy")
    assert first.keys() == copy.keys()
    assert all(copy[key].samefile(path) for key, path in first.items())
    datasets = (xr.load_dataset(tree / f"results/{name}/dataset.nc") for name in ("first", "copy"))
    one, other = (data.drop_vars([n for n in CLOCK if n in data]) for data in datasets)
    xr.testing.assert_equal(one, other)
    for name in ("first", "copy"):
        assert planned_jobs(tree, "dataset", study=f"{name}.yaml") == {}


def test_what_is_there_is_taken_grows_apart_and_the_rest_runs(tree):
    """Compiling for the new point does not rerun those that were taken."""
    first = read_runs(tree, "first")
    study = write(tree, "larger", 4, "[20, 40]")
    process = snakemake(tree, "dataset", study=study)
    assert process.returncode == 0, process.stderr
    # The file of the first study is that of its copy, too.
    assert "1 point in other studies, from which runs here grow: copy (1)" in process.stderr
    (shared,) = run_files(tree, "larger").keys() & first.keys()
    log = tree / "results" / "larger" / "logs" / "runs" / f"{shared}.log"
    assert f"{shared}.nc: grows\n" in log.read_text()
    assert read_runs(tree, "first") == first
    assert planned_jobs(tree, "dataset", study="first.yaml") == {}
    # Taken beside a new point, it is not run because the engine is compiled for that.
    assert planned_points(tree, "dataset", study=write(tree, "wider", 4, "[20, 50]")) == set(
        load_study(tree / "wider.yaml", tree / "results").points
    ) - {shared}


def test_a_job_looks_again_just_before_it_computes(tree, tmp_path, monkeypatch):
    points = load_study(tree / "first.yaml", tree / "results").points
    *_, key = points
    results = tree / "results" / "late"
    text = json.dumps([canonical_values(points[key].parameters)])
    read, write = os.pipe()
    os.write(write, text.encode())
    os.close(write)
    with os.fdopen(read) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        assert batch(results) == 0
    assert run_files(tree, "late")[key].samefile(run_files(tree, "first")[key])
    log = (results / "logs" / "runs" / f"{key}.log").read_text()
    assert f"{key}: taken from " in log and log.endswith("already there\n")


def test_damage_in_a_shared_run_is_told_for_all_studies_and_healed_once(tree):
    """A flipped bit in a file is one in all studies that have it."""
    for name in ("second", "third"):
        assert snakemake(tree, "dataset", study=write(tree, name)).returncode == 0
    files = [run_files(tree, name) for name in ("first", "second", "third")]
    key = min(files[0])
    content = bytearray(files[0][key].read_bytes())
    content[len(content) // 2] ^= 1
    with files[0][key].open("r+b") as file:
        file.write(content)
    for kept in ("dataset.nc", EARLIER_FILE):
        (tree / "results" / "second" / kept).unlink()
    process = snakemake(tree, "dataset", study="second.yaml")
    log = (tree / "results" / "second" / "logs" / "dataset.log").read_text()
    assert process.returncode != 0 and "now " + files[0][key].name + ".damaged, as in " in log
    assert "first" in log and "third" in log
    assert not any(one[key].exists() for one in files)
    assert all((one[key].parent / f"{key}.nc.damaged").exists() for one in files)
    assert snakemake(tree, "dataset", study="second.yaml").returncode == 0
    for name in ("first", "third"):
        assert planned_points(tree, "dataset", study=f"{name}.yaml") == set()
        assert snakemake(tree, "dataset", study=f"{name}.yaml").returncode == 0
    healed = [run_files(tree, name)[key] for name in ("first", "second", "third")]
    assert all(one.samefile(healed[0]) for one in healed) and not is_damaged(healed[0])
