"""Spheres on the plane: exact results of single contacts (claim W1), and sums over many."""

import numpy as np
import pytest

from sim.engine.dynamics.spheres import BLOCK
from sim.engine.systems import leap_frog
from tests.engine_motion.helpers import (
    GRAVITY,
    LAWS,
    MASS,
    RADIUS,
    collision_time,
    sphere_law,
    weight_components,
)
from tests.engine_motion.spheres import SphereMotion


def drop_sphere(law, speed: float, gap: float, slide: float = 0.0) -> SphereMotion:
    """A sphere after its impact on the plane at ``speed``, met ``gap`` steps after the start."""
    height = RADIUS + gap * speed * collision_time(law) / 40
    return SphereMotion([[0, 0, height]], [[slide, 0, -speed]], law=law).run(120)


def pressed_sphere(law, angle: float, speed: float, spin: float) -> SphereMotion:
    """A sphere pressed into the plane by its weight, with a speed along x and a spin about y."""
    gravity = weight_components(angle)
    height = RADIUS + MASS * gravity[2] / law.loading
    start = [[0, 0, height]], [[speed, 0, 0]], [[0, spin, 0]]
    return SphereMotion(*start, law=law, gravity=gravity)


def surface_velocity(motion: SphereMotion) -> float:
    """Velocity along x of the sphere's surface at the plane."""
    return float(motion.velocity[0, 0] - RADIUS * motion.spin[0, 1])


@pytest.mark.parametrize("readings", LAWS)
def test_sliding_sphere_slows_by_friction_until_it_rolls_at_five_sevenths(readings):
    law, speed = sphere_law(**readings), 0.05
    motion = pressed_sphere(law, 0.0, speed, 0.0)
    steps = int(0.9 * 2 / 7 * speed / (0.4 * GRAVITY) / motion.time_step)
    motion.run(steps)
    deceleration = (speed - motion.velocity[0, 0]) / (steps * motion.time_step)
    assert deceleration == pytest.approx(0.4 * GRAVITY, rel=1e-9)
    motion.run(steps)
    velocity, surface = motion.velocity[0, 0], RADIUS * motion.spin[0, 1]
    assert velocity + 0.4 * surface == pytest.approx(speed, rel=1e-12)
    assert velocity == pytest.approx(5 / 7 * speed, rel=0.01)


@pytest.mark.parametrize("readings", LAWS)
@pytest.mark.parametrize("friction", [0.05, 0.08, 0.1, 2.0])
def test_lone_sphere_slips_or_rolls_down_the_incline(friction, readings):
    """2/7 tan 17 degrees is 0.0874: below it the sphere slips, above it rolls without slip."""
    law = sphere_law(friction=friction, **readings)
    down, _, into = weight_components(17.0)
    slips = friction < 2 / 7 * np.tan(np.radians(17.0))
    expected = down + friction * into if slips else 5 / 7 * down
    motion = pressed_sphere(law, 17.0, 0.05, 0.05 / RADIUS * (0.8 if slips else 1.0)).run(2000)
    before = motion.velocity[0, 0]
    motion.run(20_000)
    measured = (motion.velocity[0, 0] - before) / (20_000 * motion.time_step)
    assert measured == pytest.approx(expected, rel=1e-9 if slips else 2e-3)
    if not slips:
        rolling = RADIUS * motion.spin[0, 1]
        assert rolling == pytest.approx(motion.velocity[0, 0], rel=5e-3)


@pytest.mark.parametrize("readings", LAWS[:2])
@pytest.mark.parametrize("speed", [0.002, 0.2])
def test_gross_slip_impact_changes_the_surface_velocity_by_the_friction_impulse(speed, readings):
    law = sphere_law(**readings)
    motion = drop_sphere(law, speed, 0.3, slide=6 * speed)
    restitution = motion.velocity[0, 2] / speed
    change = 6 * speed - surface_velocity(motion)
    assert change == pytest.approx(3.5 * (1 + restitution) * 0.4 * speed, rel=1e-12)
    assert restitution == pytest.approx(0.85, abs=1e-3)


def test_more_spheres_than_a_block_each_move_as_if_alone():
    """Sums over the plane are those of the single spheres, whatever the block they fall into."""
    rng = np.random.default_rng(4)
    number = 2 * BLOCK + 37
    place = np.stack(np.divmod(np.arange(number), 30), axis=1) * 4 * RADIUS
    height = RADIUS * rng.uniform(0.96, 1.01, number)
    position = np.column_stack([place, height])
    velocity, spin = rng.normal(0, 0.05, (number, 3)), rng.normal(0, 50, (number, 3))
    box = 30 * 4 * RADIUS, 30 * 4 * RADIUS
    all_spheres = SphereMotion(position, velocity, spin, box=box).run(20)
    along = upward = contacts = 0.0
    for i in range(number):
        single = SphereMotion(position[i : i + 1], velocity[i : i + 1], spin[i : i + 1]).run(20)
        assert all_spheres.velocity[i] == pytest.approx(single.velocity[0], rel=1e-11)
        assert all_spheres.spin[i] == pytest.approx(single.spin[0], rel=1e-11)
        along += single.flow.sums[leap_frog.PLANE_X]
        upward += single.flow.sums[leap_frog.PLANE_Z]
        contacts += single.flow.sums[leap_frog.CONTACTS]
    sums = all_spheres.flow.sums
    assert sums[leap_frog.PLANE_X] == pytest.approx(along, abs=1e-12 * upward)
    assert sums[leap_frog.PLANE_Z] == pytest.approx(upward, rel=1e-12)
    assert sums[leap_frog.CONTACTS] == contacts > 10 * number
