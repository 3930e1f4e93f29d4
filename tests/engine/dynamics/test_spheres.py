"""Free spheres: impacts of two (claim W1), and many: conservation, energy, lists in motion."""

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
    lattice,
    sphere_law,
    weight_components,
    wrapped,
)
from tests.engine_motion.motion import Impacts, SphereMotion

SPEEDS = np.geomspace(1e-3, 1.0, 7)
PLACE = np.array([0.0, 0.0, 20 * RADIUS])


def colliding_pair(law, speed, gap, slide=0.0, **options):
    """Two spheres ``gap`` steps before they touch, approaching along x and sliding along y."""
    distance = 2 * RADIUS + gap * speed * collision_time(law) / 40
    apart = np.array([[-0.5, 0, 0], [0.5, 0, 0]]) * distance
    velocity = np.array([[speed, -slide, 0], [-speed, slide, 0]]) / 2
    return SphereMotion(apart + PLACE, velocity, law=law, **options)


@pytest.mark.parametrize("radii", [(RADIUS,), (RADIUS, RADIUS)], ids=["plane", "pair"])
@pytest.mark.parametrize("restitution", [0.3, 0.85, 1.0])
def test_restitution_is_the_root_of_the_stiffness_ratio_at_every_speed(restitution, radii):
    """Wherever within a step the contact begins; the rest is the time step's and has no trend."""
    law = sphere_law(restitution=restitution)
    step, mass = collision_time(law) / 40, [MASS] * len(radii)
    measured = [
        Impacts(law, radii, mass, step, np.full(5, speed)).run(400).velocities()[:, 0] / speed
        for speed in SPEEDS
    ]
    assert np.abs(np.array(measured) - restitution).max() < 1e-3
    assert np.ptp(measured, axis=0).max() < 1e-9


def test_restitution_error_falls_with_the_square_of_the_time_step():
    law = sphere_law(restitution=0.7)
    errors = []
    for steps in (20, 80, 320):
        gaps = np.linspace(0.05, 0.95, 10) * 40 / steps
        options = {"steps_per_collision": steps}
        pairs = [colliding_pair(law, 0.1, gap, **options).run(3 * steps) for gap in gaps]
        speeds = np.array([motion.velocity[1, 0] - motion.velocity[0, 0] for motion in pairs])
        errors.append(np.abs(speeds / 0.1 - 0.7).max())
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] > 8 and errors[1] / errors[2] > 8


def oblique(law, steps: int) -> np.ndarray:
    """Velocities after oblique impacts (8, 3) in units of the approach, for 8 phases of a step."""
    ends = []
    for gap in np.linspace(0.05, 0.95, 8) * 40 / steps:
        motion = colliding_pair(law, 0.02, gap, slide=0.04, steps_per_collision=steps)
        s = motion.run(2 * steps)
        ends.append([*s.velocity[1, :2], RADIUS * s.spin[1, 2]])
    return np.array(ends) / 0.02


def test_oblique_impacts_converge_with_the_time_step():
    """Cutting T before the slip costs an error of first order, 2 % at t_c/40; after it 0.3 %."""
    before, after = (sphere_law(**readings) for readings in LAWS[:2])
    exact = oblique(before, 5120).mean(axis=0)
    errors = [np.abs(oblique(before, steps) - exact).max() for steps in (20, 40, 80)]
    assert errors[1] < 0.025
    assert errors[0] / errors[1] > 1.6 and errors[1] / errors[2] > 1.6
    exact = oblique(after, 5120).mean(axis=0)
    assert max(np.abs(oblique(after, steps) - exact).max() for steps in (20, 40, 80)) < 5e-3


SPEED = 0.1
FAR = 80 * RADIUS


def gas(law, seed=3, shape=(5, 5, 2), jitter=0.03, open_sides=False, implode=0.0, **options):
    """A polydisperse gas of spinning spheres, far above the plane, without gravity."""
    rng = np.random.default_rng(seed)
    spacing = 2.6 * RADIUS
    position = lattice(shape, spacing, jitter, rng, FAR)
    velocity = rng.normal(0, SPEED, position.shape) * [1, 1, 0.3]
    velocity -= implode * SPEED / spacing * (position - position.mean(axis=0))
    radius = RADIUS * rng.uniform(0.8, 1.2, len(position))
    spin = rng.normal(0, 50, position.shape)
    if not open_sides:
        options["box"] = tuple(spacing * np.array(shape[:2]))
    mass = MASS * (radius / RADIUS) ** 3
    return SphereMotion(position, velocity, spin, law=law, radius=radius, mass=mass, **options)


