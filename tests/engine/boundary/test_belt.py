"""The belt, its ghost, and single beads on it; the obstacle, blind to the belt."""

import numpy as np
import pytest

from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.dynamics.disks import Gear, Verlet
from sim.engine.systems import shaking
from tests.engine_motion.disks import AT_REST, DiskMotion
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_GRAVITY,
    BEAD_LAWS,
    BEAD_MASS,
    DAMPING,
    YOUNG,
    bead_law,
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


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("shear", [0.2 * DAMPING, 4 * DAMPING])
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
@pytest.mark.parametrize("size", [0.6, 1.4])
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


@pytest.mark.parametrize("radius", [0.25 * BEAD, 0.75 * BEAD])
def test_ghosts_touch_a_bead_one_radius_above_their_surface(radius):
    for surface in (0.0, 0.5 * BEAD):
        belt = vibrating_belt(20.0, surface=surface, phase=1.1)
        reach = BEAD * np.sin(1.1 + 2 * np.pi * 20 * 1e-9) + surface + radius
        for gap, touching in ((1e-8, 0), (-1e-8, 1)):
            start = [[0.0, reach + gap]]
            motion = DiskMotion(start, [[0.0, 0.0]], radius=radius, belt=belt, time_step=1e-9)
            assert motion.run(1).loop.sums[shaking.CONTACTS] == touching


WIDTH = 10 * BEAD
OBSTACLE = Obstacle(x=0.5 * WIDTH, z=4 * BEAD, radius=0.75 * BEAD)
REACH = OBSTACLE.radius + 0.6 * BEAD


def bead(direction, overlap: float, velocity=(0.0, 0.0), **options) -> DiskMotion:
    """A bead of diameter 1.2 mm that overlaps the obstacle, on its side along ``direction``."""
    start = np.array([OBSTACLE.x, OBSTACLE.z]) + (REACH - overlap) * np.array(direction)
    options = {"obstacle": OBSTACLE, "time_step": 1e-9} | options
    return DiskMotion(
        [start], [velocity], radius=0.6 * BEAD, mass=BEAD_MASS, width=WIDTH, **options
    )


@pytest.mark.parametrize("angle", np.radians([0.0, 37.0, 250.0]))
def test_force_is_that_of_a_heavy_disk(angle):
    outward, across = (
        np.array([np.cos(angle), np.sin(angle)]),
        np.array([-np.sin(angle), np.cos(angle)]),
    )
    velocity = -0.03 * outward + 0.02 * across
    motion = bead(outward, 5e-5, velocity).run(1)
    push = YOUNG * 5e-5 + DAMPING * BEAD_MASS * 0.03
    expected = push * outward - DAMPING * BEAD_MASS * 0.02 * across
    assert motion.force[0] == pytest.approx(expected, abs=1e-5 * push)
    assert motion.loop.sums[shaking.CONTACTS] == 1
    assert motion.loop.sums[shaking.LARGEST] == pytest.approx(5e-5 / REACH, rel=1e-5)


def test_obstacle_repeats_with_the_cell_and_is_felt_across_its_edge():
    """As by a bead that has left the cell since the list of neighbors was built."""
    expected = bead((0.6, 0.8), 5e-5).run(1).force
    for laps in (-3, 1, 2):
        there = bead((0.6, 0.8), 5e-5)
        there.disks.taylor[0, 0, 0] += laps * WIDTH
        assert there.run(1).force == pytest.approx(expected, rel=1e-9)
    edge = OBSTACLE._replace(x=-0.1 * BEAD)
    across = bead((0.6, 0.8), 5e-5, obstacle=edge)
    across.disks.taylor[0, 0, 0] += edge.x - OBSTACLE.x
    assert across.run(1).force == pytest.approx(expected, rel=1e-9)
    assert not bead((1.0, 0.0), -1e-8).run(1).force.any()
    assert not bead((1.0, 0.0), 5e-5, obstacle=OBSTACLE._replace(radius=0.0)).run(1).force.any()


def test_obstacle_neither_moves_with_the_belt_nor_with_the_beads():
    """A far belt that shakes changes nothing; the bead returns as from a wall at rest."""
    shaking_belt = Belt(BEAD, BEAD, 2 * np.pi * 50, 0.0, -20 * BEAD)
    options = {"time_step": 1e-6, "law": bead_law(damping=0.0, shear_damping=0.0)}
    still_motion = bead((0.0, 1.0), -1e-8, (0.0, -0.1), **options).run(3000)
    shaken_motion = bead((0.0, 1.0), -1e-8, (0.0, -0.1), belt=shaking_belt, **options).run(3000)
    assert np.array_equal(still_motion.velocity, shaken_motion.velocity)
    assert still_motion.velocity[0, 1] == pytest.approx(0.1, rel=1e-3)


@pytest.mark.parametrize(("readings", "integrator"), BEAD_LAWS[::2])
def test_restitution_off_the_obstacle_is_that_of_an_infinite_mass(readings, integrator):
    """Of a contact that ends with the overlap, or where spring and damping cancel if clipped."""
    law_and_integrator = {
        "law": bead_law(**readings),
        "integrator": Gear if integrator == "gear" else Verlet,
    }
    motion = bead((0.0, 1.0), -1e-8, (0.0, -0.1), time_step=1e-6, **law_and_integrator).run(1500)
    rate = 0.5 * DAMPING
    frequency = np.sqrt(YOUNG / BEAD_MASS - rate**2)
    early = np.arctan2(2 * rate * frequency, frequency**2 - rate**2)
    end = np.pi - early * (readings["attraction"] == "clipped")
    expected = np.exp(-rate / frequency * end)
    assert motion.velocity[0, 1] / 0.1 == pytest.approx(expected, abs=1e-3)
