"""Hertz's law and the drags of the belt between two particles: exact results."""

import numpy as np
import pytest

from sim.engine.contact import Partners, law_of
from sim.laws.hertz import effective_modulus, force
from sim.parameters import ChuteParameters
from tests.engine_motion.spheres import SphereMotion

RADII = {"equal": (0.5e-3, 0.5e-3), "unlike": (0.3e-3, 0.8e-3)}
PLACE = np.array([0.0, 0.0, 20e-3])


def impact(law, point, speed, radii, slide=0.0):
    """Return two spheres of one density that are about to touch along x and slide along y."""
    radii = np.array(radii)
    mass = point.mass * (2 * radii / point.diameter) ** 3
    step = point.time_step
    apart = np.array([[-radii[0], 0, 0], [radii[1] + 0.25 * speed * step, 0, 0]])
    velocity = np.array([[speed, -slide, 0], [-speed, slide, 0]]) / 2
    return SphereMotion(apart + PLACE, velocity, law=law, time_step=step, radius=radii, mass=mass)


def run_until_parted(motion, steps=20_000):
    """Run a pair until its particles have met and parted."""
    has_met = False
    for _ in range(steps // 20):
        touching = motion.run(20).contacts()[0].size
        if has_met and not touching:
            return motion
        has_met = has_met or touching
    raise AssertionError("still in contact")


@pytest.mark.parametrize("radii", RADII.values(), ids=RADII)
@pytest.mark.parametrize("speed", [0.02, 0.5])
@pytest.mark.parametrize("restitution", [0.5, 0.9, 1.0])
@pytest.mark.parametrize("law", ["hertz", "drag"])
def test_the_restitution_is_the_same_at_every_speed_and_size(law, restitution, speed, radii):
    point = ChuteParameters(law=law, restitution=restitution, steps_per_collision=400)
    contact_law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    motion = run_until_parted(impact(contact_law, point, speed, radii))
    parting = motion.velocity[1, 0] - motion.velocity[0, 0]
    assert parting / speed == pytest.approx(restitution, abs=0.01)


def test_hertz_collides_as_long_and_as_deep_as_the_exact_solution():
    """t_c = 2.94 (15/16)^(2/5) (m*²/(R* E*² v))^(1/5), α_max = (15 m* v²/(16 √R* E*))^(2/5)."""
    point, speed = ChuteParameters(law="hertz", restitution=1, steps_per_collision=1000), 0.3
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    mass, radius, modulus = point.mass / 2, point.diameter / 4, effective_modulus(point)
    deepest = (15 * mass * speed**2 / (16 * radius**0.5 * modulus)) ** 0.4
    duration = 2.94327 * deepest / speed
    motion, steps, overlap = impact(law, point, speed, RADII["equal"]).run(2), 0, 0.0
    while motion.contacts()[0].size:
        motion.run(1)
        steps += 1
        apart = motion.position[1, 0] - motion.position[0, 0]
        overlap = max(overlap, point.diameter - apart)
    assert steps * point.time_step == pytest.approx(duration, rel=5e-3)
    assert overlap == pytest.approx(deepest, rel=2e-3)


def test_hertz_at_a_hundredth_of_a_diameter_is_the_spring():
    point = ChuteParameters(law="hertz")
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    overlap, radius, zero = point.diameter / 100, point.diameter / 4, (0.0, 0.0, 0.0)
    normal = force(law, overlap, 0.0, zero, zero, (0.0,) * 4, radius, point.mass)[0]
    assert normal == pytest.approx(point.stiffness * overlap)


def slip_of(motion, point) -> float:
    """Return the velocity of the second surface along the first (m/s)."""
    along = motion.velocity[1, 1] - motion.velocity[0, 1]
    return along - point.diameter / 2 * (motion.spin[0, 2] + motion.spin[1, 2])


def test_hertz_slides_at_the_friction_limit():
    """Gross slip takes 3.5 (1 + e) μ v_n of the slip velocity, whatever the law."""
    point = ChuteParameters(law="hertz", restitution=0.8, steps_per_collision=400)
    law = law_of(point, Partners(0.3, 0.5 * point.mass, point.time_step))
    # So slow that the pair hardly turns while it touches.
    motion = run_until_parted(impact(law, point, 0.001, RADII["equal"], slide=0.003))
    loss = 0.003 - slip_of(motion, point)
    assert loss == pytest.approx(3.5 * 1.8 * 0.3 * 0.001, rel=0.02)


def test_the_shear_drag_stops_a_slip_exponentially():
    """Two equal solid spheres lose their slip at the rate (7/2) γ_s while they touch."""
    point = ChuteParameters(law="drag", restitution=0.9, steps_per_collision=400, shear_damping=20)
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    motion, steps = impact(law, point, 0.002, RADII["equal"], slide=0.001).run(1), 0
    while not steps or motion.contacts()[0].size:
        motion.run(1)
        steps += 1
    duration = (steps - 1) * point.time_step
    rate = 3.5 * 20 * point.gravity
    assert slip_of(motion, point) == pytest.approx(0.001 * np.exp(-rate * duration), rel=0.01)
