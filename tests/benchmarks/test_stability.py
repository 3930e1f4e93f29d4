"""Amplification matrices are those of the engine's steps, and what parameters say rests on them."""

from math import factorial

import numpy as np
import pytest

from benchmarks.stability.amplification import SCHEMES, Corrector, growth, limit, matrix
from benchmarks.stability.beds import contacts, largest, lowest_frequency, rates, settled
from sim.engine.dynamics.disks import TERMS
from sim.parameters import BeltParameters
from sim.parameters.belt import GEAR_STABILITY
from tests.engine_motion.helpers import Oscillator, damped_oscillation, gear

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


RATED = [((50, 50), one) for one in READINGS] + [
    (pair, one) for pair in ((50, 1), (0, 50)) for one in READINGS[:2]
]


@pytest.mark.parametrize(("pair", "reading"), RATED)
def test_the_rates_that_parameters_know_are_those_of_a_real_bed(bed, pair, reading):
    p = BeltParameters.model_validate({"damping": pair[0], "shear_damping": pair[1]} | reading)
    assert p.damping_rate == pytest.approx(largest(rates(p, bed).damped), rel=0.12)


def test_the_frequency_that_parameters_know_is_that_of_a_real_bed(bed):
    p = BeltParameters()
    assert p.bed_frequency == pytest.approx(np.sqrt(largest(rates(p, bed).stiff)), rel=0.12)


@pytest.mark.parametrize("reading", READINGS[:2])
def test_the_published_step_is_stable_from_a_frequency_on_that_the_parameters_know(bed, reading):
    """14 Hz with the own mass, below 10 Hz with the reduced one (docs/physics.md)."""
    p = BeltParameters.model_validate(reading)
    found = lowest_frequency(Corrector(5, 1), rates(p, bed))
    assert found == pytest.approx(14.2 if p.damping_mass == "own" else 9.5, abs=0.6)
    assert BeltParameters(frequency=1.1 * found, **reading).is_stable
    assert not BeltParameters(frequency=0.9 * found, **reading).is_stable
