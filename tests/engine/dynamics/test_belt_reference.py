"""The loop over steps of the beads against the slow reference, from dense random states."""

import numpy as np
import pytest

from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.dynamics.disks import Verlet
from sim.engine.systems import shaking
from tests.engine.reference import belt as slow
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_GRAVITY,
    BEAD_LAWS,
    BEAD_MASS,
    DAMPING,
    REDUCED,
    YOUNG,
    bead_law,
    gear,
    lattice,
    wrapped,
)
from tests.engine_motion.motion import DiskMotion

STEPS = 80
SPEED, FREQUENCY, PHASE = 0.1, 30.0, 0.7
ALONG, UP = 0.6 * BEAD, BEAD
GHOSTS = {"below": 0.0, "centred": 0.5 * BEAD}


def dense_state(seed: int, shape=(5, 6)):
    """Positions, velocities, radii and masses of a disordered bed in contact with the belt."""
    rng = np.random.default_rng(seed)
    position = lattice(shape, BEAD, 0.1, rng)
    radius = 0.5 * BEAD * rng.uniform(0.6, 1.4, len(position))
    return (
        position,
        rng.normal(0, SPEED, position.shape),
        radius,
        BEAD_MASS * (2 * radius / BEAD) ** 2,
    )


def make_both(seed, integrator, ghost, obstacle, shear=DAMPING, shape=(5, 6), **readings):
    """A bed of the engine and of the reference; the obstacle stands between two of its beads.

    Of the readings ``order``, ``corrections`` and ``ghost_mass`` are none of the law of beads.
    """
    order, corrections = readings.pop("order", 5), readings.pop("corrections", 1)
    ghost_mass = readings.pop("ghost_mass", np.inf)
    position, velocity, radius, mass = dense_state(seed, shape)
    position[:, 1] += GHOSTS[ghost]
    width, time_step = max(5, shape[0]) * BEAD, 1 / (2000 * FREQUENCY)
    rate = 2 * np.pi * FREQUENCY
    expected = slow.Belt(
        width,
        BEAD,
        YOUNG,
        DAMPING,
        shear,
        BEAD_GRAVITY,
        (ALONG, UP),
        rate,
        PHASE,
        obstacle,
        belt_ghost=ghost,
        ghost_mass=ghost_mass,
        **readings,
    )
    force = slow.forces(expected, 2 * radius, mass, position, velocity, 0.0)
    motion = DiskMotion(
        position,
        velocity,
        acceleration=force / mass[:, None] - np.array([0.0, BEAD_GRAVITY]),
        law=bead_law(shear_damping=shear, **readings),
        integrator=Verlet if integrator == "verlet" else gear(order),
        corrections=corrections,
        time_step=time_step,
        radius=radius,
        mass=mass,
        width=width,
        gravity=BEAD_GRAVITY,
        belt=Belt(ALONG, UP, rate, PHASE, GHOSTS[ghost], 1 / ghost_mass),
        obstacle=Obstacle(0.5 * width, UP, 0.5 * obstacle),
        skin=0.05 * BEAD,
        overlap_limit=1.0,
    )
    return motion, expected


@pytest.mark.parametrize(("ghost", "obstacle"), [("below", 0.0), ("centred", 1.5 * BEAD)])
@pytest.mark.parametrize(
    ("readings", "integrator"),
    [*BEAD_LAWS, pytest.param({}, "verlet", marks=pytest.mark.long)],
)
def test_short_shaking_equals_the_reference(readings, integrator, ghost, obstacle):
    equal_after_a_while(1, integrator, ghost, obstacle, **readings)


@pytest.mark.parametrize(("order", "corrections"), [(3, 1), (4, 2)])
def test_other_correctors_equal_the_reference(order, corrections):
    equal_after_a_while(2, "gear", "below", 0.0, order=order, corrections=corrections)


def test_a_ghost_of_finite_mass_equals_the_reference():
    equal_after_a_while(2, "verlet", "below", 0.0, ghost_mass=0.1 * BEAD_MASS, **REDUCED)


def equal_after_a_while(seed, integrator, ghost, obstacle, **readings):
    """Hold the engine to the reference over a short run in which beads, belt and obstacle meet."""
    order, corrections = readings.get("order", 5), readings.get("corrections", 1)
    motion, belt = make_both(seed, integrator, ghost, obstacle, shear=0.6 * DAMPING, **readings)
    start = motion.position.copy(), motion.velocity.copy()
    beads = slow.Beads(2 * motion.radius, motion.mass, *start)
    motion.run(STEPS)
    scheme = slow.Scheme(motion.integrator.time_step, integrator, order, corrections)
    places, velocities = slow.run(belt, beads, scheme, STEPS)
    difference = wrapped(motion.position - places[-1], belt.width, 0.0)
    assert np.abs(difference).max() < 1e-10 * BEAD
    assert motion.velocity == pytest.approx(velocities[-1], abs=1e-10 * SPEED)
    assert motion.loop.sums[shaking.CONTACTS] > 1.5 * STEPS * len(motion.position)
    assert np.abs(motion.velocity - start[1]).max() > 0.5 * SPEED


@pytest.mark.parametrize("shape", [(5, 1), (9, 12)])
def test_forces_of_one_step_equal_the_reference(shape):
    """Forces act where the predictor puts the beads, at the velocities that it predicts."""
    motion, belt = make_both(3, "gear", "below", 1.5 * BEAD, shape=shape)
    step, curve = motion.integrator.time_step, motion.taylor[2]
    place = motion.position + motion.velocity * step + curve
    velocity = motion.velocity + 2 * curve / step
    motion.run(1)
    diameter, mass = 2 * motion.radius, motion.mass
    expected = slow.forces(belt, diameter, mass, place, velocity, step)
    assert motion.force == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
    touching = 2 * len(slow.touching(belt, diameter, place))
    for bead in zip(diameter, mass, place, velocity, strict=True):
        touching += slow.belt_force(belt, *bead, step).any()
        touching += slow.obstacle_force(belt, *bead).any()
    assert motion.loop.sums[shaking.CONTACTS] == touching
