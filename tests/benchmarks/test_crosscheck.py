"""The comparison with LAMMPS, as far as it goes without LAMMPS."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from benchmarks.crosscheck import runs
from benchmarks.crosscheck.contacts import parameters
from benchmarks.crosscheck.engines import Record, run, synchronised
from benchmarks.crosscheck.flows import BLOCKS, FLOWS, Flow
from benchmarks.crosscheck.impact import damping_constant, impact, turned
from benchmarks.crosscheck.results import Comparison, Measured, mean_and_interval, measured, table
from benchmarks.crosscheck.statistics import (
    Estimate,
    agree,
    compared,
    estimate,
    pooled,
    ratio,
)
from benchmarks.peers.chute_input import chute_request, damping_rate
from benchmarks.peers.settings import Settings
from sim.base.statistics import student_half_width

TINY = Flow("tiny", {"depth": 1, "cell": 4, "stiffness": 117}, 1, 3, 2)


def test_half_width_is_students_by_hand():
    # t(0.975, 2) = 4.302653, and the standard deviation of 1, 2, 3 is 1.
    assert student_half_width(np.array([1.0, 2.0, 3.0])) == pytest.approx(4.302653 / 3**0.5)


def test_estimate_takes_the_wider_interval():
    rng = np.random.default_rng(1)
    noise = rng.normal(0, 1, (4, 6))
    alike = noise - noise.mean(axis=1, keepdims=True)
    assert estimate(alike).half_width == pytest.approx(student_half_width(alike.ravel()))
    apart = alike + np.array([[0.0], [10.0], [20.0], [30.0]])
    assert estimate(apart).half_width == pytest.approx(student_half_width(apart.mean(axis=1)))
    assert estimate(apart).mean == pytest.approx(15.0)


@pytest.mark.parametrize("replicates", [1, 2])
def test_few_replicates_have_the_interval_of_their_blocks(replicates):
    blocks = np.arange(6.0) + 10 * np.arange(replicates)[:, None]
    assert estimate(blocks).half_width == pytest.approx(student_half_width(blocks.ravel()))


def test_profiles_are_estimated_slice_by_slice():
    blocks = np.random.default_rng(2).normal(0, 1, (3, 6, 5))
    whole = estimate(blocks)
    for s in range(5):
        assert whole.half_width[s] == pytest.approx(estimate(blocks[:, :, s]).half_width)


def test_ratio_adds_relative_intervals_in_quadrature():
    found = ratio(Estimate(6.0, 0.18), Estimate(3.0, 0.12))
    assert found.mean == pytest.approx(2.0)
    assert found.half_width == pytest.approx(2.0 * 0.05)


def test_pooled_estimates_weigh_by_their_intervals():
    found = pooled([Estimate(1.0, 0.1), Estimate(1.3, 0.2)])
    assert found.mean == pytest.approx((1.0 * 4 + 1.3) / 5)
    assert found.half_width == pytest.approx(0.2 / 5**0.5)


@pytest.mark.parametrize(
    ("theirs", "width", "expected"), [(10.29, 0.0, True), (10.5, 0.1, False), (10.5, 0.4, True)]
)
def test_agreement_is_three_per_cent_or_the_combined_interval(theirs, width, expected):
    assert agree(Estimate(10.0, width), Estimate(theirs, width), 10.0) == expected


def test_slices_with_little_mass_are_not_compared():
    packing = np.array([0.5, 0.4, 0.0089, 0.0])
    np.testing.assert_array_equal(compared(packing), [True, True, False, False])


@pytest.mark.parametrize("partner", ["pair", "plane"])
@pytest.mark.parametrize("restitution", [0.7, 0.95])
def test_plain_impact_has_the_restitution_asked_for(partner, restitution):
    p = parameters(1, restitution=restitution, steps_per_collision=1000, gravity=1e-6)
    down = np.array([0.0, 0.0, -0.01])
    velocity, spin = impact(p, partner, np.array([0, 0, 0.5 * p.diameter]), down, 1500, True)
    assert velocity[2] == pytest.approx(-restitution * down[2], rel=1e-3)
    np.testing.assert_array_equal(spin, 0.0)


@pytest.mark.parametrize("partner", ["pair", "plane"])
def test_plain_impact_in_gross_slip_gives_the_friction_impulse_to_slide_and_spin(partner):
    p = parameters(1, friction=0.2, steps_per_collision=400, gravity=1e-6)
    start = np.array([0.008, 0.0, -0.001])
    velocity, spin = impact(p, partner, np.array([0, 0, 0.5 * p.diameter]), start, 600, True)
    impulse = start - velocity
    # A pair turns while it is in contact, and the drag that pulls at the end of it rubs, too.
    assert impulse[0] == pytest.approx(-p.friction * impulse[2], rel=0.03)
    assert 0.5 * p.diameter * spin[1] == pytest.approx(2.5 * impulse[0], rel=0.03)


def test_a_turned_force_keeps_its_size_or_its_part_within_the_plane():
    force, normal = np.array([3.0, 0.0, 4.0]), np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned(force, normal, True), [5.0, 0.0, 0.0])
    np.testing.assert_allclose(turned(force, normal, False), [3.0, 0.0, 0.0])


def test_plain_and_lammps_damping_are_the_same():
    p = parameters(1)
    for mass in (p.mass, 0.5 * p.mass):
        rate = damping_rate(p.stiffness, mass, p.restitution)
        assert damping_constant(p, mass) == pytest.approx(mass * rate, rel=1e-12)


def test_lammps_gets_the_tangential_spring_of_the_law_and_no_tangential_damping():
    p = parameters(1, tangential_ratio=0.5, friction=0.4, friction_plane=0.3)
    snapshot = {"position": np.ones((1, 3)) * p.diameter, "particle_velocity": np.zeros((1, 3))}
    lines = chute_request(p, snapshot, Settings())["after"]
    pair = next(line.split() for line in lines if line.startswith("pair_style"))
    plane = next(line.split() for line in lines if "wall/gran" in line)
    assert [float(word) for word in pair[2:4]] == [p.stiffness, 0.5 * p.stiffness]
    assert [float(word) for word in pair[5:7]] == [0.0, 0.4]
    spring = plane.index("linear_history")
    assert [float(word) for word in plane[spring + 1 : spring + 4]] == [0.5 * p.stiffness, 0.0, 0.3]
    assert float(pair[4]) == pytest.approx(2**0.5 * float(plane[7]))


def test_synchronised_velocities_have_fallen_for_half_a_step():
    p = parameters(1, angle=30)
    before = {"particle_velocity": np.zeros((2, 3))}
    kick = 0.5 * p.gravity * p.time_step * np.array([0.5, 0.0, -(0.75**0.5)])
    after = synchronised(p, before)["particle_velocity"]
    np.testing.assert_allclose(after, [kick, kick], rtol=1e-12, atol=1e-20)


def test_flows_are_valid_and_told_apart():
    assert len({flow.name for flow in FLOWS}) == len(FLOWS)
    paths = {runs.record_path(*task) for task in runs.tasks(FLOWS)}
    assert len(paths) == len(runs.tasks(FLOWS)) == 2 * sum(flow.replicates for flow in FLOWS)
    quick = [flow.quick() for flow in FLOWS]
    assert paths.isdisjoint(runs.record_path(*task) for task in runs.tasks(quick))


def test_all_flows_get_a_replicate_before_any_gets_a_second():
    replicates = [replicate for _, _, replicate in runs.tasks(FLOWS)]
    assert replicates == sorted(replicates)


def test_a_record_has_all_the_mass_and_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "CACHE", tmp_path)
    record = run("Talus", TINY, 0)
    p = TINY.parameters()
    # What spheres have pressed into the plane lies in no slice.
    np.testing.assert_allclose(record.packing.sum(axis=1) * p.slice_height, pi / 6, rtol=1e-4)
    assert record.velocity.shape == record.contacts.shape
    moved = record.flux.sum(axis=1) / record.packing.sum(axis=1)
    assert moved == pytest.approx(record.velocity.reshape(BLOCKS, -1).mean(axis=1), rel=0.02)
    for replicate in range(TINY.replicates):
        runs.compute(("Talus", TINY, replicate))
    kept = runs.load("Talus", TINY)
    np.testing.assert_array_equal(kept[0].velocity, record.velocity)
    assert not np.array_equal(kept[1].velocity, record.velocity)


def records(velocity: float, contacts: float) -> list[Record]:
    """Return two replicates of a flow in two slices with block means that hardly vary."""
    rng = np.random.default_rng(3)
    jitter = 1.0 + 1e-4 * rng.normal(0, 1, (2, BLOCKS * 2))
    packing = np.full((BLOCKS, 3), [0.5, 0.4, 0.0])
    flux = velocity * packing * [0.9, 1.1, 1.0]
    return [Record(np.ones(4), velocity * wave, contacts * wave, packing, flux) for wave in jitter]


def compare(velocity: float, contacts: float) -> Comparison:
    ours, theirs = measured(records(velocity, contacts)), measured(records(8.0, 0.4))
    return Comparison(FLOWS[0], ours, theirs, compared(theirs.packing.mean))


def test_equal_records_agree():
    c = compare(8.1, 0.405)
    assert c.agrees_throughout
    assert c.share("speed") == c.share("packing") == 1.0
    row = table([c]).splitlines()[-2]
    assert "8.10 ± 0.00 | 8.00 ± 0.00 | 1.01" in row
    assert "| 100 / 100 % | 1.2 / 0.0 % |" in row


@pytest.mark.parametrize(("velocity", "contacts"), [(8.6, 0.4), (8.0, 0.45)])
def test_a_difference_beyond_three_per_cent_shows(velocity, contacts):
    c = compare(velocity, contacts)
    assert not c.agrees_throughout
    assert c.agrees("contacts") == (contacts == 0.4)
    assert c.agrees("velocity") == (velocity == 8.0)
    assert c.share("speed") == (1.0 if velocity == 8.0 else 0.0)
    assert c.gap("speed") == pytest.approx(velocity / 8.0 - 1.0, abs=1e-9)


def test_a_drift_is_the_second_half_less_the_first():
    rising = np.linspace(0.0, 1.0, BLOCKS * 10)
    fixed = records(1.0, 1.0)[0]
    found = measured([fixed._replace(velocity=rising), fixed._replace(velocity=rising)])
    assert isinstance(found, Measured)
    assert found.drift.mean == pytest.approx(0.5, rel=0.05)


def test_values_are_shown_with_their_interval():
    assert mean_and_interval(Estimate(7.0549, 0.118), 2) == "7.05 ± 0.12"


def test_quick_flows_average_less_of_the_same_flow():
    flow = FLOWS[0]
    quick = flow.quick()
    assert replace(quick, average=flow.average, replicates=flow.replicates) == flow
    assert quick.average < flow.average
