"""Beads in motion: impacts, momentum, neighbor list, how it stops; on the belt, at the obstacle."""

import numpy as np
import pytest

from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.dynamics.cells import NOT_FINITE, OK, OVERLAP
from sim.engine.dynamics.disks import Gear, Verlet
from sim.engine.systems import shaking
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_GRAVITY,
    BEAD_MASS,
    DAMPING,
    REDUCED,
    YOUNG,
    bead_law,
    lattice,
    wrapped,
)
from tests.engine_motion.motion import AT_REST, DiskMotion
from tests.engine_motion.points import belt_point

#: Readings with their integrators: two kinds of loops, which golden points have as well.
LOOPS = [({}, Gear), (REDUCED, Verlet)]
SPEED = 0.1
FAR = 30 * BEAD


def impact_restitution(
    law, integrator, time_step=1e-6, sizes=(1.0, 1.0), gap=0.3, corrections=1
) -> float:
    """Restitution of two beads that meet head-on, ``gap`` steps after the start."""
    diameter = BEAD * np.array(sizes)
    distance = diameter.mean() + gap * SPEED * time_step
    place = [[5 * BEAD, FAR], [5 * BEAD + distance, FAR]]
    mass = BEAD_MASS * np.array(sizes) ** 2
    options = {"radius": 0.5 * diameter, "mass": mass, "time_step": time_step}
    options |= {"law": law, "integrator": integrator, "corrections": corrections}
    motion = DiskMotion(place, [[SPEED / 2, 0], [-SPEED / 2, 0]], **options)
    motion.run(int(1.5e-3 / time_step))
    return float(motion.velocity[1, 0] - motion.velocity[0, 0]) / SPEED


def restitution(rate: float, frequency_squared: float, clipped: bool = False) -> float:
    """Restitution of a damped oscillator; ``clipped`` where spring and damping cancel.

    x = sin(wt) exp(-eta t) lets go where w0^2 x + 2 eta x' = 0; from there the beads fly free. That
    is at w t = pi - atan2(2 eta w, w^2 - eta^2), with the speed exp(-eta t).
    """
    frequency = np.sqrt(frequency_squared - rate**2)
    early = np.arctan2(2 * rate * frequency, frequency**2 - rate**2) if clipped else 0.0
    return float(np.exp(-rate / frequency * (np.pi - early)))


def pair_restitution(readings, sizes=(1.0, 1.0)) -> float:
    """Of equal beads with their own mass, or of any with the reduced one, at half the rate."""
    squared = YOUNG * (1 / (BEAD_MASS * np.array(sizes) ** 2)).sum()
    return restitution(DAMPING / (2 if readings else 1), squared, bool(readings))


@pytest.mark.parametrize(
    ("readings", "integrator", "sizes"),
    [(*loop, (1.0, 1.0)) for loop in LOOPS] + [(*LOOPS[1], (0.6, 1.4))],
)
def test_pair_restitution_is_that_of_a_damped_oscillator(readings, integrator, sizes):
    expected = pair_restitution(readings, sizes)
    found = impact_restitution(bead_law(**readings), integrator, sizes=sizes)
    assert found == pytest.approx(expected, abs=1e-3)
    if readings:
        squared = YOUNG * (1 / (BEAD_MASS * np.array(sizes) ** 2)).sum()
        assert expected > restitution(DAMPING / 2, squared) + 2e-3
    else:
        assert expected == pytest.approx(0.70, abs=5e-3)


def test_damping_that_goes_with_the_root_of_the_stiffness_keeps_the_restitution():
    """Of all pairs, as rate over frequency stays; at a fixed rate it rises with the stiffness."""
    for sizes in ((1.0, 1.0), (0.6, 1.4)):
        usual = impact_restitution(bead_law(), Gear, sizes=sizes)
        for factor in (0.7, 5.0):
            p = belt_point(stiffness=1e3 * factor, stiffness_keeps="restitution")
            law = bead_law(stiffness=factor * YOUNG, damping=p.normal_damping)
            assert impact_restitution(law, Gear, sizes=sizes) == pytest.approx(usual, abs=1e-3)
        assert impact_restitution(bead_law(stiffness=5 * YOUNG), Gear, sizes=sizes) > usual + 0.1


