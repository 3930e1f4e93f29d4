"""Orientations: constant spins, composition, unit length; the motion needs none (claim W4)."""

import numpy as np
import pytest

from sim.engine.dynamics import spheres as engine
from sim.engine.dynamics.spheres import unrotated_orientations
from tests.engine_motion.helpers import RADIUS, compiled, lattice, weight_components
from tests.engine_motion.spheres import SphereMotion

rotate = compiled(engine.rotate)


def turn(orientation, spin, time_step: float) -> None:
    """Turn orientations (4, N) of spheres of many sizes by spins (N, 3) during one step."""
    radius = RADIUS * np.linspace(0.5, 1.5, len(spin))
    rotate(orientation, radius * np.transpose(spin), radius, time_step, 0, len(spin))


def turn_steadily(spin, steps: int, angle: float) -> np.ndarray:
    """Orientations after a total rotation by ``angle`` about constant spins (N, 3)."""
    spin = np.atleast_2d(np.array(spin, float))
    orientation = unrotated_orientations(len(spin))
    time_step = angle / np.linalg.norm(spin[0]) / steps
    for _ in range(steps):
        turn(orientation, spin, time_step)
    return orientation.T


def exact(spin, angle: float) -> np.ndarray:
    axis = np.array(spin, float) / np.linalg.norm(spin)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


@pytest.mark.parametrize("spin", [(0, 0, 3.0), (40.0, 0, 0), (0, -5.0, 0), (1.0, -2.0, 2.0)])
def test_constant_spin_gives_the_exact_rotation(spin):
    """Half a turn in steps as in a flow (0.1 degrees): right to third order in the step."""
    orientation_now = turn_steadily(spin, 1800, np.pi)[0]
    assert orientation_now == pytest.approx(exact(spin, np.pi), abs=1e-6)
    coarse = np.abs(turn_steadily(spin, 90, np.pi)[0] - exact(spin, np.pi)).max()
    fine = np.abs(turn_steadily(spin, 180, np.pi)[0] - exact(spin, np.pi)).max()
    assert coarse / fine == pytest.approx(4.0, rel=0.05)


def test_spins_are_along_the_axes_of_the_laboratory():
    """A quarter turn about x, then one about z, takes the body's y axis to the laboratory's z."""
    orientation = np.ascontiguousarray(turn_steadily((1.0, 0, 0), 5000, np.pi / 2).T)
    for _ in range(5000):
        turn(orientation, np.array([[0.0, 0.0, 1.0]]), np.pi / 10_000)
    w, x, y, z = orientation[:, 0]
    images_of_y = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    assert images_of_y == pytest.approx([0.0, 0.0, 1.0], abs=1e-5)
    images_of_x = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    assert images_of_x == pytest.approx([0.0, 1.0, 0.0], abs=1e-5)


def test_trajectories_do_not_depend_on_orientations_by_a_single_bit():
    rng = np.random.default_rng(9)
    position = lattice((4, 4, 4), 1.96 * RADIUS, 0.05, rng)
    start = position, rng.normal(0, 0.05, position.shape), rng.normal(0, 50, position.shape)
    options = {"box": (4 * 2 * RADIUS,) * 2, "gravity": weight_components(17.0)}
    oriented = SphereMotion(*start, orientations=True, **options).run(2000)
    unoriented = SphereMotion(*start, orientations=False, **options).run(2000)
    for name in ("position", "velocity", "spin", "force", "torque"):
        assert np.array_equal(getattr(oriented, name), getattr(unoriented, name))
    assert np.array_equal(oriented.flow.sums, unoriented.flow.sums)
    assert len(unoriented.orientation) == 0
    assert np.abs(oriented.orientation[:, 1:]).max() > 0.1
    assert np.linalg.norm(oriented.orientation, axis=1) == pytest.approx(1.0, abs=1e-14)
