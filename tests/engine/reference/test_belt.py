"""Exact results of the belt's law, its boundaries and its motion."""

from dataclasses import replace

import numpy as np
import pytest

from .belt import Belt, belt_force, belt_motion, forces, obstacle_force, run

DIAMETER, MASS, GRAVITY = 1e-3, 1e-6, 10.0
STIFFNESS = 1e3 * GRAVITY * MASS / DIAMETER
DAMPING = 50 * GRAVITY
BELT = Belt(20 * DIAMETER, DIAMETER, STIFFNESS, DAMPING, DAMPING, GRAVITY)
FREE = replace(BELT, gravity=0.0)
INTEGRATORS = ["gear", "verlet"]


def shaken(frequency: float, horizontal: float, vertical: float, **changes) -> Belt:
    """A belt with amplitudes in diameters."""
    amplitude = (horizontal * DIAMETER, vertical * DIAMETER)
    return replace(BELT, amplitude=amplitude, angular_frequency=2 * np.pi * frequency, **changes)


def equal(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.full(count, DIAMETER), np.full(count, MASS)


def unequal(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Diameters of a uniform distribution and the masses that go with them."""
    diameter = DIAMETER * np.random.default_rng(seed).uniform(0.5, 1.5, count)
    return diameter, MASS * (diameter / DIAMETER) ** 2


def crowd(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Twelve beads on a jittered lattice, some of them overlapping, far above the belt."""
    rng = np.random.default_rng(seed)
    row, column = np.divmod(np.arange(12), 4)
    lattice = DIAMETER * np.stack([column + 0.5 * (row % 2), 10 + 0.9 * row], axis=1)
    position = lattice + 0.1 * DIAMETER * rng.uniform(-1, 1, (12, 2))
    return position, 0.05 * rng.normal(size=(12, 2))


def damped_restitution(rate: float, frequency_squared: float) -> float:
    return float(np.exp(-np.pi * rate / np.sqrt(frequency_squared - rate**2)))


def pair_restitution(belt: Belt, integrator: str, time_step: float) -> float:
    diameter, mass = equal(2)
    speed = 0.1
    gap = 0.3 * speed * time_step
    position = np.array([[5 * DIAMETER, 9e-3], [6 * DIAMETER + gap, 9e-3]])
    velocity = np.array([[0.5 * speed, 0], [-0.5 * speed, 0]])
    steps = int(1.5e-3 / time_step)
    _, velocities = run(belt, diameter, mass, position, velocity, time_step, steps, integrator)
    return float(velocities[-1, 1, 0] - velocities[-1, 0, 0]) / speed


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("damping_mass", "rate"), [("own", DAMPING), ("reduced", DAMPING / 2)])
def test_pair_restitution(damping_mass, rate, integrator):
    belt = replace(FREE, damping_mass=damping_mass)
    expected = damped_restitution(rate, 2 * STIFFNESS / MASS)
    assert pair_restitution(belt, integrator, 1e-6) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_pair_restitution_without_attraction(integrator):
    """The contact is over as soon as spring and damping cancel (Schwager and Poeschel 2007)."""
    rate, frequency_squared = DAMPING, 2 * STIFFNESS / MASS
    frequency = np.sqrt(frequency_squared - rate**2)
    angle = np.pi - np.arctan2(2 * rate * frequency, frequency**2 - rate**2)
    belt = replace(FREE, attraction="clipped")
    found = pair_restitution(belt, integrator, 1e-6)
    assert found == pytest.approx(np.exp(-rate / frequency * angle), abs=1e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_undamped_pair_keeps_its_energy(integrator):
    belt = replace(FREE, damping=0.0, shear_damping=0.0)
    assert pair_restitution(belt, integrator, 2.5e-5) == pytest.approx(1.0, abs=2e-3)
    assert pair_restitution(belt, integrator, 2.5e-6) == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_restitution_error_is_of_first_order_in_the_time_step(integrator):
    """The damping force jumps where a contact begins and ends, which no integrator resolves."""
    exact = damped_restitution(DAMPING, 2 * STIFFNESS / MASS)
    errors = []
    for time_step in (2.5e-5, 2.5e-6):
        steps = time_step * (1 + 0.03 * np.arange(6))
        errors.append(max(abs(pair_restitution(FREE, integrator, dt) - exact) for dt in steps))
    assert 1e-3 < errors[0] < 0.03
    assert 3.0 < errors[0] / errors[1] < 30.0


@pytest.mark.parametrize("damping_mass", ["own", "reduced"])
@pytest.mark.parametrize("partner", ["below", "centred", "obstacle"])
def test_restitution_against_an_infinite_mass(partner, damping_mass):
    belt = replace(FREE, damping_mass=damping_mass)
    height = 0.5 * DIAMETER
    if partner == "obstacle":
        belt = replace(belt, obstacle=1.5 * DIAMETER, amplitude=(0.0, 8 * DIAMETER))
        height = 8 * DIAMETER + 1.25 * DIAMETER
    else:
        belt = replace(belt, belt_ghost=partner)
        height += 0.5 * DIAMETER if partner == "centred" else 0.0
    diameter, mass = equal(1)
    start = np.array([[10 * DIAMETER, height + 1e-8]])
    approach = np.array([[0.0, -0.1]])
    _, velocity = run(belt, diameter, mass, start, approach, 1e-6, 1500)
    expected = damped_restitution(DAMPING / 2, STIFFNESS / MASS)
    assert velocity[-1, 0] == pytest.approx([0.0, 0.1 * expected], abs=1e-4)


# Single forces by hand


def test_pair_force_by_hand():
    """Two unequal beads along (0.6, 0.8): each has its own damping, the spring is reciprocal."""
    diameter, mass = DIAMETER * np.array([1.0, 1.5]), MASS * np.array([1.0, 2.25])
    normal, shear = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    position = np.array([[0.0, 0.01], [0.0, 0.01]]) + np.outer([0, 1.2e-3], normal)
    velocity = np.array([0.03 * normal + 0.02 * shear, [0.0, 0.0]])
    spring = STIFFNESS * 0.05e-3
    for damping_mass, damped in (("own", mass), ("reduced", np.full(2, MASS * 2.25 / 3.25))):
        belt = replace(BELT, damping_mass=damping_mass, shear_damping=0.4 * DAMPING)
        found = forces(belt, diameter, mass, position, velocity, 0.0)
        damping = DAMPING * damped
        on_first = -(spring + 0.03 * damping[0]) * normal - 0.02 * 0.4 * damping[0] * shear
        on_second = (spring + 0.03 * damping[1]) * normal + 0.02 * 0.4 * damping[1] * shear
        assert found == pytest.approx(np.array([on_first, on_second]), rel=1e-9)


@pytest.mark.parametrize(("attraction", "pull"), [("kept", 1.0), ("clipped", 0.0)])
def test_clipping_takes_the_pull_and_leaves_the_shear(attraction, pull):
    diameter, mass = equal(2)
    belt = replace(BELT, attraction=attraction)
    position = np.array([[0.0, 0.01], [0.99e-3, 0.01]])
    velocity = np.array([[-0.2, 0.0], [0.2, 0.1]])
    expected = pull * (DAMPING * MASS * 0.4 - STIFFNESS * 0.01e-3)
    found = forces(belt, diameter, mass, position, velocity, 0.0)
    assert found[0] == pytest.approx([expected, DAMPING * MASS * 0.1], rel=1e-9, abs=1e-18)
    assert found[1] == pytest.approx(-found[0], rel=1e-12, abs=1e-18)


def test_ghost_touches_half_a_diameter_above_the_line_or_above_its_own_radius():
    diameter = 1.2 * DIAMETER
    for ghost, height in (("below", 0.6 * DIAMETER), ("centred", 1.1 * DIAMETER)):
        belt = shaken(20.0, 1.0, 1.0, belt_ghost=ghost)
        place, motion = belt_motion(belt, 0.003)
        above = np.array([0.0, place[1] + height])
        lift = np.array([0.0, 1e-5])
        assert not belt_force(belt, diameter, MASS, above + lift, motion, 0.003).any()
        found = belt_force(belt, diameter, MASS, above - lift, motion, 0.003)
        assert found == pytest.approx([0.0, STIFFNESS * 1e-5], rel=1e-6)
        slower = motion - np.array([0.01, 0.0])
        found = belt_force(belt, diameter, MASS, above - lift, slower, 0.003)
        assert found[0] == pytest.approx(DAMPING * MASS * 0.01, rel=1e-9)


def test_both_ghosts_give_the_same_motion_half_a_diameter_apart():
    position, velocity = crowd()
    position = position - np.array([0.0, 9.3 * DIAMETER])
    diameter, mass = unequal(12)
    below = run(shaken(20.0, 1.0, 1.0), diameter, mass, position, velocity, 2.5e-5, 100)
    lifted = position + np.array([0.0, 0.5 * DIAMETER])
    centred = shaken(20.0, 1.0, 1.0, belt_ghost="centred")
    centred = run(centred, diameter, mass, lifted, velocity, 2.5e-5, 100)
    assert np.abs(below[1] - velocity).max() > 0.01
    assert centred[1] == pytest.approx(below[1], abs=1e-9)


def test_obstacle_stays_where_it_is_and_repeats_with_the_cell():
    belt = shaken(20.0, 1.0, 1.0, obstacle=1.5 * DIAMETER)
    touch = 0.5 * (1.2 + 1.5) * DIAMETER
    beside = np.array([0.5 * belt.width + touch - 1e-5, DIAMETER])
    for shift in (0.0, 3 * belt.width):
        place = beside + np.array([shift, 0.0])
        found = obstacle_force(belt, 1.2 * DIAMETER, MASS, place, np.zeros(2))
        assert found == pytest.approx([STIFFNESS * 1e-5, 0.0], rel=1e-6, abs=1e-15)
    no_obstacle = replace(belt, obstacle=0.0)
    assert not obstacle_force(no_obstacle, 1.2 * DIAMETER, MASS, beside, np.zeros(2)).any()


def test_belt_moves_along_its_angle_with_the_derivative_of_its_position():
    belt = shaken(20.0, 0.5, 1.0, phase=0.7)
    time, delta = 0.011, 1e-7
    (before, _), (after, _) = belt_motion(belt, time - delta), belt_motion(belt, time + delta)
    place, motion = belt_motion(belt, time)
    assert motion == pytest.approx((after - before) / (2 * delta), rel=1e-7)
    assert place[1] / place[0] == pytest.approx(2.0)
    assert belt_motion(belt, 0.0)[0][1] == pytest.approx(DIAMETER * np.sin(0.7))


# Single beads


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_held_bead_relaxes_to_the_belt(integrator):
    diameter, mass = equal(1)
    position = np.array([[0.0, 0.5 * DIAMETER - MASS * GRAVITY / STIFFNESS]])
    velocity = np.array([[0.3, 0.0]])
    time_step, steps = 2.5e-5, 320
    _, found = run(BELT, diameter, mass, position, velocity, time_step, steps, integrator)
    expected = 0.3 * np.exp(-DAMPING * time_step * np.arange(steps + 1))
    assert found[:, 0, 0] == pytest.approx(expected, abs=1e-4 * 0.3)
    assert np.abs(found[:, 0, 1]).max() < 1e-9


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_held_bead_is_dragged_by_a_belt_that_moves_sideways(integrator):
    """v' = -gamma_s (v - A w cos wt), v = 0 at first: a lagging oscillation and a transient."""
    belt = shaken(20.0, 1.0, 0.0)
    diameter, mass = equal(1)
    position = np.array([[0.0, 0.5 * DIAMETER - MASS * GRAVITY / STIFFNESS]])
    time_step, steps = 2.5e-5, 2000
    _, found = run(belt, diameter, mass, position, np.zeros((1, 2)), time_step, steps, integrator)
    time, rate = time_step * np.arange(steps + 1), belt.angular_frequency
    response = DAMPING / (DAMPING + 1j * rate)
    speed = DIAMETER * rate
    expected = speed * (np.real(response * np.exp(1j * rate * time)))
    expected -= speed * np.real(response) * np.exp(-DAMPING * time)
    assert found[:, 0, 0] == pytest.approx(expected, abs=1e-4 * speed)


def test_bead_below_take_off_stays_on_the_belt_and_goes_nowhere():
    """At Gamma < 1 a bead that starts with the belt's motion oscillates about its place."""
    belt = shaken(12.0, 1.0, 1.0)
    diameter, mass = equal(1)
    position = np.array([[0.0, 0.5 * DIAMETER - MASS * GRAVITY / STIFFNESS]])
    velocity = belt_motion(belt, 0.0)[1][None]
    per_cycle = 2000
    positions, _ = run(belt, diameter, mass, position, velocity, 1 / 24000, 3 * per_cycle)
    drift = positions[3 * per_cycle, 0, 0] - positions[2 * per_cycle, 0, 0]
    assert abs(drift) < 1e-3 * DIAMETER


def test_bead_falls_freely_off_the_belt():
    diameter, mass = equal(1)
    start = np.array([[0.0, 9e-3]])
    positions, _ = run(BELT, diameter, mass, start, np.array([[0.1, 0.0]]), 2.5e-5, 400)
    assert positions[-1, 0] == pytest.approx([0.1 * 0.01, 9e-3 - 0.5 * GRAVITY * 0.01**2])


# Many beads


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("shear_damping", [0.0, DAMPING])
def test_reduced_mass_conserves_the_momentum_of_free_beads(shear_damping, integrator):
    position, velocity = crowd()
    diameter, mass = unequal(12)
    belt = replace(FREE, shear_damping=shear_damping, damping_mass="reduced")
    _, found = run(belt, diameter, mass, position, velocity, 2.5e-5, 100, integrator)
    momentum = np.einsum("i,tik->tk", mass, found)
    scale = mass.sum() * 0.05
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * scale
    _, found = run(
        replace(belt, damping_mass="own"), diameter, mass, position, velocity, 2.5e-5, 100
    )
    momentum = np.einsum("i,tik->tk", mass, found)
    assert np.abs(momentum - momentum[0]).max() > 1e-3 * scale


def test_a_belt_without_shear_damping_gives_no_sideways_momentum():
    position, velocity = crowd()
    diameter, mass = unequal(12)
    belt = shaken(20.0, 1.0, 1.0, shear_damping=0.0, damping_mass="reduced")
    near = position - np.array([0.0, 9.3 * DIAMETER])
    _, found = run(belt, diameter, mass, near, velocity, 2.5e-5, 150)
    momentum = np.einsum("i,tik->tk", mass, found)
    assert np.abs(momentum[:, 0] - momentum[0, 0]).max() < 1e-12 * mass.sum() * 0.05
    assert np.abs(momentum[:, 1] - momentum[0, 1]).max() > 1e-3 * mass.sum() * 0.05


def test_beads_across_the_edge_feel_the_same_forces():
    position, velocity = crowd()
    diameter, mass = unequal(12)
    expected = forces(BELT, diameter, mass, position, velocity, 0.0)
    assert np.count_nonzero(expected) > 10
    for shift in (0.5 * BELT.width, 19.3 * DIAMETER, -7 * BELT.width):
        moved = position + np.array([shift, 0.0])
        moved[::2, 0] += 2 * BELT.width
        found = forces(BELT, diameter, mass, moved, velocity, 0.0)
        assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_gear_and_verlet_agree_as_the_time_step_falls():
    position, velocity = crowd()
    diameter, mass = unequal(12)
    near = position - np.array([0.0, 9.3 * DIAMETER])
    differences = []
    for time_step, steps in ((2e-5, 50), (2e-6, 500)):
        ends = [
            run(shaken(20.0, 1.0, 1.0), diameter, mass, near, velocity, time_step, steps, name)[0][
                -1
            ]
            for name in INTEGRATORS
        ]
        differences.append(np.abs(ends[0] - ends[1]).max())
    assert differences[0] < 1e-2 * DIAMETER
    assert differences[1] < 0.2 * differences[0]
