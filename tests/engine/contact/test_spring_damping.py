"""The law of the beads: single forces by hand, readings, and the slow reference."""

import itertools

import numpy as np
import pytest

from tests.engine.reference.belt import Belt, contact_force
from tests.engine_motion.helpers import BEAD_MASS, DAMPING, YOUNG, bead_law, disk_forces

READINGS = list(itertools.product(("own", "reduced"), ("kept", "clipped")))


def force_on(law, overlap, normal, velocity, mass=BEAD_MASS, partner=BEAD_MASS) -> np.ndarray:
    """Force (2,) on a disk in one contact; an infinite ``partner`` mass is a wall."""
    arrays = np.array([overlap]), np.array([normal], float), np.array([velocity], float)
    return disk_forces(law, *arrays, np.array([mass]), np.array([1.0 / partner]))[0]


def random_contacts(count: int = 500):
    """Overlaps, normals, velocities, masses and partners' masses of random contacts."""
    rng = np.random.default_rng(2)
    angle = rng.uniform(0, 2 * np.pi, count)
    return (
        rng.uniform(0, 1e-4, count),
        np.stack([np.cos(angle), np.sin(angle)], axis=1),
        rng.normal(0, 0.1, (count, 2)),
        BEAD_MASS * rng.uniform(0.25, 2.25, count),
        BEAD_MASS * rng.uniform(0.25, 2.25, count),
    )


def test_force_is_spring_damping_and_drag_by_hand():
    """Normal (0.6, 0.8), approach 0.03 and slip 0.02 m/s: the three terms one by one."""
    law = bead_law(shear_damping=0.4 * DAMPING)
    normal, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    force = force_on(law, 5e-5, normal, 0.03 * normal + 0.02 * across, mass=2 * BEAD_MASS)
    push = YOUNG * 5e-5 + DAMPING * 2 * BEAD_MASS * 0.03
    drag = 0.4 * DAMPING * 2 * BEAD_MASS * 0.02
    assert force == pytest.approx(-push * normal - drag * across, rel=1e-12)


@pytest.mark.parametrize(("damping_mass", "attraction"), READINGS)
def test_law_equals_the_reference(damping_mass, attraction):
    law = bead_law(damping_mass=damping_mass, attraction=attraction)
    slow = Belt(20e-3, 1e-3, YOUNG, DAMPING, DAMPING, attraction=attraction)
    overlap, normal, velocity, mass, partner = random_contacts()
    force = disk_forces(law, overlap, normal, velocity, mass, 1.0 / partner)
    damping_masses = mass if damping_mass == "own" else mass * partner / (mass + partner)
    reach = 1e-3
    for k in range(overlap.size):
        separation = (reach - overlap[k]) * normal[k]
        expected = contact_force(slow, separation, velocity[k], reach, damping_masses[k])
        assert force[k] == pytest.approx(expected, abs=1e-11 * YOUNG * 1e-4)


@pytest.mark.parametrize("attraction", ["kept", "clipped"])
def test_only_the_reduced_mass_is_reciprocal(attraction):
    overlap, normal, velocity, mass, partner = random_contacts()
    sums = {}
    for reading in ("own", "reduced"):
        law = bead_law(damping_mass=reading, attraction=attraction)
        here = disk_forces(law, overlap, normal, velocity, mass, 1.0 / partner)
        there = disk_forces(law, overlap, -normal, -velocity, partner, 1.0 / mass)
        sums[reading] = np.abs(here + there).max() / np.abs(here).max()
    assert sums["reduced"] < 1e-14
    assert sums["own"] > 0.1


def test_both_masses_agree_against_a_wall():
    arguments = (3e-5, (0.0, -1.0), (0.1, -0.2), 1.7 * BEAD_MASS, np.inf)
    own = force_on(bead_law(), *arguments)
    assert force_on(bead_law(damping_mass="reduced"), *arguments) == pytest.approx(own, rel=1e-14)


def test_clipping_takes_the_pull_and_leaves_drag_and_push():
    receding, approaching = (-0.4, 0.1), (0.4, 0.1)
    kept, clipped = bead_law(), bead_law(attraction="clipped")
    pull, free = (force_on(law, 1e-6, (1.0, 0.0), receding) for law in (kept, clipped))
    assert pull[0] > 0.0 and free[0] == 0.0
    assert free[1] == pull[1] == pytest.approx(-DAMPING * BEAD_MASS * 0.1, rel=1e-12)
    pushes = [force_on(law, 1e-6, (1.0, 0.0), approaching) for law in (kept, clipped)]
    assert np.array_equal(*pushes) and pushes[0][0] < 0.0


@pytest.mark.parametrize(("damping_mass", "attraction"), READINGS)
def test_damping_takes_energy_in_every_contact(damping_mass, attraction):
    """Beside the spring, the force on a disk works against its motion relative to the partner."""
    law = bead_law(damping_mass=damping_mass, attraction=attraction)
    overlap, normal, velocity, mass, partner = random_contacts()
    force = disk_forces(law, overlap, normal, velocity, mass, 1.0 / partner)
    dissipative = force + YOUNG * overlap[:, None] * normal
    assert ((dissipative * velocity).sum(axis=1) < 0.0).all()


def test_no_shear_damping_means_no_force_across_the_normal():
    law = bead_law(shear_damping=0.0)
    overlap, normal, velocity, mass, partner = random_contacts()
    force = disk_forces(law, overlap, normal, velocity, mass, 1.0 / partner)
    across = force[:, 1] * normal[:, 0] - force[:, 0] * normal[:, 1]
    assert np.abs(across).max() < 1e-15 * np.abs(force).max() * 10
