"""Amplification matrices are those of the engine's steps, and what parameters say rests on them."""

import subprocess
import time
from math import factorial, pi, sqrt

import numpy as np
import pytest
import xarray as xr
import yaml

from benchmarks.column import GRAVITY, Column, transport
from benchmarks.scale import copies, grid, real
from benchmarks.scale.cost import cost
from benchmarks.share import SWEEPS
from benchmarks.share import study as share_study
from benchmarks.stability.amplification import SCHEMES, Corrector, growth, limit, matrix
from benchmarks.stability.beds import contacts, largest, lowest_frequency, rates, settled
from sim.dataset.build import build
from sim.engine.dynamics.disks import TERMS
from sim.parameters import BeltParameters, parse_point
from sim.parameters.belt import GEAR_STABILITY
from sim.report.status import survey
from sim.study.load import load_study
from tests.engine_motion.helpers import Oscillator, damped_oscillation, gear
from tests.made.processes import is_alive
from tests.made.runs import write_run

READINGS = ({}, {"damping_mass": "reduced"}, {"damping_mass": "reduced", "ghost_mass": "mean"})


@pytest.fixture(scope="module")
def bed():
    return settled(BeltParameters())


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_matrix_is_what_the_engine_does_in_a_step(scheme):
    damping, frequency, step = 30.0, 50.0, 0.01
    start = np.random.default_rng(3).normal(size=scheme.terms)
    taylor = np.zeros((TERMS, 2, 1))
    taylor[: scheme.terms] = start[:, None, None]
    oscillator = Oscillator(frequency**2, damping)
    damped_oscillation(gear(scheme.order)(step), taylor, oscillator, 3, scheme.corrections)
    one = matrix(scheme, damping * step, frequency * step)
    assert taylor[: scheme.terms, 0, 0] == pytest.approx(one @ one @ one @ start, rel=1e-11)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_small_steps_follow_the_oscillator(scheme):
    """The eigenvalues of its motion are those of exact steps, to the order of the corrector."""
    damping, frequency = 0.02, 0.05
    root = complex(-damping / 2, np.sqrt(frequency**2 - damping**2 / 4))
    found = np.linalg.eigvals(matrix(scheme, damping, frequency))
    assert np.abs(found - np.exp(root)).min() < 10 * 0.05 ** (scheme.order + 1) / factorial(3)
    assert growth(scheme, damping, frequency) == pytest.approx(np.exp(root.real), abs=1e-5)


def test_pure_damping_is_borne_up_to_the_limits_that_are_told():
    limits = {scheme: limit(scheme) for scheme in SCHEMES}
    assert limits[Corrector(5, 1)] == pytest.approx(0.163, abs=1e-3)
    assert limits[Corrector(4, 1)] == pytest.approx(0.300, abs=1e-3)
    assert limits[Corrector(3, 1)] == pytest.approx(0.545, abs=1e-3)
    assert limits[Corrector(5, 2)] == pytest.approx(0.947, abs=1e-3)
    for scheme, found in limits.items():
        assert growth(scheme, 0.99 * found, 0.0) <= 1 + 1e-9 < growth(scheme, 1.01 * found, 0.0)


@pytest.mark.parametrize("frequency", [0.0, 0.3, 0.6, 0.7])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_stability_that_parameters_know_is_that_of_the_matrix(scheme, frequency):
    most, bend = GEAR_STABILITY[scheme]
    expected = limit(scheme, frequency)
    known = most * (1 - bend * frequency**2)
    assert known == pytest.approx(expected, rel=0.02, abs=0.002)


def test_contacts_of_a_settled_bed_carry_its_weight(bed):
    """Springs alone balance gravity, and each contact is one of overlapping beads."""
    p, found = BeltParameters(), contacts(BeltParameters(), bed)
    pair = found.first != found.second
    assert 1.7 < pair.sum() / len(bed.radius) < 2.2
    assert found.normal[~pair].tolist() == [[0.0, -1.0]] * (~pair).sum()
    sunk = bed.radius[found.first[~pair]] - bed.position[found.first[~pair], 1]
    stiffness = p.stiffness * p.gravity * p.mass / p.diameter
    assert stiffness * sunk.sum() == pytest.approx(bed.mass.sum() * p.gravity, rel=0.05)


