"""Leap-frog: order, sums over steps, how it stops, orientations (claim W4); the beads' schemes."""

from math import factorial

import numpy as np
import pytest

from sim.engine.dynamics.cells import NOT_FINITE, OK, OVERLAP
from sim.engine.dynamics.disks import CORRECTORS, TERMS, Gear, Verlet, flush, rescale_terms
from sim.engine.systems import leap_frog
from tests.engine.reference.belt import GEAR_COEFFICIENTS
from tests.engine_motion.helpers import (
    GRAVITY,
    MASS,
    RADIUS,
    Oscillator,
    damped_oscillation,
    gear,
    lattice,
    sphere_law,
    weight_components,
)
from tests.engine_motion.motion import SphereMotion


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
    weight = mass * time * np.array(motion.drive.gravity)[[0, 2]]
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


def turn_steadily(spin, steps: int, angle: float) -> SphereMotion:
    """A free sphere after a total rotation by ``angle`` about a constant spin (1/s)."""
    time_step = angle / np.linalg.norm(spin) / steps
    options = {"orientations": True, "time_step": time_step, "radius": 0.7 * RADIUS}
    return SphereMotion([[0, 0, 50 * RADIUS]], np.zeros((1, 3)), [spin], **options).run(steps)


def exact(spin, angle: float) -> np.ndarray:
    axis = np.array(spin, float) / np.linalg.norm(spin)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


@pytest.mark.parametrize("spin", [(0, 0, 3.0), (40.0, 0, 0), (0, -5.0, 0), (1.0, -2.0, 2.0)])
def test_constant_spin_gives_the_exact_rotation(spin):
    """Half a turn in steps as in a flow (0.1 degrees): right to third order in the step."""
    found = [turn_steadily(spin, steps, np.pi).orientation[0] for steps in (90, 180, 1800)]
    errors = [np.abs(one - exact(spin, np.pi)).max() for one in found]
    assert errors[2] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_spins_are_along_the_axes_of_the_laboratory():
    """A quarter turn about x, then one about z, takes the body's y axis to the laboratory's z."""
    motion = turn_steadily((1.0, 0, 0), 5000, np.pi / 2)
    motion.spheres.rim[:] = np.array([[0.0], [0.0], [1.0]]) * motion.spheres.radius
    w, x, y, z = motion.run(5000).orientation[0]
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


RATE, END = 0.3, 10.0
OSCILLATOR = Oscillator(1.0, 2 * RATE)


def derivatives(time: float) -> np.ndarray:
    """Position of x'' = -x - 2 RATE x', x(0) = 1, x'(0) = 0, and its first five derivatives."""
    root = complex(-RATE, np.sqrt(1 - RATE**2))
    weight = -root.conjugate() / (root - root.conjugate())
    return np.array([2 * (weight * root**k * np.exp(root * time)).real for k in range(TERMS)])


def oscillate(integrator, steps: int, known_terms: int = TERMS, corrections: int = 1):
    """Taylor terms (6,) at END from an exact start that knows some derivatives."""
    step = END / steps
    scale = np.array([step**k / factorial(k) for k in range(TERMS)])
    taylor = np.zeros((TERMS, 2, 1))
    taylor[:known_terms, :, 0] = (derivatives(0.0) * scale)[:known_terms, None]
    damped_oscillation(integrator(step), taylor, OSCILLATOR, steps, corrections)
    return taylor[:, 0, 0] / scale


def orders(integrator, known_terms: int = TERMS, corrections: int = 1) -> np.ndarray:
    """Observed orders of position and velocity between 200, 400 and 800 steps."""
    exact = derivatives(END)[:2]
    errors = [
        oscillate(integrator, steps, known_terms, corrections)[:2] - exact
        for steps in (200, 400, 800)
    ]
    return np.log2(np.abs(np.array(errors[:-1]) / np.array(errors[1:])))


@pytest.mark.parametrize("corrections", [1, 2])
@pytest.mark.parametrize("order", CORRECTORS)
def test_gear_is_of_the_order_that_it_says(order, corrections):
    assert orders(gear(order), order + 1, corrections).min() == pytest.approx(order, abs=0.2)
    assert not oscillate(gear(order), 50, order + 1)[order + 1 :].any()


def test_gear_started_from_the_acceleration_alone_is_of_second_order_or_better():
    assert orders(Gear, known_terms=3).min() > 1.9


def test_verlet_is_of_second_order_without_damping_and_stays_so_with_it():
    """The damping sees a predicted velocity, with an error of second order in the acceleration."""
    assert orders(Verlet).min() > 1.8
    assert abs(oscillate(Verlet, 800)[0] - derivatives(END)[0]) < 1e-4


@pytest.mark.parametrize("order", GEAR_COEFFICIENTS)
def test_corrector_coefficients_are_those_for_forces_that_depend_on_the_velocity(order):
    padded_coefficients = (*GEAR_COEFFICIENTS[order], *[0.0] * (TERMS - order - 1))
    assert CORRECTORS[order] == pytest.approx(padded_coefficients, rel=1e-15)


@pytest.mark.parametrize("integrator", [Gear, Verlet])
def test_a_new_time_step_goes_on_along_the_same_motion(integrator):
    """Half the way with one step, half with another three times as long."""
    short, long = END / 6000, END / 2000
    scale = np.array([short**k / factorial(k) for k in range(TERMS)])
    taylor = np.zeros((TERMS, 2, 1))
    taylor[:, :, 0] = (derivatives(0.0) * scale)[:, None]
    damped_oscillation(integrator(short), taylor, OSCILLATOR, 3000, 1)
    before = taylor[:3, 0, 0] / [1.0, short, short**2]
    rescale_terms(taylor, short, long)
    assert taylor[:3, 0, 0] / [1.0, long, long**2] == pytest.approx(before, rel=1e-12)
    damped_oscillation(integrator(long), taylor, OSCILLATOR, 1000, 1)
    assert taylor[0, 0, 0] == pytest.approx(derivatives(END)[0], abs=2e-5)


def test_flush_takes_subnormal_terms_only():
    taylor = np.full((TERMS, 2, 3), 1e-150)
    taylor[:, :, 1] = 1e-310
    flush(taylor)
    assert (taylor[2:, :, 1] == 0.0).all() and (taylor[:2, :, 1] > 0.0).all()
    assert (taylor[:, :, [0, 2]] == 1e-150).all()
