"""Benchmarks of large studies, of processor time and of the column measure what they say."""

import subprocess
import time
from math import pi, sqrt

import pytest
import xarray as xr
import yaml

from benchmarks.column import GRAVITY, Column, transport
from benchmarks.scale import copies, grid, real
from benchmarks.scale.cost import cost
from benchmarks.share import SWEEPS
from benchmarks.share import study as share_study
from sim.dataset.build import build
from sim.parameters import parse_point
from sim.report.status import survey
from sim.study.load import load_study
from tests.made.processes import is_alive
from tests.made.runs import write_run

#: A command that tells which process it has started, and waits for it.
WAITING = """\
import pathlib, subprocess
process = subprocess.Popen(["sleep", "1000"])
pathlib.Path("part").write_text(str(process.pid))
pathlib.Path("part").rename("child")
process.wait()
"""


def test_copies_of_a_run_make_a_study(tmp_path, monkeypatch):
    monkeypatch.setattr(grid, "ROW", 3)
    template = write_run(tmp_path, parse_point({"system": "belt", "replicates": 2}, "test"), 0.25)
    path = grid.write_study(tmp_path, 2, {"replicates": 2}, added=1)
    copies.fill(tmp_path, path, template, 1)
    results = tmp_path / "results"
    study = load_study(path, results)
    assert survey(study, results).counts["done"] == len(study.points) == 7
    with xr.open_dataset(build(path, results)) as dataset:
        assert (dataset["velocity"] == 0.25).all()
        assert set(dataset["frequency"].values) == {20, 21}


@pytest.mark.long
def test_a_study_comes_from_its_first_run_to_its_report(tmp_path, monkeypatch, capsys):
    """It is killed once half of its one run is there, rounded down."""
    monkeypatch.setattr(grid, "ROW", 1)
    monkeypatch.setattr(real, "ROW", 1)
    monkeypatch.setattr(real, "PLOTS", real.PLOTS[1:])
    real.measure(tmp_path, rows=1, replicates=1, processes=1)
    said = capsys.readouterr().out
    for what in ("the first 0 runs, then killed", "dataset alone", "`status`"):
        assert f"\n| {what} | " in said
    assert "\n0 of 0 runs from before the kill are kept\n" in said
    assert (tmp_path / "results" / "scale" / "report.html").exists()


def test_a_command_costs_time_and_memory(tmp_path):
    assert min(cost(tmp_path, "sim", "--version")) >= 0
    with pytest.raises(subprocess.CalledProcessError):
        cost(tmp_path, "sim", "dataset", "none.yaml")


def test_a_command_can_be_killed_with_all_that_it_has_started(tmp_path):
    (tmp_path / "waiting.py").write_text(WAITING)
    child = tmp_path / "child"
    found = cost(tmp_path, "waiting", until=child.exists)
    assert 0 < found.own <= found.memory
    assert any(not is_alive(int(child.read_text())) or time.sleep(0.1) for _ in range(600))


def test_a_command_that_ends_before_it_is_to_be_killed_has_failed(tmp_path):
    with pytest.raises(subprocess.CalledProcessError):
        cost(tmp_path, "sim", "--version", until=lambda: False)


@pytest.mark.parametrize("system", SWEEPS)
def test_the_studies_can_be_run(system, tmp_path):
    path = tmp_path / "share.yaml"
    path.write_text(yaml.safe_dump(share_study(system, 4)))
    found = load_study(path, tmp_path)
    assert len(found.points) == 4
    assert {point.parameters.system for point in found.points.values()} == {system}


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 1.5])
def test_transport_begins_where_the_belt_reaches_the_acceleration_of_gravity(amplitude):
    onset = sqrt(GRAVITY / amplitude) / (2 * pi)
    assert abs(transport(0.93 * onset, amplitude)) < 1e-3
    assert 0.1 < transport(1.12 * onset, amplitude) < 1


def test_a_single_bead_at_rest_on_the_belt_is_not_transported():
    assert abs(transport(12, column=Column(beads=1))) < 1e-6


def test_without_shear_friction_nothing_is_transported():
    assert transport(40, column=Column(shear_damping=0.0)) == 0


def test_flat_vibrations_carry_the_same_share_of_the_belts_velocity():
    """The vertical motion does not know of the horizontal one, which is linear in it."""
    assert transport(20, angle=30) == pytest.approx(transport(20, angle=60))
