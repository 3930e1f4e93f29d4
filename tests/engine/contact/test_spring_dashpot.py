"""Spring and dashpot: restitution, duration, friction limit, and the energy that it dissipates."""

import numpy as np
import pytest

from sim.claims.contacts import contact_path
from sim.engine.contact.spring_dashpot import damping_ratio, spring_dashpot
from tests.engine_motion.helpers import MASS, RADIUS
from tests.engine_motion.points import chute_point
from tests.engine_motion.spheres import SphereMotion

SPEED, PLACE = 0.05, np.array([0.0, 0.0, 20 * RADIUS])


def law_of(point, plane: bool = False, friction: float = 0.4):
    mass = point.mass if plane else 0.5 * point.mass
    return spring_dashpot(point.stiffness, point.restitution, friction, mass, point.time_step)


def impact(point, slide: float = 0.0) -> SphereMotion:
    """Two equal spheres that touch in the next step, approaching along x, sliding along y."""
    apart = np.array([[-1.0, 0, 0], [1.0, 0, 0]]) * (RADIUS + 0.25 * SPEED * point.time_step)
    velocity = np.array([[SPEED, -slide, 0], [-SPEED, slide, 0]]) / 2
    law = law_of(point)
    return SphereMotion(apart + PLACE, velocity, law=law, time_step=point.time_step)


@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.85, 0.95, 1.0])
@pytest.mark.parametrize("stiffness", [117.0, 1170.0])
def test_a_pair_rebounds_with_the_restitution_after_the_collision_time(restitution, stiffness):
    """Within the time step's own error, which sets in and ends with the drag."""
    point = chute_point(
        law="spring_dashpot",
        restitution=restitution,
        stiffness=stiffness,
        steps_per_collision=1000,
    )
    motion = impact(point).run(990)
    assert motion.contacts()[0].size == 1
    motion.run(30)
    assert motion.contacts()[0].size == 0
    parting = motion.velocity[1, 0] - motion.velocity[0, 0]
    assert parting / SPEED == pytest.approx(restitution, abs=2e-3)


def test_a_sphere_rebounds_from_the_plane_with_the_same_restitution():
    """The plane meets it with its whole mass, so its dashpot is another."""
    point = chute_point(law="spring_dashpot", restitution=0.7, steps_per_collision=1000)
    motion = SphereMotion(
        [[0.0, 0.0, RADIUS]],
        [[0.0, 0.0, -SPEED]],
        law=law_of(point),
        plane_law=law_of(point, plane=True),
        time_step=point.time_step,
    ).run(2000)
    assert motion.velocity[0, 2] / SPEED == pytest.approx(0.7, abs=2e-3)


def test_gross_slip_takes_what_the_friction_of_the_impact_gives():
    """The tangential surface velocity falls by 3.5 (1 + e) μ v_n, whatever the law.

    The spheres are stiff, so that the normal does not turn during the impact.
    """
    point = chute_point(law="spring_dashpot", stiffness=1e7, steps_per_collision=400)
    motion = impact(point, slide=10 * SPEED).run(500)
    velocity, spin = motion.velocity, motion.spin
    along = velocity[1, 1] - velocity[0, 1]
    surface = along - RADIUS * (spin[0, 2] + spin[1, 2])
    loss = 10 * SPEED - surface
    assert loss == pytest.approx(3.5 * (1 + point.restitution) * 0.4 * SPEED, rel=0.01)


def test_friction_is_a_spring_up_to_its_limit():
    law = spring_dashpot(100.0, 1.0, 0.4, MASS, 1e-6)
    steps = 50
    overlap, normal = np.full(steps, 1e-5), np.tile([1.0, 0.0, 0.0], (steps, 1))
    slip = np.tile([0.0, 2e-7, 0.0], (steps, 1))
    force, tangential, _ = contact_path(law, overlap, normal, slip)
    assert force == pytest.approx(1e-3)
    expected = np.minimum(80.0 * 2e-7 * np.arange(1, steps + 1), 0.4 * 1e-3)
    assert tangential[:, 1] == pytest.approx(expected, rel=1e-12)


def test_the_pull_at_the_end_of_a_contact_is_kept():
    law = spring_dashpot(100.0, 0.5, 0.4, MASS, 1e-6)
    overlap = np.array([2e-6, 1e-6, 1e-8])
    normal, slip = np.tile([1.0, 0.0, 0.0], (3, 1)), np.zeros((3, 3))
    force, _, _ = contact_path(law, overlap, normal, slip)
    assert force[-1] < 0.0


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
def test_damping_ratio_is_that_of_a_damped_oscillator(restitution):
    ratio = damping_ratio(restitution)
    assert np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)) == pytest.approx(restitution, rel=1e-12)
    assert damping_ratio(1.0) == 0.0