@pytest.mark.parametrize(("readings", "integrator"), LOOPS)
def test_restitution_at_the_published_step_is_within_two_percent(readings, integrator):
    """Damping jumps where contacts begin and end: an error of first order for any integrator."""
    exact, law, errors = pair_restitution(readings), bead_law(**readings), []
    for time_step in (2.5e-5, 2.5e-6):
        gaps = np.linspace(0.05, 0.95, 12)
        found = [impact_restitution(law, integrator, time_step, gap=gap) for gap in gaps]
        errors.append(np.abs(np.array(found) - exact).max())
    assert errors[0] < 0.02
    assert errors[1] < 0.25 * errors[0]


def crowd(seed=8, base=FAR, shape=(5, 4), **options) -> DiskMotion:
    """A polydisperse cluster of touching beads in a cell as wide as it."""
    rng = np.random.default_rng(seed)
    position = lattice(shape, BEAD, 0.1, rng, base)
    radius = 0.5 * BEAD * rng.uniform(0.5, 1.5, len(position))
    mass = BEAD_MASS * (2 * radius / BEAD) ** 2
    velocity = rng.normal(0, SPEED, position.shape)
    options = {"width": shape[0] * BEAD, "radius": radius, "mass": mass} | options
    return DiskMotion(position, velocity, **options)


@pytest.mark.parametrize("shear", [0.0, DAMPING])
def test_reduced_mass_conserves_the_momentum_of_free_beads(shear):
    motion = crowd(law=bead_law(shear_damping=shear, **REDUCED), integrator=Verlet)
    before, scale = motion.mass @ motion.velocity, motion.mass.sum() * SPEED
    assert np.abs(motion.run(400).mass @ motion.velocity - before).max() < 1e-12 * scale
    own_mass = crowd(law=bead_law(shear_damping=shear)).run(400)
    assert np.abs(own_mass.mass @ own_mass.velocity - before).max() > 1e-3 * scale


@pytest.mark.parametrize("base", [FAR, -0.4 * BEAD])
def test_skin_changes_the_trajectory_by_rounding_only(base):
    options = {"base": base, "gravity": BEAD_GRAVITY, "belt": Belt(BEAD, BEAD, 200.0, 0.3, 0.0)}
    thin, thick = (crowd(skin=skin, room=60, **options).run(300) for skin in (1e-6, 0.9e-3))
    difference = wrapped(thin.position - thick.position, 5 * BEAD, 0.0)
    assert np.abs(difference).max() < 1e-10 * BEAD
    assert thin.velocity == pytest.approx(thick.velocity, abs=1e-9 * SPEED)


def test_a_list_that_grows_gives_the_same_bits_as_one_with_room():
    options = {"shape": (7, 6), "gravity": BEAD_GRAVITY, "corrections": 2}
    tight, roomy = (crowd(base=0.0, room=room, **options) for room in (0, 60))
    capacity = tight.pairs.second.size
    tight.run(1500)
    roomy.run(1500)
    assert tight.pairs.second.size > capacity
    assert np.array_equal(tight.taylor, roomy.taylor)
    assert np.array_equal(tight.loop.sums, roomy.loop.sums)


@pytest.mark.long
def test_gear_and_verlet_agree_as_the_time_step_falls():
    belt = Belt(BEAD, BEAD, 2 * np.pi * 20, 0.0, 0.0)
    difference = []
    for time_step in (2e-5, 2e-6):
        options = {"time_step": time_step, "base": -0.4 * BEAD, "belt": belt}
        ends = [
            crowd(integrator=kind, gravity=BEAD_GRAVITY, **options).run(int(1e-3 / time_step))
            for kind in (Gear, Verlet)
        ]
        difference.append(np.abs(ends[0].position - ends[1].position).max())
    assert difference[0] < 1e-2 * BEAD
    assert difference[1] < 0.2 * difference[0]


def test_an_overlap_beyond_the_limit_and_what_is_not_finite_stop_a_run_at_their_step():
    limit = 0.999 * crowd().run(200).loop.sums[shaking.LARGEST]
    stopped_motion = crowd(overlap_limit=limit)
    assert stopped_motion.advance(200) == OVERLAP
    before = crowd(overlap_limit=limit)
    assert before.advance(stopped_motion.loop.step[0] - 1) == OK
    for bad, term in ((np.nan, 0), (np.inf, 1)):
        motion = crowd().run(5)
        motion.disks.taylor[term, 1, 7] = bad
        assert motion.advance(200) == NOT_FINITE and motion.loop.step[0] < 200


