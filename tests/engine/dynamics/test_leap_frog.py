"""The leap-frog loop: order, sums over steps, and how it stops."""

import numpy as np
import pytest

from sim.engine.dynamics.cells import NOT_FINITE, OK, OVERLAP
from sim.engine.systems import leap_frog
from tests.engine_motion.helpers import (
    GRAVITY,
    MASS,
    RADIUS,
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
