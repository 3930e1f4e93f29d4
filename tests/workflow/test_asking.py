"""A surrogate from end to end: a round of further points, a kill in between, and its answers."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

import sim
from sim.dataset.rounds import points_of_rounds, read_round
from sim.study.load import load_study
from tests.made.processes import ROOT, wait_until
from tests.made.project import bare_folder, command, planned_jobs, snakemake

STUDY = "asking.yaml"

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder with a study that was killed after its first round and run to its end."""
    tree = bare_folder(tmp_path_factory.mktemp("asking"), STUDY)
    folder = tree / "results" / "asking"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    options = {"cwd": tree, "env": environment, "start_new_session": True}
    words = command(tree, study=STUDY)
    process = subprocess.Popen(words, stderr=subprocess.DEVNULL, **options)
    wait_until((folder / "rounds" / "1.json").exists, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    first = {path.name: path.stat().st_mtime_ns for path in (folder / "runs").glob("belt-*.nc")}
    finished = snakemake(tree, study=STUDY)
    assert finished.returncode == 0, finished.stderr
    assert "surrogate speed: " in finished.stderr
    assert len(first) >= 6
    assert all((folder / "runs" / name).stat().st_mtime_ns == time for name, time in first.items())
    return tree


def test_rounds_have_added_points_and_ended(tree):
    folder = tree / "results" / "asking"
    study = load_study(tree / STUDY, tree / "results")
    files = sorted((folder / "rounds").glob("*.json"), key=lambda path: int(path.stem))
    rounds = [read_round(path) for path in files]
    assert rounds[0] and not rounds[-1] and all(rounds[:-1])
    known = points_of_rounds(study, folder)
    assert len(known) == 6 + sum(map(len, rounds))
    assert {path.stem for path in (folder / "runs").glob("belt-*.nc")} == set(known)


def test_its_answers_and_pictures_are_there(tree):
    folder = tree / "results" / "asking"
    results = sim.load(folder)
    surrogate = results.surrogate("velocity")
    assert surrogate.sample.sizes["point"] == results.dataset.sizes["point"]
    answer = surrogate(frequency=[30, 40], vibration_angle=45)
    assert answer["mean"].shape == (2,) and (answer["half_width"] > 0).all()
    names = {path.name for path in (folder / "figures").glob("*.png")}
    endings = ("frequency", "vibration_angle", "frequency-vibration_angle", "agreement")
    assert names == {f"speed-{ending}.png" for ending in endings}
    assert "speed-agreement" in (folder / "report.html").read_text()


def test_nothing_is_left_to_do_until_the_error_changes(tree):
    assert planned_jobs(tree, study=STUDY) == {}
    text = (tree / STUDY).read_text().replace("error: 0.0001", "error: 1")
    (tree / "coarse.yaml").write_text(text)
    assert planned_jobs(tree, study="coarse.yaml")["refine"] == 1
