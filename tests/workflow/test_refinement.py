"""Boundaries from end to end: rounds as checkpoints, resumed, changed, in the dataset."""

import csv
import os
import signal
import subprocess
from pathlib import Path

import pytest
import xarray as xr

import sim
from sim.dataset.adopted import adopt
from sim.dataset.build import build
from sim.dataset.rounds import points_of_rounds, read_round
from sim.study.load import load_study
from sim.study.model import further_rounds
from sim.surrogates.inquiries import write_round
from tests.made.processes import ROOT, wait_until
from tests.made.project import bare_folder, command, planned_jobs, planned_points, points, snakemake
from tests.made.runs import write_run

STUDY = "onset.yaml"
TARGET = "results/onset/boundaries.csv"


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder in which the boundary was found; all runs but the last are made up."""
    tree = bare_folder(tmp_path_factory.mktemp("tree"), STUDY)
    study = load_study(tree / STUDY, tree / "made")
    new = [point.parameters for point in study.points.values()]
    for number in range(study.rounds):
        if number:
            new = list(read_round(write_round(tree / STUDY, number, tree / "made")).values())
        for one in new:
            velocity, regime = (0.05, "steady") if one.frequency > 21.2 else (0.0, "arrested")
            write_run(tree / "made" / "onset" / "runs", one, velocity, regime=regime)
    dataset = build(tree / STUDY, tree / "made", finished=tree / "onset.nc")
    adopt(tree / STUDY, dataset, tree / "results")
    process = snakemake(tree, TARGET, study=STUDY)
    assert process.returncode == 0, process.stderr
    assert set(points(process.stderr)) == set(rounds(tree)[-1])
    return tree


def rounds(tree: Path) -> list[dict]:
    folder = tree / "results" / "onset" / "rounds"
    return [read_round(path) for path in sorted(folder.glob("*.json"))]


def test_the_boundary_is_found_in_the_promised_rounds(tree):
    with (tree / TARGET).open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["below"], row["above"]) == ("no transport", "transport")
    assert float(row["high"]) - float(row["low"]) <= 1 or row["verdict"] == "wide"
    assert len(rounds(tree)) == further_rounds(8, 40, 1) == 2
    study = load_study(tree / STUDY, tree / "results")
    added = {key for round_points in rounds(tree) for key in round_points}
    with xr.open_dataset(tree / "results" / "onset" / "dataset.nc") as dataset:
        assert set(dataset["point"].values) == added | set(study.points)
        assert set(dataset["series"].values) == {"onset"}
    assert int(row["points"]) == len(added) + len(study.points)


def test_nothing_is_left_to_do_but_a_point_of_a_later_round_that_is_lost(tree):
    assert planned_jobs(tree, TARGET, study=STUDY) == {}
    (point, *_) = rounds(tree)[-1]
    path = tree / "results" / "onset" / "runs" / f"{point}.nc"
    content = path.read_bytes()
    path.unlink()
    assert planned_points(tree, study=STUDY) == {point}
    assert planned_points(tree, str(path.relative_to(tree)), study=STUDY) == {point}
    path.write_bytes(content)


def test_what_only_looks_like_a_point_is_refused(tree):
    dry_run = snakemake(tree, "-n", "results/onset/runs/belt-none-01234567.nc", study=STUDY)
    assert dry_run.returncode != 0
    assert "belt-none-01234567: no point of onset.yaml" in dry_run.stdout + dry_run.stderr


def test_a_changed_study_works_out_its_rounds_anew(tree):
    stale = rounds(tree)
    text = (tree / STUDY).read_text().replace("range: [8, 40]", "range: [8, 44]")
    (tree / "wider.yaml").write_text(text)
    assert planned_jobs(tree, study="wider.yaml")["refine"] == 1
    assert len(planned_points(tree, study="wider.yaml")) == 4
    process = snakemake(tree, "results/onset/rounds/1.json", study="wider.yaml")
    assert process.returncode == 0, process.stderr
    assert not set(rounds(tree)[0]) & set(stale[0])


ASKING = "asking.yaml"


@pytest.fixture(scope="module")
def asked(tmp_path_factory) -> Path:
    """Return a folder with a study that was killed after its first round and run to its end."""
    tree = bare_folder(tmp_path_factory.mktemp("asking"), ASKING)
    folder = tree / "results" / "asking"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    options = {"cwd": tree, "env": environment, "start_new_session": True}
    words = command(tree, study=ASKING)
    process = subprocess.Popen(words, stderr=subprocess.DEVNULL, **options)
    wait_until((folder / "rounds" / "1.json").exists, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    first = {path.name: path.stat().st_mtime_ns for path in (folder / "runs").glob("belt-*.nc")}
    finished = snakemake(tree, study=ASKING)
    assert finished.returncode == 0, finished.stderr
    assert "surrogate speed: " in finished.stderr
    assert len(first) >= 6
    assert all((folder / "runs" / name).stat().st_mtime_ns == time for name, time in first.items())
    return tree


@pytest.mark.long
def test_rounds_have_added_points_and_ended(asked):
    folder = asked / "results" / "asking"
    study = load_study(asked / ASKING, asked / "results")
    files = sorted((folder / "rounds").glob("*.json"), key=lambda path: int(path.stem))
    rounds = [read_round(path) for path in files]
    assert rounds[0] and not rounds[-1] and all(rounds[:-1])
    known = points_of_rounds(study, folder)
    assert len(known) == 6 + sum(map(len, rounds))
    assert {path.stem for path in (folder / "runs").glob("belt-*.nc")} == set(known)


@pytest.mark.long
def test_its_answers_and_pictures_are_there(asked):
    folder = asked / "results" / "asking"
    results = sim.load(folder)
    surrogate = results.surrogate("velocity")
    assert surrogate.sample.sizes["point"] == results.dataset.sizes["point"]
    answer = surrogate(frequency=[30, 40], vibration_angle=45)
    assert answer["mean"].shape == (2,) and (answer["half_width"] > 0).all()
    names = {path.name for path in (folder / "figures").glob("*.png")}
    endings = ("frequency", "vibration_angle", "frequency-vibration_angle", "agreement")
    assert names == {f"speed-{ending}.png" for ending in endings}
    assert "speed-agreement" in (folder / "report.html").read_text()


@pytest.mark.long
def test_nothing_is_left_to_do_until_the_error_changes(asked):
    assert planned_jobs(asked, study=ASKING) == {}
    text = (asked / ASKING).read_text().replace("error: 0.0001", "error: 1")
    (asked / "coarse.yaml").write_text(text)
    assert planned_jobs(asked, study="coarse.yaml")["refine"] == 1