def overlaps(motion, place) -> tuple[np.ndarray, np.ndarray]:
    """Overlaps (C,) and normals (C, 3) of the contacts of the last step, made at ``place``."""
    i, j, reach, _ = motion.contacts()
    apart = wrapped(place[j] - place[i], *motion.length)
    distance = np.linalg.norm(apart, axis=1)
    return reach - distance, apart / distance[:, None]


def stored_energy(motion, place) -> float:
    """Energy of the compressed elastic springs in the last step, J."""
    overlap, _ = overlaps(motion, place)
    return float(0.5 * motion.laws[0].loading * (overlap**2).sum())


@pytest.mark.parametrize("readings", LAWS)
def test_free_gas_conserves_momentum(readings):
    motion = gas(sphere_law(**readings))
    before = motion.momentum()
    motion.run(4000)
    scale = motion.mass.sum() * SPEED
    assert np.abs(motion.momentum() - before).max() < 1e-13 * scale
    assert motion.flow.sums[leap_frog.CONTACTS] > 1000


def test_angular_momentum_of_a_free_gas_changes_only_by_the_overlap():
    """Torques act at full radii and centres are closer by the overlap: overlap * k x T per step."""
    motion = gas(sphere_law(), shape=(3, 3, 3), open_sides=True, implode=1.0)
    start, drift = motion.angular_momentum(), np.zeros(3)
    scale = float((motion.moment_of_inertia @ np.abs(motion.spin)).max())
    for _ in range(1500):
        place = motion.position
        overlap, normal = overlaps(motion.run(1), place)
        friction = motion.contacts()[3][:3].T
        drift += motion.time_step * np.cross(overlap[:, None] * normal, friction).sum(axis=0)
    assert motion.angular_momentum() == pytest.approx(start + drift, abs=1e-10 * scale)
    assert 1e-6 * scale < np.abs(drift).max() < 0.1 * scale


def test_elastic_frictionless_gas_keeps_its_energy_to_second_order_in_the_step():
    law = sphere_law(friction=0.0, restitution=1.0)
    worst = []
    for steps in (40, 160):
        deviations = []
        for seed in range(2):
            motion = gas(law, seed, steps_per_collision=steps)
            start = motion.energy()
            for _ in range(200):
                # Looked at eight times in a collision.
                motion.run(steps // 8 - 1)
                place, before = motion.position, motion.velocity
                motion.run(1)
                # Velocities half a step apart on both sides of the positions that store energy.
                moving = 0.5 * (motion.mass[:, None] * before * motion.velocity).sum()
                turning = 0.5 * (motion.moment_of_inertia[:, None] * motion.spin**2).sum()
                total = moving + turning + stored_energy(motion, place)
                deviations.append(abs(total / start - 1))
        worst.append(max(deviations))
    assert worst[0] < 1e-3
    assert worst[0] / worst[1] > 8


@pytest.mark.parametrize("shape", [(4, 4, 4), (2, 2, 6)])
def test_skin_changes_the_trajectory_by_rounding_only(shape):
    """Rebuilt every few steps or hardly ever, over dense contacts whose memory must be kept."""
    rng = np.random.default_rng(7)
    position = lattice(shape, 1.97 * RADIUS, 0.03, rng, FAR)
    velocity = rng.normal(0, SPEED, position.shape)
    spin = rng.normal(0, 50, position.shape)
    # The smallest box: its half must hold a diameter and the skin.
    box = tuple(max(3.0, 0.985 * n) * 2 * RADIUS for n in shape[:2])
    ends = []
    for skin in (0.004 * RADIUS, 0.9 * RADIUS):
        motion = SphereMotion(position, velocity, spin, box=box, skin=skin, room=60).run(100)
        ends.append(motion)
    assert wrapped(ends[0].position - ends[1].position, *box, 0.0) == pytest.approx(
        0.0, abs=1e-10 * RADIUS
    )
    assert ends[0].velocity == pytest.approx(ends[1].velocity, abs=1e-10 * SPEED)
    assert ends[0].spin == pytest.approx(ends[1].spin, abs=1e-10 * SPEED / RADIUS)
    assert np.abs(ends[0].velocity - velocity).max() > 0.1 * SPEED


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
