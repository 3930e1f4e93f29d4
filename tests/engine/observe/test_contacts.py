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
from sim.engine.observe.force_balance import inertial_number, shear_rate, stress_ratio
from sim.engine.observe.samples import add_sums
from sim.engine.systems import build, leap_frog
from sim.engine.systems.leap_frog import FlowContacts
from tests.engine.dynamics.test_chute_reference import SPEED, dense_state, laws
from tests.engine.reference import chute as slow
from tests.engine_motion.helpers import MASS, RADIUS
from tests.engine_motion.points import chute_point, sums_of
from tests.engine_motion.spheres import SphereMotion

SMALL = {"depth": 2, "cell": 5, "stress_profiles": True}
READINGS = [
    {},
    # Takes long to compile; springs and dashpots are another law.
    pytest.param({"tangential_exponent": 1, "overlap_memory": "reset"}, marks=pytest.mark.long),
    {"law": "spring_dashpot"},
    {"threads": 2},
    {"diameter_spread": 0.3},
    {"slice_height": 1.7},
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
    """In each slice and at each sample, to rounding."""
    system = moving(**reading)
    for _ in range(5):
        stress = sums_of(system)[3]
        expected, before = gains(system, stress), momentum_above(system)
        system._run(1)
        scale = (system.spheres.mass * np.abs(system.spheres.velocity)).sum()
        assert momentum_above(system) - before == pytest.approx(expected, abs=1e-12 * scale)
        weight = system.mass * system.parameters.gravity * system.time_step
        assert np.abs(expected).max() > 0.01 * weight > 1e-9 * scale


def test_above_bumps_stress_and_weight_are_what_the_momentum_above_gains():
    system = moving(bumps=0.8, bump_coverage=0.4)
    for _ in range(5):
        stress = sums_of(system)[3]
        expected, before = gains(system, stress), momentum_above(system)
        system._run(1)
        found = momentum_above(system) - before
        free = system.profile_height > 0.8 * system.parameters.diameter
        scale = (system.spheres.mass * np.abs(system.spheres.velocity)).sum()
        assert found[free] == pytest.approx(expected[free], abs=1e-12 * scale)


def test_contact_stress_is_that_of_the_reference():
    """Branch times force of each contact in the next step, shared among slices by length."""
    position, velocity, spin, radius = dense_state(seed=1)
    mass, box = MASS * (radius / RADIUS) ** 3, (3.9 * 2 * RADIUS, 3.0 * 2 * RADIUS)
    (law, plane_law), slow_laws = laws()
    options = {"law": law, "plane_law": plane_law, "box": box, "radius": radius, "mass": mass}
    motion = SphereMotion(position, velocity, spin, **options).run(7)
    chute = slow.Chute(*slow_laws, box)
    start = slow.Spheres(position, velocity, spin, radius, mass)
    state = slow.run(start, chute, motion.time_step, 7)

    slices, height = 30, 0.5 * RADIUS
    stress, slip = no_stress(slices), no_slip(slices)
    contacts = FlowContacts(motion.laws, motion.pairs, motion.plane, motion.memory)
    sampling = Sampling(7, height, motion.time_step, (0.4, 0.25))
    add_contacts(ContactSums(stress, slip), motion.spheres, contacts, sampling)

    expected = np.zeros((slices, 4))
    edges = height * np.arange(slices + 1)
    pressed, sliding, speeds = 0, 0, []
    _, _, after = slow.forces(state, chute, motion.time_step)
    for i, j, _, k_hat in slow.touching(state, chute):
        contact, z = after[i, j], state.position[i, 2]
        force = contact.tangential_force - contact.normal_force * k_hat
        branch = np.array([0.0, 0.0, z])
        if j != slow.PLANE:
            branch = -slow.nearest_image(state.position[j] - state.position[i], box)
        low, high = sorted([z, z - branch[2]])
        share = np.diff(np.clip(edges, low, high)) / (high - low)
        carried = [force[0] * branch[0], force[1] * branch[1], force[2] * branch[2]]
        expected += share[:, None] * np.array([*carried, -force[0] * branch[2]])
        if contact.normal_force > 0.0:
            law = chute.plane_law if j == slow.PLANE else chute.law
            drag = np.linalg.norm(contact.tangential_force)
            slides = drag > (1 - 1e-6) * law.friction * contact.normal_force
            slipping = slow.surface_velocity(state, i, j, k_hat)
            slipping = slipping - (slipping @ k_hat) * k_hat
            pressed, sliding = pressed + 1, sliding + slides
            speeds += [np.linalg.norm(slipping)] if slides else []
    assert stress.branches == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert pressed > sliding > 10
    assert (slip.contacts.sum(), slip.sliding.sum()) == (pressed, sliding)
    assert slip.speed.sum() == pytest.approx(sum(speeds), rel=1e-9)


def test_kinetic_stress_is_that_about_the_mean_profile():
    """Free spheres: a mean motion, the same in all slices, and what differs from it."""
    rng, number = np.random.default_rng(2), 4000
    position = 60 * RADIUS * rng.uniform(0.2, 0.9, (number, 3))
    spread = SPEED * np.array([[1.0, 0.0, -0.4], [0.0, 0.7, 0.0], [0.0, 0.0, 0.5]])
    velocity = rng.normal(size=(number, 3)) @ spread + np.array([3.0, 0.0, 0.0])
    motion = SphereMotion(position, velocity, radius=1e-3 * RADIUS, box=(0.04, 0.04))
    stress, slip = no_stress(3), no_slip(3)
    contacts = FlowContacts(motion.laws, motion.pairs, motion.plane, motion.memory)
    add_contacts(
        ContactSums(stress, slip), motion.spheres, contacts, Sampling(0, 20 * RADIUS, 1e-9, (0, 0))
    )
    found = stress.kinetic(1.0) / stress.mass[:, None]
    covariance = spread.T @ spread
    expected = [*np.diag(covariance), -covariance[0, 2]]
    assert found[1] == pytest.approx(expected, abs=0.1 * SPEED**2)
    assert stress.mass.sum() == pytest.approx(number * MASS)
    assert not stress.branches.any() and not slip.contacts.any()


@pytest.mark.parametrize(("friction", "slides"), [(0.4, False), (0.05, True)])
def test_a_sphere_alone_rolls_or_slips(friction, slides):
    """A sphere rolls where μ > (2/7) tan θ, but for the moments of its bouncing; else it slips."""
    system = moving(samples=400, depth=0.04, friction_plane=friction)
    sums = system.no_profiles()
    for _ in range(40):
        sums = tuple(add_sums(*pair) for pair in zip(sums, sums_of(system), strict=True))
    found = system.profiles(sums) | system.tables(sums)
    surface = found["velocity_profile"][1] - found["spin_profile"][1] * RADIUS
    if slides:
        assert found["sliding_share_profile"][0] == 1.0
        assert found["slip_velocity_profile"][0] == pytest.approx(surface, rel=0.01)
        assert surface > 0.5 * found["velocity_profile"][1]
    else:
        assert found["sliding_share_profile"][0] < 0.5
        assert abs(surface) < 1e-3 * found["velocity_profile"][1]


@pytest.mark.parametrize("reading", READINGS, ids=str)
def test_what_is_dissipated_over_the_height_is_the_loss_of_the_next_step(reading):
    system, total = moving(**reading), 0.0
    for _ in range(5):
        slip, step = sums_of(system)[4], system.time_step
        system._run(1)
        lost, work = system.flow.sums[[leap_frog.NORMAL_LOSS, leap_frog.FRICTION_WORK]]
        assert slip.lost.sum() * step == pytest.approx(lost, rel=1e-9, abs=1e-20)
        assert slip.rubbed.sum() * step == pytest.approx(work, rel=1e-9, abs=1e-20)
        total += lost + work
    assert total > 1e-12


def test_a_flow_that_shears_evenly_has_the_inertial_number_of_its_definition():
    height, rate, sigma = np.arange(40) * 1e-4 + 5e-5, 30.0, 1e-3
    velocity, normal = 0.02 + rate * height, np.full(40, 50.0)
    normal[-1] = 0.0
    found = inertial_number(shear_rate(velocity, 1e-4, sigma), normal, sigma, 2500.0)
    assert found[5:-5] == pytest.approx(rate * sigma * (2500.0 / 50.0) ** 0.5)
    assert np.isnan(found[[0, 4, -5, -1]]).all()
    assert np.isnan(shear_rate(velocity[:8], 1e-4, sigma)).all()
    ratio = stress_ratio(np.full(40, 20.0), normal)
    assert ratio[0] == pytest.approx(0.4) and np.isnan(ratio[-1])
