"""What the slow reference says of single beads, and its integrator, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.reference.belt import Belt, belt_force, belt_motion, forces
from tests.engine.reference.integrators import GEAR_COEFFICIENTS, gear_step
from tests.engine_motion.helpers import BEAD as DIAMETER
from tests.engine_motion.helpers import BEAD_GRAVITY as GRAVITY
from tests.engine_motion.helpers import BEAD_MASS as MASS
from tests.engine_motion.helpers import DAMPING
from tests.engine_motion.helpers import YOUNG as STIFFNESS

BELT = Belt(20 * DIAMETER, DIAMETER, STIFFNESS, DAMPING, DAMPING, GRAVITY)


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
    diameter, mass = np.full(2, DIAMETER), np.full(2, MASS)
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
        rate = 2 * np.pi * 20.0
        belt = replace(
            BELT, amplitude=(DIAMETER, DIAMETER), angular_frequency=rate, belt_ghost=ghost
        )
        place, motion = belt_motion(belt, 0.003)
        above = np.array([0.0, place[1] + height])
        lift = np.array([0.0, 1e-5])
        assert not belt_force(belt, diameter, MASS, above + lift, motion, 0.003).any()
        found = belt_force(belt, diameter, MASS, above - lift, motion, 0.003)
        assert found == pytest.approx([0.0, STIFFNESS * 1e-5], rel=1e-6)
        slower = motion - np.array([0.01, 0.0])
        found = belt_force(belt, diameter, MASS, above - lift, slower, 0.003)
        assert found[0] == pytest.approx(DAMPING * MASS * 0.01, rel=1e-9)


@pytest.mark.parametrize(
    ("ghost_mass", "counted"), [(np.inf, 1.0), (MASS, 1 / (1 + 1.44)), (1e-3 * MASS, 1e-3 / 1.441)]
)
def test_the_mass_of_the_ghost_damps_with_the_reduced_mass_alone(ghost_mass, counted):
    mass = 1.44 * MASS
    place = np.array([0.0, 0.6 * DIAMETER - 1e-5])
    for damping_mass, share in (("own", 1.0), ("reduced", counted)):
        belt = replace(BELT, damping_mass=damping_mass, ghost_mass=ghost_mass)
        found = belt_force(belt, 1.2 * DIAMETER, mass, place, np.array([0.01, -0.02]), 0.0)
        drag, push = DAMPING * share * mass * np.array([0.01, 0.02])
        assert found == pytest.approx([-drag, STIFFNESS * 1e-5 + push], rel=1e-6)


@pytest.mark.parametrize("order", [3, 4, 5])
def test_gear_corrects_each_row_by_its_share_of_the_error(order):
    def pushed(x, v, t):
        return np.array([2.0 / 0.1**2])

    found = gear_step(pushed, np.zeros((order + 1, 1)), 0.0, 0.1)[:, 0]
    assert found == pytest.approx(GEAR_COEFFICIENTS[order], rel=1e-14)
    # A force that does not depend on the state leaves no error to the second correction.
    again = gear_step(pushed, np.zeros((order + 1, 1)), 0.0, 0.1, corrections=2)[:, 0]
    assert again == pytest.approx(found, rel=1e-14)


def test_a_second_correction_sees_the_first():
    """x'' = -x' from x' = 1: each correction takes the speed that it finds."""

    def dragged(x, v, t):
        return -v

    start = np.array([[0.0], [0.1], [0.0], [0.0]])
    speed, acceleration = 0.1, 0.0
    for corrections in (1, 2):
        error = -0.5 * 0.1 * speed - acceleration
        speed, acceleration = speed + 5 / 6 * error, acceleration + error
        found = gear_step(dragged, start, 0.0, 0.1, corrections)[:, 0]
        assert found[1:3] == pytest.approx([speed, acceleration], rel=1e-14)


@pytest.mark.parametrize("corrections", [1, 2])
@pytest.mark.parametrize("order", [3, 4, 5])
def test_gear_follows_a_polynomial_of_its_order_exactly(order, corrections):
    def jerky(x, v, t):
        return np.array([order * (order - 1) * t ** (order - 2) - 6.0 * t])

    scaled = np.zeros((order + 1, 1))
    scaled[1], scaled[3] = 2.0, -1.0
    scaled[order] += 1.0
    scaled *= 0.1 ** np.arange(order + 1)[:, None]
    for number in range(30):
        scaled = gear_step(jerky, scaled, 0.1 * number, 0.1, corrections)
    assert scaled[0, 0] == pytest.approx(3.0**order - 3.0**3 + 2 * 3.0, rel=1e-12)
