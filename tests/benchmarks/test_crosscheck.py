"""The comparison with LAMMPS, as far as it goes without LAMMPS."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.special import beta

from benchmarks.crosscheck import runs
from benchmarks.crosscheck.contacts import parameters
from benchmarks.crosscheck.engines import Record, run, synchronised
from benchmarks.crosscheck.flows import BLOCKS, FLOWS, Flow
from benchmarks.crosscheck.hertz import LAW, OTHERS, POLYNOMIAL
from benchmarks.crosscheck.impact import LAMMPS, TALUS, damping_constant, impact, turned
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
from sim.laws.hertz import effective_modulus
from tests.engine.reference.hertz_impact import Friction, rebound

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


#: Radii in diameters.
PARTNERS = {"pair": (0.5, 0.5), "unlike": (0.7, 0.4), "plane": (0.5,)}


def met(partner: str, velocity, steps: int, convention=TALUS, **values):
    """Return radii and masses, and velocity and spins after an impact that is about to begin."""
    p = parameters(1, gravity=1e-6, **values)
    radii = np.array(PARTNERS[partner]) * p.diameter
    masses = p.mass * (2 * radii / p.diameter) ** 3
    share = masses[1] / masses.sum() if len(radii) == 2 else 1.0
    start = share * np.array([0, 0, radii.sum()])
    return radii, masses, *impact(p, radii, start, np.array(velocity), steps, convention)


@pytest.mark.parametrize("law", ["spring_dashpot", "hertz"])
@pytest.mark.parametrize("partner", ["pair", "plane"])
@pytest.mark.parametrize("restitution", [0.7, 0.95])
def test_plain_impact_has_the_restitution_asked_for(partner, restitution, law):
    values = {"restitution": restitution, "law": law, "steps_per_collision": 1000}
    _, _, velocity, spins = met(partner, [0, 0, -0.01], 3000, **values)
    assert velocity[2] == pytest.approx(restitution * 0.01, rel=1e-3)
    np.testing.assert_array_equal(spins, 0.0)


@pytest.mark.parametrize("partner", ["pair", "plane"])
def test_plain_impact_in_gross_slip_gives_the_friction_impulse_to_slide_and_spin(partner):
    start = np.array([0.008, 0.0, -0.001])
    radii, _, velocity, spins = met(partner, start, 600, friction=0.2, steps_per_collision=400)
    impulse = start - velocity
    # A pair turns while it is in contact, and the drag that pulls at the end of it rubs, too.
    assert impulse[0] == pytest.approx(-0.2 * impulse[2], rel=0.03)
    np.testing.assert_allclose(radii * spins[:, 1], 2.5 * impulse[0], rtol=0.03)


@pytest.mark.parametrize("partner", PARTNERS)
def test_plain_impact_with_hertz_is_that_of_the_differential_equations(partner):
    """So slow that a pair hardly turns, once from sticking and once from sliding throughout."""
    values = {"steps_per_collision": 200, "friction": 0.3, "restitution": 0.9}
    for slope in (0.5, 3.0):
        start = np.array([slope, 0, -1]) * 1e-5
        radii, masses, velocity, spins = met(partner, start, 4000, **LAW, **values)
        parting, across, rims, _ = rebound(Friction(LAW["tangential_ratio"], 0.3, 0.9), slope)
        np.testing.assert_allclose(velocity[[2, 0]], np.array([parting, across]) * 1e-5, rtol=2e-3)
        shares = rims / masses / (1 / masses).sum()
        # The frame of the reference is that of the partner, of which the sphere has a share.
        whole = masses[0] * (1 / masses).sum()
        np.testing.assert_allclose(radii * spins[:, 1], whole * shares * 1e-5, rtol=5e-3)


@pytest.mark.parametrize("partner", ["pair", "unlike"])
def test_lammps_takes_half_the_overlap_from_the_arms_of_pairs(partner):
    """Spins are smaller by the overlap's mean, weighted with the force: B(7/5, 1/2)/2 of it."""
    start, spins = np.array([0.02, 0.0, -0.02]), {}
    for convention in (TALUS, LAMMPS["hertz"]):
        values = {"friction": 0.1, "restitution": 1, **LAW}
        radii, masses, _, spins[convention] = met(partner, start, 200, convention, **values)
    p = parameters(1, **LAW)
    mass, radius = (1 / (1 / both).sum() for both in (masses, radii))
    speed = 0.02 * masses[0] / mass
    deepest = (15 * mass * speed**2 / (16 * radius**0.5 * effective_modulus(p))) ** 0.4
    smaller = 1 - spins[LAMMPS["hertz"]][:, 1] / spins[TALUS][:, 1]
    np.testing.assert_allclose(smaller, beta(1.4, 0.5) / 2 * deepest / 2 / radii, rtol=0.01)


def test_a_turned_force_keeps_its_size_or_its_part_within_the_plane():
    force, normal = np.array([3.0, 0.0, 4.0]), np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned(force, normal, True), [5.0, 0.0, 0.0])
    np.testing.assert_allclose(turned(force, normal, False), [3.0, 0.0, 0.0])


def test_plain_and_lammps_damping_are_the_same():
    p = parameters(1)
    for mass in (p.mass, 0.5 * p.mass):
        rate = damping_rate(p.stiffness, mass, p.restitution)
        constant = damping_constant(p.restitution, p.stiffness, mass)
        assert constant == pytest.approx(mass * rate, rel=1e-12)


def commands(p) -> list[str]:
    snapshot = {"position": np.ones((1, 3)) * p.diameter, "particle_velocity": np.zeros((1, 3))}
    return chute_request(p, snapshot, Settings())["after"]


def test_lammps_gets_the_tangential_spring_of_the_law_and_no_tangential_damping():
    p = parameters(1, tangential_ratio=0.5, friction=0.4, friction_plane=0.3)
    lines = commands(p)
    pair = next(line.split() for line in lines if line.startswith("pair_style"))
    plane = next(line.split() for line in lines if "wall/gran" in line)
    assert [float(word) for word in pair[2:4]] == [p.stiffness, 0.5 * p.stiffness]
    assert [float(word) for word in pair[5:7]] == [0.0, 0.4]
    spring = plane.index("linear_history")
    assert [float(word) for word in plane[spring + 1 : spring + 4]] == [0.5 * p.stiffness, 0.0, 0.3]
    assert float(pair[4]) == pytest.approx(2**0.5 * float(plane[7]))


def test_lammps_gets_the_material_of_hertz_and_mindlin():
    p = parameters(1, **LAW, friction=0.4, friction_plane=0.3, restitution=0.8)
    pair = next(line.split() for line in commands(p) if line.startswith("pair_coeff"))
    plane = next(line.split() for line in commands(p) if "wall/gran" in line)
    for words, friction in ((pair[3:], 0.4), (plane[5:], 0.3)):
        assert words[0] == "hertz/material" and words[4:6] == ["damping", "coeff_restitution"]
        young, restitution, poisson = map(float, words[1:4])
        assert restitution == 0.8 and poisson == pytest.approx(0.3)
        assert young / (2 * (1 - poisson**2)) == pytest.approx(effective_modulus(p))
        assert words[6:10] == ["tangential", "mindlin/force", "NULL", "0"]
        assert float(words[10]) == friction


def test_other_models_are_other_commands():
    p = parameters(1, **LAW)
    ours = "\n".join(commands(p))
    others = {edit(p, ours) for edit in (POLYNOMIAL, *(edit for _, edit in OTHERS.values()))}
    assert ours not in others and len(others) == 1 + len(OTHERS)


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
