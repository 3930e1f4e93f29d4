"""Impacts of two free spheres: restitution (claim W1), gross slip, symmetry, conservation."""

import numpy as np
import pytest

from tests.engine_motion.helpers import (
    LAWS,
    MASS,
    RADIUS,
    collision_time,
    sphere_law,
)
from tests.engine_motion.impacts import Impacts
from tests.engine_motion.spheres import SphereMotion

SPEEDS = np.geomspace(1e-3, 1.0, 7)
PLACE = np.array([0.0, 0.0, 20 * RADIUS])


def colliding_pair(
    law, speed, gap=0.3, slide=0.0, size=(1.0, 1.0), spin=((0, 0, 0),) * 2, frame=None, **options
):
    """Two spheres ``gap`` steps before they touch, approaching along x and sliding along y."""
    frame = np.eye(3) if frame is None else frame
    radius = RADIUS * np.array(size)
    distance = radius.sum() + gap * speed * collision_time(law) / 40
    apart = np.array([[-0.5, 0, 0], [0.5, 0, 0]]) * distance
    velocity = np.array([[speed, -slide, 0], [-speed, slide, 0]]) / 2
    start = apart @ frame.T + PLACE, velocity @ frame.T, np.array(spin, float) @ frame.T
    mass = MASS * np.array(size) ** 3
    return SphereMotion(*start, law=law, radius=radius, mass=mass, **options)


def separation_speed(motion, frame=None) -> float:
    """Speed at which the two spheres part along the line of the impact."""
    relative = motion.velocity[1] - motion.velocity[0]
    return float(relative @ (np.eye(3) if frame is None else frame)[:, 0])


@pytest.mark.parametrize("radii", [(RADIUS,), (RADIUS, RADIUS)], ids=["plane", "pair"])
@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.7, 0.85, 0.95, 1.0])
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
        restitutions = [
            separation_speed(colliding_pair(law, 0.1, g, **options).run(3 * steps)) for g in gaps
        ]
        errors.append(np.abs(np.array(restitutions) / 0.1 - 0.7).max())
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] > 8 and errors[1] / errors[2] > 8


def test_reset_memory_raises_the_restitution():
    """A contact that forgets at zero force pushes again while it opens.

    Each forgotten overlap a leaves (1 - e^2) a behind, which loads afresh: the energies returned
    form a geometric series and the restitution is 1/sqrt(2 - e^2).
    """
    law = sphere_law(overlap_memory="reset", tangential_exponent=1.0)
    expected = 1 / np.sqrt(2 - 0.85**2)
    errors = []
    for steps in (200, 800):
        motion = colliding_pair(law, 0.1, steps_per_collision=steps).run(3 * steps)
        errors.append(abs(separation_speed(motion) / 0.1 - expected))
    assert errors[1] < 2e-3 and errors[1] < errors[0]


def test_impact_across_the_edges_is_the_impact_inside():
    box = (8 * RADIUS, 7 * RADIUS)
    inside = colliding_pair(sphere_law(), 0.02, slide=0.015, box=box)
    across = colliding_pair(sphere_law(), 0.02, slide=0.015, box=box)
    across.spheres.position[:2, 1] += [5 * box[0], -3 * box[1]]
    inside.run(150)
    across.run(150)
    assert across.velocity == pytest.approx(inside.velocity, abs=1e-9 * 0.02)


def test_free_pairs_conserve_momentum_and_angular_momentum_up_to_their_overlap():
    """Torques act at full radii, so each step adds overlap * k x T: less the harder the spheres.

    Without friction there is no T, and angular momentum is exact.
    """
    rng = np.random.default_rng(3)
    spin = 30 * rng.normal(size=(2, 3))
    drifts = []
    for stiffness in (1e2, 1e4):
        for friction in (0.4, 0.0):
            law = sphere_law(stiffness=stiffness, friction=friction)
            motion = colliding_pair(law, 0.05, slide=0.04, spin=spin, size=(1.2, 0.9))
            momentum, angular = motion.momentum(), motion.angular_momentum()
            motion.run(150)
            scale = RADIUS * MASS * 0.05
            assert np.abs(motion.momentum() - momentum).max() < 1e-14 * MASS * 0.05
            drifts.append(np.abs(motion.angular_momentum() - angular).max() / scale)
    soft, soft_smooth, hard, hard_smooth = drifts
    assert max(soft_smooth, hard_smooth) < 1e-11
    assert soft < 0.02
    assert soft / hard == pytest.approx(10.0, rel=0.2)


def oblique(law, steps: int) -> np.ndarray:
    """Velocities after oblique impacts (8, 3) in units of the approach, for 8 phases of a step."""
    ends = []
    for gap in np.linspace(0.05, 0.95, 8) * 40 / steps:
        motion = colliding_pair(law, 0.02, gap, slide=0.04, steps_per_collision=steps)
        s = motion.run(2 * steps)
        ends.append([*s.velocity[1, :2], RADIUS * s.spin[1, 2]])
    return np.array(ends) / 0.02


def test_oblique_impacts_converge_with_the_time_step():
    """Cutting T before the slip costs an error of first order, 2 % at t_c/40; after it 0.3 %.

    That both come to one result is tested with the reference.
    """
    before, after = (sphere_law(**readings) for readings in LAWS[:2])
    exact = oblique(before, 5120).mean(axis=0)
    errors = [np.abs(oblique(before, steps) - exact).max() for steps in (20, 40, 80)]
    assert errors[1] < 0.025
    assert errors[0] / errors[1] > 1.6 and errors[1] / errors[2] > 1.6
    exact = oblique(after, 5120).mean(axis=0)
    assert max(np.abs(oblique(after, steps) - exact).max() for steps in (20, 40, 80)) < 5e-3