INDENTATION = BEAD_MASS * BEAD_GRAVITY / YOUNG

with_loops = pytest.mark.parametrize(("readings", "integrator"), LOOPS)


def bead_on_belt(velocity=(0.0, 0.0), **options) -> DiskMotion:
    """A bead in vertical equilibrium on the belt, as its weight presses it in."""
    return DiskMotion(
        [[5 * BEAD, 0.5 * BEAD - INDENTATION]], [velocity], gravity=BEAD_GRAVITY, **options
    )


@with_loops
@pytest.mark.parametrize("shear", [0.2 * DAMPING, 4 * DAMPING])
def test_held_bead_relaxes_to_the_belt(shear, readings, integrator):
    slowing = [[-0.3 * shear, 0.0]]
    law = bead_law(shear_damping=shear, **readings)
    motion = bead_on_belt((0.3, 0.0), acceleration=slowing, law=law, integrator=integrator)
    for _ in range(20):
        motion.run(10)
        expected = 0.3 * np.exp(-shear * motion.loop.step[0] * 2.5e-5)
        assert motion.velocity[0, 0] == pytest.approx(expected, abs=2e-3 * 0.3)
    assert abs(motion.velocity[0, 1]) < 1e-8


@with_loops
def test_held_bead_is_dragged_by_a_belt_that_moves_sideways(readings, integrator):
    """v' = -gamma_s (v - A w cos wt), v = 0 at first: a lagging oscillation and a transient."""
    rate, velocities, expected = 2 * np.pi * 20, [], []
    options = {"belt": Belt(BEAD, 0.0, rate, 0.0, 0.0), "law": bead_law(**readings)}
    pulled = [[DAMPING * BEAD * rate, 0.0]]
    motion = bead_on_belt(acceleration=pulled, integrator=integrator, **options)
    response = DAMPING / (DAMPING + 1j * rate) * BEAD * rate
    for _ in range(40):
        time = motion.run(50).loop.step[0] * 2.5e-5
        velocities.append(motion.velocity[0, 0])
        lagging = np.real(response * np.exp(1j * rate * time))
        expected.append(lagging - np.real(response) * np.exp(-DAMPING * time))
    assert np.array(velocities) == pytest.approx(np.array(expected), abs=1e-4 * BEAD * rate)


@pytest.mark.parametrize("surface", [0.0, 0.5 * BEAD])
@pytest.mark.parametrize(("size", "ghost"), [(1.0, np.inf), (0.6, 1.0), (1.4, 0.25)])
def test_a_bead_bounces_off_the_resting_belt_with_the_reduced_mass(size, ghost, surface):
    """A bead of mass m and a ghost of mass M: rate γ/2 M/(m + M), from γ/2 m M/(m + M)/m."""
    mass, ghost = size**2 * BEAD_MASS, ghost * BEAD_MASS
    rate = 0.5 * DAMPING / (1 + mass / ghost)
    options = {"mass": mass, "radius": 0.5 * size * BEAD, "time_step": 1e-6, "integrator": Verlet}
    options |= {"belt": AT_REST._replace(inverse_mass=1 / ghost, surface=surface)}
    start = [[0.0, surface + 0.5 * size * BEAD + 1e-8]]
    motion = DiskMotion(start, [[0.0, -0.1]], law=bead_law(**REDUCED), **options).run(2500)
    expected = restitution(rate, YOUNG / mass, clipped=True)
    assert motion.velocity[0, 1] / 0.1 == pytest.approx(expected, abs=1e-3)


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


def test_obstacle_repeats_with_the_cell_and_is_felt_across_its_edge():
    """As by a bead that has left the cell since the list of neighbors was built."""
    motion = bead((0.6, 0.8), 5e-5).run(1)
    expected, largest = motion.force, motion.loop.sums[shaking.LARGEST]
    assert largest == pytest.approx(5e-5 / REACH, rel=1e-5)
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


@with_loops
def test_restitution_off_the_obstacle_is_that_of_an_infinite_mass(readings, integrator):
    options = {"law": bead_law(**readings), "integrator": integrator}
    motion = bead((0.0, 1.0), -1e-8, (0.0, -0.1), time_step=1e-6, **options).run(1500)
    expected = restitution(0.5 * DAMPING, YOUNG / BEAD_MASS, bool(readings))
    assert motion.velocity[0, 1] / 0.1 == pytest.approx(expected, abs=1e-3)
