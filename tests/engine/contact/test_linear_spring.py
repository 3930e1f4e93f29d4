"""Exponent 0 against an independent Cundall-Strack vector spring on 2-D paths (claim W3)."""

import numpy as np
import pytest

from sim.claims.contacts import contact_path, random_curve, vector_spring
from tests.engine_motion.helpers import CAPS, sphere_law

FORCE = 1e-3
PATHS = range(100)


def compare_springs(seed: int, steps: int, cap: str, swing: float):
    """Engine and spring along one path: differences, slip per step and limit, all in N, (n,).

    An elastic law makes the normal force proportional to the overlap, so any F_N can be had.
    """
    law = sphere_law(restitution=1.0, tangential_exponent=0.0, friction_cap=cap)
    path = 3.0 * law.limit.friction * FORCE / law.tangential * random_curve(seed, steps)
    slip = np.zeros((steps, 3))
    slip[:, :2] = np.diff(path, axis=0)
    normal_force = FORCE * np.exp(swing * random_curve(seed + 1000, steps)[1:, 0])
    normal = np.tile([0.0, 0.0, 1.0], (steps, 1))
    _, force, _ = contact_path(law, normal_force / law.loading, normal, slip)
    friction = law.limit.friction
    expected = vector_spring(slip[:, :2].copy(), normal_force, law.tangential, friction)
    difference = np.linalg.norm(force[:, :2] - expected, axis=1)
    loads = law.tangential * np.linalg.norm(slip, axis=1)
    return difference, loads, friction * normal_force, np.linalg.norm(expected, axis=1)


@pytest.mark.parametrize("cap", CAPS)
def test_constant_normal_force_gives_the_vector_spring_exactly(cap):
    sliding = []
    for seed in PATHS:
        difference, _, limit, size = compare_springs(seed, 1000, cap, swing=0.0)
        assert difference.max() < 1e-12 * limit[0]
        sliding.append(np.mean(size > (1 - 1e-9) * limit))
    assert 0.1 < np.mean(sliding) < 0.9


def test_varying_normal_force_gives_the_vector_spring_exactly_with_the_cap_after():
    for seed in PATHS:
        difference, _, limit, _ = compare_springs(seed, 1000, "after", swing=0.7)
        assert (difference < 1e-12 * limit).all()


def test_varying_normal_force_with_the_cap_before_differs_by_less_than_a_step():
    """The spring is cut once, after the slip; here a limit that falls cuts the force before it too.

    So where a sliding contact slips back while F_N falls, the force lags by at most the K0 |ds| of
    that step: an error of first order, below 1e-3 mu F_N on all paths at these 24,000 steps.
    """
    for seed in PATHS:
        difference, loads, limit, _ = compare_springs(seed, 24_000, "before", swing=0.7)
        assert (difference <= loads.max()).all()
        assert (difference < 1e-3 * limit).all()


def test_the_difference_between_the_caps_is_of_first_order_in_the_step():
    def worst(steps):
        paths = (compare_springs(seed, steps, "before", swing=0.7) for seed in range(20))
        return max((difference / limit).max() for difference, _, limit, _ in paths)

    assert worst(2000) / worst(8000) == pytest.approx(4.0, rel=0.2)
