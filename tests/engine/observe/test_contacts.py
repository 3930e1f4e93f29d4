"""Stress, spin and slip of chute flows: against the momentum that flows gain, and the reference."""

import numpy as np
import pytest

from sim.engine.observe.contacts import (
    XZ,
    ZZ,
    ContactSums,
    Sampling,
    add_contacts,
    no_slip,
    no_stress,
)
from sim.engine.observe.force_balance import inertial_number, shear_rate
from sim.engine.observe.profiles import ratio
from sim.engine.systems import build, leap_frog
from sim.engine.systems.leap_frog import FlowContacts
from sim.parameters import parse_point
from tests.engine_motion.helpers import MASS, RADIUS
from tests.engine_motion.motion import SphereMotion
from tests.engine_motion.points import chute_point, sums_of

SPEED = 0.05

SMALL = {"depth": 2, "cell": 5, "stress_profiles": True}
READINGS = [
    {},
    # Laws whose sums take long to compile.
    pytest.param({"tangential_exponent": 1, "overlap_memory": "reset"}, marks=pytest.mark.long),
    pytest.param({"law": "spring_dashpot"}, marks=pytest.mark.long),
    {"threads": 2, "diameter_spread": 0.3},
    {"bumps": 0.8, "bump_coverage": 0.4},
    {"slice_height": 0.01, "cell": 3},
]


def moving(samples=30, **values):
    """A flow some samples after its start."""
    system = build(chute_point(**(SMALL | values)), 0)
    for _ in range(samples):
        system.advance()
    return system


def momentum_above(system) -> np.ndarray:
    """Momentum (H, 2) along x and z above the middle of each slice, before the last drift."""
    spheres, slices = system.spheres, system.slices
    edges = np.arange(slices.slices) * slices.slice_height
    before = spheres.position[2] - spheres.velocity[2] * system.time_step
    share = np.clip((before - edges[:, None]) / slices.slice_height, 0.0, 1.0)
    return share @ (spheres.mass * spheres.velocity[[0, 2]]).T


def gains(system, stress) -> np.ndarray:
    """What the stresses of one sample say of the momentum (H, 2) gained in a step."""
    along, _, across = system.gravity
    height = system.slices.slice_height
    x = (stress.flux[:, XZ] - stress.branches[:, XZ]) / height + along * stress.above
    z = (stress.flux[:, ZZ] + stress.branches[:, ZZ]) / height + across * stress.above
    return np.stack([x, z], axis=1) * system.time_step


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_stress_and_weight_are_what_the_momentum_above_gains(reading):
    """In each slice above bumps and at each sample, to rounding; losses are those of the step."""
    system, total = moving(**reading), 0.0
    free = system.profile_height > system.parameters.bumps * system.parameters.diameter
    for _ in range(5):
        *_, stress, slip = sums_of(system)
        expected, before = gains(system, stress), momentum_above(system)
        system._run(1)
        found = momentum_above(system) - before
        scale = (system.spheres.mass * np.abs(system.spheres.velocity)).sum()
        assert found[free] == pytest.approx(expected[free], abs=1e-12 * scale)
        weight = system.mass * system.parameters.gravity * system.time_step
        assert np.abs(expected).max() > 0.01 * weight > 1e-9 * scale
        losses = system.flow.sums[[leap_frog.NORMAL_LOSS, leap_frog.FRICTION_WORK]]
        told = np.array([slip.lost.sum(), slip.rubbed.sum()]) * system.time_step
        assert told == pytest.approx(losses, rel=1e-9, abs=1e-20)
        total += losses.sum()
    assert total > 1e-12


