"""What holds for every contact law that presses on: closed cycles, rest, and a block that sticks.

`test_laws` has the cases and what laws lack.
"""

import numpy as np
import pytest

from sim.claims.experiments import contact_path
from sim.engine.contact import Partners, law_of
from sim.engine.contact.functions import PartnerLaw
from tests.conformance.test_laws import FRICTION, point_of, with_property
from tests.engine_motion.spheres import SphereMotion


def closed_cycles(rng, steps: int = 1000, rounds: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Return overlaps (n,) and slips (n, 3) in m of a contact that begins, goes round and ends."""
    time, mode = np.linspace(0, rounds, rounds * steps + 1)[:, None], np.arange(1, 4)
    sines, cosines = rng.normal(size=(2, 3, 3)) / mode[:, None]
    angle = 2 * np.pi * time * mode
    curves = np.sin(angle) @ sines + (np.cos(angle) - 1) @ cosines
    curves /= np.abs(curves).max(axis=0)
    loading = np.linspace(0, 1, 200)
    overlap = 1e-5 * (1 + 0.8 * curves[:, 0])
    path = np.concatenate([loading[:-1] * overlap[0], overlap, loading[-2::-1] * overlap[-1]])
    slip = np.zeros((path.size, 3))
    slip[200 : 200 + rounds * steps, :2] = 1e-6 * np.diff(curves[:, 1:], axis=0)
    return path, slip


@pytest.mark.parametrize("friction", [FRICTION, 50.0])
@with_property("cycle")
def test_no_closed_cycle_of_load_and_shear_gives_energy(case, friction):
    """Friction alone gives none, whether it sticks all the time (50) or slides now and then."""
    point = point_of(case)
    law = law_of(point, Partners(friction, 0.5 * point.mass, point.time_step))
    if not point.option("law").compiled_by_hand:
        law = PartnerLaw(law, 0.25 * point.diameter, 0.5 * point.mass)
    rng = np.random.default_rng(3)
    for _ in range(20):
        overlap, slip = closed_cycles(rng)
        normal = np.tile([0.0, 0.0, 1.0], (overlap.size, 1))
        force, along, _ = contact_path(law, overlap, normal, slip)
        means = [0.5 * (one + np.roll(one, 1, axis=0)) for one in (force, along)]
        rubbing = (means[1] * slip).sum(axis=1)
        pressing = means[0] * np.diff(overlap, prepend=0.0)
        assert rubbing.sum() >= -1e-3 * np.abs(rubbing).sum()
        assert rubbing.sum() + pressing.sum() >= 0


def placed(case: str, slope: float, **options) -> SphereMotion:
    """Return a sphere that begins to press the plane, where gravity has a slope of ``slope``."""
    point = point_of(case, restitution=0.5, steps_per_collision=40)
    law = law_of(point, Partners(FRICTION, point.mass, point.time_step))
    radius, weight = 0.5 * point.diameter, point.gravity / np.hypot(1, slope)
    return SphereMotion(
        [[0.0, 0.0, radius]],
        np.zeros((1, 3)),
        law=law,
        time_step=point.time_step,
        radius=radius,
        mass=point.mass,
        gravity=(float(slope * weight), 0.0, -float(weight)),
        **options,
    )


@with_property("rest")
def test_a_sphere_on_the_plane_comes_to_rest_with_its_weight_on_it(case):
    one = placed(case, 0.0).run(6000)
    weight = one.mass[0] * -one.gravity[2]
    for _ in range(50):
        assert one.run(7).force[0, 2] == pytest.approx(weight, rel=1e-6)


@pytest.mark.parametrize("share", [0.98, 1.02])
@with_property("stick")
def test_a_block_sticks_below_the_friction_limit_and_slides_above_it(case, share):
    slope, steps = share * FRICTION, 6000
    one = placed(case, slope, inertia=np.inf).run(6000)
    start, speed = one.position[0, 0], one.velocity[0, 0]
    one.run(steps)
    time = steps * one.time_step
    excess = one.gravity[0] + FRICTION * one.gravity[2]
    way = one.position[0, 0] - start
    if share > 1:
        assert way == pytest.approx(speed * time + 0.5 * excess * time**2, rel=1e-3)
    else:
        # Its spring swings, as nothing damps it, about one place.
        assert abs(way) < 1e-2 * abs(0.5 * excess) * time**2
