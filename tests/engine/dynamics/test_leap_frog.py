"""The leap-frog loop: order, sums over steps, how it stops, and orientations (claim W4)."""

import numpy as np
import pytest

from sim.engine.dynamics import spheres as engine
from sim.engine.dynamics.cells import NOT_FINITE, OK, OVERLAP
from sim.engine.dynamics.spheres import unrotated_orientations
from sim.engine.systems import leap_frog
from tests.engine_motion.helpers import (
    GRAVITY,
    MASS,
    RADIUS,
    compiled,
    lattice,
    sphere_law,
    weight_components,
)
from tests.engine_motion.spheres import SphereMotion


def bounce_error(steps_per_collision: float) -> float:
    """Largest error (in amplitudes) of an elastic sphere that swings on the plane about its rest.

    It never leaves the plane, so the force is smooth and the exact solution a cosine.
    """
    law = sphere_law(restitution=1.0, friction=0.0)
    frequency = np.sqrt(law.loading / MASS)
    indentation, amplitude = MASS * GRAVITY / law.loading, 0.5 * MASS * GRAVITY / law.loading
    options = {"law": law, "gravity": (0.0, 0.0, -GRAVITY)}
    motion = SphereMotion(
        [[0, 0, RADIUS - indentation + amplitude]],
        [[0, 0, 0]],
        steps_per_collision=steps_per_collision,
        **options,
    )
    half_step_ago = -0.5 * motion.time_step
    motion.spheres.velocity[2, 0] = -amplitude * frequency * np.sin(frequency * half_step_ago)
    worst = 0.0
    for step in range(1, int(5 * steps_per_collision)):
        motion.run(1)
        swing = motion.position[0, 2] - RADIUS + indentation
        exact = amplitude * np.cos(frequency * step * motion.time_step)
        worst = max(worst, abs(swing - exact) / amplitude)
    return worst


def test_leap_frog_is_of_second_order_on_a_smooth_force():
    errors = [bounce_error(steps) for steps in (20, 40, 80)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    assert errors[1] < 2e-2


def test_free_flight_is_exact_with_the_velocity_half_a_step_behind():
    gravity = weight_components(17.0)
    motion = SphereMotion([[0, 0, 50 * RADIUS]], [[0.1, 0.05, 0.2]], gravity=gravity).run(1000)
    time = 1000 * motion.time_step
    speed = np.array([0.1, 0.05, 0.2])
    assert motion.velocity[0] == pytest.approx(speed + time * np.array(gravity), rel=1e-12)
    displacement = speed * time + 0.5 * np.array(gravity) * time * (time + motion.time_step)
    start = np.array([0, 0, 50 * RADIUS])
    assert motion.position[0] - start == pytest.approx(displacement, rel=1e-10)


def dense_flow(**options) -> SphereMotion:
    rng = np.random.default_rng(2)
    position = lattice((4, 4, 3), 1.97 * RADIUS, 0.02, rng)
    velocity = rng.normal(0, 0.05, position.shape)
    velocity[:, 0] += 0.3
    options = {"box": (8 * RADIUS,) * 2, "gravity": weight_components(17.0)} | options
    return SphereMotion(position, velocity, **options)


def test_impulses_of_the_plane_and_gravity_are_the_change_of_momentum():
    motion = dense_flow()
    before = motion.momentum()
    motion.run(777)
    sums, mass = motion.flow.sums, motion.mass.sum()
    time = 777 * motion.time_step
    plane = motion.time_step * np.array([sums[leap_frog.PLANE_X], sums[leap_frog.PLANE_Z]])
    weight = mass * time * np.array(motion.gravity)[[0, 2]]
    change = (motion.momentum() - before)[[0, 2]]
    assert plane + weight == pytest.approx(change, abs=1e-12 * mass * GRAVITY * time)
    assert sums[leap_frog.STEPS] == 777


def test_an_overlap_beyond_the_limit_stops_at_its_step():
    motion = dense_flow(overlap_limit=0.5).run(200)
    limit = 0.999 * motion.flow.sums[leap_frog.LARGEST]
    stopped_flow = dense_flow(overlap_limit=limit)
    assert stopped_flow.advance(200) == OVERLAP
    assert stopped_flow.flow.sums[leap_frog.LARGEST] >= limit
    step = int(stopped_flow.flow.step[0])
    before = dense_flow(overlap_limit=limit)
    assert before.advance(step - 1) == OK
    assert before.flow.sums[leap_frog.LARGEST] < limit


@pytest.mark.parametrize("array", ["position", "velocity", "rim"])
def test_a_value_that_is_not_finite_stops_the_run(array):
    for bad in (np.nan, np.inf):
        motion = dense_flow().run(5)
        getattr(motion.spheres, array)[1, 7] = bad
        assert motion.advance(200) in (NOT_FINITE, OVERLAP)
        assert motion.flow.step[0] < 200


def test_short_flow_converges_with_the_time_step():
    """Positions after two collision times of a dense flow, before chaos takes over."""
    law = sphere_law()
    ends = {}
    for steps in (20, 40, 80, 640):
        motion = dense_flow(law=law, steps_per_collision=steps)
        ends[steps] = motion.run(2 * steps).velocity.copy()
    errors = [np.abs(ends[steps] - ends[640]).mean() / 0.05 for steps in (20, 40, 80)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[0] < 0.1
    assert errors[2] < 0.02


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