def test_kinetic_stress_is_that_about_the_mean_profile():
    """Free spheres: a mean motion, the same in all slices, and what differs from it."""
    rng, number = np.random.default_rng(2), 4000
    position = 60 * RADIUS * rng.uniform(0.2, 0.9, (number, 3))
    spread = SPEED * np.array([[1.0, 0.0, -0.4], [0.0, 0.7, 0.0], [0.0, 0.0, 0.5]])
    velocity = rng.normal(size=(number, 3)) @ spread + np.array([3.0, 0.0, 0.0])
    motion = SphereMotion(position, velocity, radius=1e-3 * RADIUS, box=(0.04, 0.04))
    stress, slip = no_stress(3), no_slip(3)
    contacts = FlowContacts(motion.laws, motion.pairs, motion.plane, motion.memory, motion.bond)
    add_contacts(
        ContactSums(stress, slip),
        motion.spheres,
        contacts,
        Sampling(0, 20 * RADIUS, 1e-9, (0.0, 0.0)),
    )
    found = stress.kinetic(1.0) / stress.mass[:, None]
    covariance = spread.T @ spread
    expected = [*np.diag(covariance), -covariance[0, 2]]
    assert found[1] == pytest.approx(expected, abs=0.1 * SPEED**2)
    assert stress.mass.sum() == pytest.approx(number * MASS)
    assert not stress.branches.any() and not slip.contacts.any()


def test_a_flow_that_shears_evenly_has_the_inertial_number_of_its_definition():
    height, rate, sigma = np.arange(40) * 1e-4 + 5e-5, 30.0, 1e-3
    velocity, normal = 0.02 + rate * height, np.full(40, 50.0)
    normal[-1] = 0.0
    found = inertial_number(shear_rate(velocity, 1e-4, sigma), normal, sigma, 2500.0)
    assert found[5:-5] == pytest.approx(rate * sigma * (2500.0 / 50.0) ** 0.5)
    assert np.isnan(found[[0, 4, -5, -1]]).all()
    assert np.isnan(shear_rate(velocity[:8], 1e-4, sigma)).all()
    found = ratio(np.full(40, 20.0), normal)
    assert found[0] == pytest.approx(0.4) and np.isnan(found[-1])


POINTS = {
    "chute": {"system": "chute", "depth": 3, "cell": 5, "bumps": 0.3, "bump_coverage": 0.1},
    "belt": {"system": "belt", "beads": 60, "width": 8, "obstacle": 2, "belt_ghost": "centred"},
}


def point(name: str, **more):
    return parse_point(POINTS[name] | {"transient": 5, "average": 5} | more, "point")


def met(name: str, samples: int, partners: set[int]):
    """Return a flow after so many samples and as many more as it takes to touch such partners.

    And its contacts, pairs and forces.
    """
    parameters = point(name)
    system = build(parameters, 0)
    system.settle()
    most = parameters.most_contacts * (parameters.particles + parameters.glued_particles)
    for taken in range(samples + 400):
        system.advance()
        listed = system.current_contacts(most)
        number = int(listed.number[0])
        if taken > samples and partners <= set(listed.pair[:number, 1]) and number > 20:
            return system, listed.pair[:number].astype(int), listed.force[:number]
    raise AssertionError("they never touch")


def test_the_forces_are_those_that_the_next_step_has():
    system, pair, force = met("chute", 60, {-1})
    total = np.zeros((len(system.spheres.mass), 3))
    np.add.at(total, pair[:, 0], force)
    inner = pair[:, 1] >= 0
    np.add.at(total, pair[inner, 1], -force[inner])
    system._run(1)
    found = np.zeros_like(total)
    found[system.spheres.label[0]] = system.spheres.force.sum(axis=0).T
    mobile = np.zeros(len(total), bool)
    mobile[system.spheres.label[0]] = system.spheres.mass > 0
    assert total[mobile] == pytest.approx(found[mobile], abs=1e-9 * abs(found).max())


def test_the_beads_of_a_contact_feel_what_their_law_says():
    """Forces of a pair are not opposite, as each bead is damped by its own mass."""
    _, pair, force = met("belt", 30, {-1, -2})
    both = {(i, j): one for (i, j), one in zip(pair, force, strict=True)}
    inner = [key for key in both if key[1] >= 0]
    assert inner and all(key[::-1] in both for key in inner)
    lacking = max(np.abs(both[key] + both[key[::-1]]).max() for key in inner)
    assert lacking > 1e-3 * np.abs(force).max()
    assert sum(one[1] for key, one in both.items() if key[1] < 0) > 0