@pytest.mark.parametrize("reading", READINGS)
def test_rates_leave_rigid_motion_alone_and_the_law_damps_by_its_masses(bed, reading):
    p = BeltParameters.model_validate(reading)
    both, found = rates(p, bed), contacts(p, bed)
    free = np.ones(len(bed.radius), bool)
    free[found.first[found.first == found.second]] = False
    along = np.tile([1.0, 0.5], len(bed.radius))
    for each in both:
        moved = (each @ along).reshape(-1, 2)
        scale = np.abs(each).max()
        assert np.abs(moved[free]).max() < 1e-12 * scale < np.abs(moved[~free]).max()
    # Reciprocal forces make the damping matrix M times it symmetric.
    if p.damping_mass == "reduced":
        mass = np.repeat(bed.mass, 2)
        symmetric = both.damped.multiply(mass[:, None]).tocsr()
        assert abs(symmetric - symmetric.T).max() < 1e-12 * abs(symmetric).max()


@pytest.mark.parametrize(
    ("damping", "shear_damping", "reading"),
    [(50, 50, READINGS[0]), (50, 50, READINGS[2]), (50, 1, READINGS[1]), (0, 50, READINGS[0])],
)
def test_rates_that_parameters_know_are_those_of_a_real_bed(bed, damping, shear_damping, reading):
    p = BeltParameters(damping=damping, shear_damping=shear_damping, **reading)
    found = rates(p, bed)
    assert p.damping_rate == pytest.approx(largest(found.damped), rel=0.12)
    if (damping, shear_damping, reading) == (50, 50, READINGS[0]):
        assert p.bed_frequency == pytest.approx(np.sqrt(largest(found.stiff)), rel=0.12)


@pytest.mark.parametrize("reading", READINGS[:2])
def test_the_published_step_is_stable_from_a_frequency_on_that_the_parameters_know(bed, reading):
    """14 Hz with the own mass, below 10 Hz with the reduced one (docs/physics.md)."""
    p = BeltParameters.model_validate(reading)
    found = lowest_frequency(Corrector(5, 1), rates(p, bed))
    assert found == pytest.approx(14.2 if p.damping_mass == "own" else 9.5, abs=0.6)
    assert BeltParameters(frequency=1.1 * found, **reading).is_stable
    assert not BeltParameters(frequency=0.9 * found, **reading).is_stable


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


def test_a_command_costs_time_and_memory_unless_it_fails_or_ends_too_early(
    tmp_path,
):
    (tmp_path / "nothing.py").touch()
    assert min(cost(tmp_path, "nothing")) >= 0
    for command, until in (("missing", None), ("nothing", lambda: False)):
        with pytest.raises(subprocess.CalledProcessError):
            cost(tmp_path, command, until=until)


def test_a_command_can_be_killed_with_all_that_it_has_started(tmp_path):
    (tmp_path / "waiting.py").write_text(WAITING)
    child = tmp_path / "child"
    found = cost(tmp_path, "waiting", until=child.exists)
    assert 0 < found.own <= found.memory
    assert any(not is_alive(int(child.read_text())) or time.sleep(0.1) for _ in range(600))


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
    assert abs(transport(12.0, column=Column(beads=1))) < 1e-6


def test_without_shear_friction_nothing_is_transported():
    assert transport(40.0, column=Column(shear_damping=0.0)) == 0


def test_flat_vibrations_carry_the_same_share_of_the_belts_velocity():
    """The vertical motion does not know of the horizontal one, which is linear in it."""
    assert transport(20.0, angle=30) == pytest.approx(transport(20.0, angle=60))
