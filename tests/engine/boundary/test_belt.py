"""The vibrating belt: its motion, its ghost, and single beads on it."""

import numpy as np
import pytest

from sim.engine.boundary.belt import Belt
from sim.engine.dynamics.disks import Gear, Verlet
from sim.engine.systems import shaking
from tests.engine_motion.disks import AT_REST, DiskMotion
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_GRAVITY,
    BEAD_MASS,
    DAMPING,
    YOUNG,
    bead_law,
    belt_states,
    lattice,
)

INTEGRATORS = [Gear, Verlet]
INDENTATION = BEAD_MASS * BEAD_GRAVITY / YOUNG
REDUCED = bead_law(damping_mass="reduced", attraction="clipped")


def vibrating_belt(
    frequency: float, along: float = BEAD, up: float = BEAD, phase=0.0, surface=0.0
) -> Belt:
    return Belt(along, up, 2 * np.pi * frequency, phase, surface)


def bead_on_belt(velocity=(0.0, 0.0), **options) -> DiskMotion:
    """A bead in vertical equilibrium on the belt, as its weight presses it in."""
    options = {"gravity": BEAD_GRAVITY} | options
    surface = options.get("belt", AT_REST).surface
    return DiskMotion([[5 * BEAD, surface + 0.5 * BEAD - INDENTATION]], [velocity], **options)


def test_belt_moves_along_its_angle_with_the_derivative_of_its_position():
    belt = vibrating_belt(20.0, along=0.5 * BEAD, phase=0.7)
    time, delta = np.linspace(0, 0.1, 50), 1e-7
    height, velocity = belt_states(belt, time)
    rate = (belt_states(belt, time + delta)[0] - belt_states(belt, time - delta)[0]) / (2 * delta)
    assert velocity[:, 1] == pytest.approx(rate, rel=1e-6, abs=1e-7)
    assert velocity[:, 0] == pytest.approx(0.5 * velocity[:, 1], rel=1e-12)
    assert height[0] == pytest.approx(BEAD * np.sin(0.7), rel=1e-14)
    assert height == pytest.approx(BEAD * np.sin(2 * np.pi * 20 * time + 0.7), abs=1e-12 * BEAD)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("shear", [0.2 * DAMPING, DAMPING, 4 * DAMPING])
def test_held_bead_relaxes_to_the_belt(shear, integrator):
    slowing = [[-0.3 * shear, 0.0]]
    law = bead_law(shear_damping=shear)
    motion = bead_on_belt((0.3, 0.0), acceleration=slowing, law=law, integrator=integrator)
    for _ in range(20):
        motion.run(10)
        expected = 0.3 * np.exp(-shear * motion.loop.step[0] * 2.5e-5)
        assert motion.velocity[0, 0] == pytest.approx(expected, abs=2e-3 * 0.3)
    assert abs(motion.velocity[0, 1]) < 1e-8


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_held_bead_is_dragged_by_a_belt_that_moves_sideways(integrator):
    """v' = -gamma_s (v - A w cos wt), v = 0 at first: a lagging oscillation and a transient."""
    belt = vibrating_belt(20.0, up=0.0)
    rate, velocities, expected = 2 * np.pi * 20, [], []
    pulled = [[DAMPING * BEAD * rate, 0.0]]
    motion = bead_on_belt(acceleration=pulled, belt=belt, integrator=integrator)
    response = DAMPING / (DAMPING + 1j * rate) * BEAD * rate
    for _ in range(40):
        time = motion.run(50).loop.step[0] * 2.5e-5
        velocities.append(motion.velocity[0, 0])
        lagging = np.real(response * np.exp(1j * rate * time))
        expected.append(lagging - np.real(response) * np.exp(-DAMPING * time))
    assert np.array(velocities) == pytest.approx(np.array(expected), abs=1e-4 * BEAD * rate)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("surface", [0.0, 0.5 * BEAD])
def test_bead_bounces_off_the_resting_belt_as_a_damped_oscillator(surface, integrator):
    belt = Belt(0.0, 0.0, 0.0, 0.0, surface)
    start = [[0.0, surface + 0.5 * BEAD + 1e-8]]
    options = {"belt": belt, "integrator": integrator, "time_step": 1e-6}
    motion = DiskMotion(start, [[0.0, -0.1]], **options).run(1500)
    rate, frequency = 0.5 * DAMPING, YOUNG / BEAD_MASS
    expected = np.exp(-np.pi * rate / np.sqrt(frequency - rate**2))
    assert motion.velocity[0, 1] / 0.1 == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("share", [1.0, 0.25])
@pytest.mark.parametrize("size", [0.6, 1.0, 1.4])
def test_a_ghost_of_finite_mass_damps_with_the_reduced_mass(size, share):
    """A bead of mass m and a ghost of mass M: rate γ/2 M/(m + M), from γ/2 m M/(m + M)/m.

    The contact ends where spring and damping cancel, as attraction is clipped.
    """
    mass, ghost = size**2 * BEAD_MASS, share * BEAD_MASS
    rate, squared = 0.5 * DAMPING * ghost / (mass + ghost), YOUNG / mass
    frequency = np.sqrt(squared - rate**2)
    release = np.pi - np.arctan2(2 * rate * frequency, frequency**2 - rate**2)
    options = {"mass": mass, "radius": 0.5 * size * BEAD, "time_step": 1e-6, "integrator": Verlet}
    options |= {"law": REDUCED, "belt": AT_REST._replace(inverse_mass=1 / ghost)}
    motion = DiskMotion([[0.0, 0.5 * size * BEAD + 1e-8]], [[0.0, -0.1]], **options).run(2500)
    assert motion.velocity[0, 1] / 0.1 == pytest.approx(
        np.exp(-rate / frequency * release), abs=1e-3
    )


def test_a_bead_on_a_ghost_of_its_own_mass_relaxes_to_the_belt_half_as_fast():
    options = {"law": REDUCED, "belt": AT_REST._replace(inverse_mass=1 / BEAD_MASS)}
    options |= {"integrator": Verlet, "acceleration": [[-0.15 * DAMPING, 0.0]]}
    motion = bead_on_belt((0.3, 0.0), **options).run(200)
    expected = 0.3 * np.exp(-0.5 * DAMPING * 200 * 2.5e-5)
    assert motion.velocity[0, 0] == pytest.approx(expected, abs=1e-3 * 0.3)


@pytest.mark.parametrize("radius", [0.25 * BEAD, 0.75 * BEAD])
def test_ghosts_touch_a_bead_one_radius_above_their_surface(radius):
    for surface in (0.0, 0.5 * BEAD):
        belt = vibrating_belt(20.0, surface=surface, phase=1.1)
        reach = BEAD * np.sin(1.1 + 2 * np.pi * 20 * 1e-9) + surface + radius
        for gap, touching in ((1e-8, 0), (-1e-8, 1)):
            start = [[0.0, reach + gap]]
            motion = DiskMotion(start, [[0.0, 0.0]], radius=radius, belt=belt, time_step=1e-9)
            assert motion.run(1).loop.sums[shaking.CONTACTS] == touching


def test_both_ghosts_give_the_same_motion_half_a_diameter_apart():
    rng = np.random.default_rng(8)
    position, velocity = lattice((4, 3), BEAD, 0.1, rng), rng.normal(0, 0.05, (12, 2))
    position[:, 1] -= 0.5 * BEAD
    options = {"gravity": BEAD_GRAVITY, "width": 5 * BEAD}
    below = DiskMotion(position, velocity, belt=vibrating_belt(20.0), **options)
    raised = position + np.array([0.0, 0.5 * BEAD])
    centred = DiskMotion(raised, velocity, belt=vibrating_belt(20.0, surface=0.5 * BEAD), **options)
    below.run(200)
    centred.run(200)
    assert centred.velocity == pytest.approx(below.velocity, abs=1e-9)
    assert np.abs(below.velocity - velocity).max() > 0.05


def test_a_phase_is_a_later_start():
    """Launched at rest in phase with the belt, a run begun at phi equals one begun phi/w later."""
    late = vibrating_belt(20.0, phase=0.3 * np.pi)
    early = vibrating_belt(20.0)
    steps = 300
    lead = 0.3 * np.pi / (2 * np.pi * 20)
    time_step = lead / steps
    height = 0.5 * BEAD + BEAD * np.sin(0.3 * np.pi)
    options = {"gravity": BEAD_GRAVITY, "time_step": time_step}
    late_motion = DiskMotion([[0.0, height]], [[0.0, 0.0]], belt=late, **options).run(500)
    early_motion = DiskMotion([[0.0, height]], [[0.0, 0.0]], belt=early, **options)
    early_motion.loop.step[0] = steps
    early_motion.run(500)
    assert early_motion.velocity == pytest.approx(late_motion.velocity, abs=1e-10)
    assert np.abs(late_motion.velocity).max() > 0.01


def test_held_bead_follows_a_slow_belt_up_and_down():
    """At Gamma = 0.16 the bead stays on the belt; it lags by the spring's give only."""
    belt = vibrating_belt(6.4, along=0.0)
    motion = bead_on_belt(belt=belt, time_step=1 / (2000 * 6.4))
    motion.disks.taylor[1, 1, 0] = BEAD * belt.angular_frequency * motion.integrator.time_step
    for _ in range(20):
        motion.run(100)
        height = BEAD * np.sin(belt.angular_frequency * motion.loop.step[0] / (2000 * 6.4))
        assert motion.position[0, 1] - height == pytest.approx(
            0.5 * BEAD - INDENTATION, abs=0.3 * INDENTATION
        )
