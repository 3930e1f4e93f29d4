"""Judges of claims about the obstacle."""

import numpy as np
import pytest

from sim.claims.gallas_obstacle import g31, g33, g34
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from tests.claims.paper_belt import BEAD, checks_of, published, velocity, verdict_of

SIZES = (0, 0.5, 1.5, 2.5)


def rows(velocities=None, sizes=SIZES, **rest):
    """Return points at two frequencies and several diameters, with velocities (m/s) if given."""
    given = [None] * len(sizes) if velocities is None else [{"velocity": v} for v in velocities]
    return [
        published(scalars, frequency=frequency, obstacle=size, **rest)
        for frequency in (20, 80)
        for size, scalars in zip(sizes, given, strict=True)
    ]


def test_an_obstacle_slows_the_flow():
    assert verdict_of(g31, rows()) == REPRODUCED
    assert verdict_of(g31, rows([0.3, 0.25, 0.1, 0.05])) == NOT_REPRODUCED
    assert verdict_of(g31, rows([0.3, 0.1, 0.2, 0.05])) == NOT_REPRODUCED
    assert verdict_of(g31, rows(scatter=0.5)) == INCONCLUSIVE
    with pytest.raises(Untestable, match=r"obstacle 2\.5"):
        checks_of(g31, rows(sizes=SIZES[:-1]))


@pytest.mark.parametrize(
    ("share", "verdict"),
    [
        (0.001, REPRODUCED),
        (0.05, NOT_REPRODUCED),
        ([0.0, 0.02, 0.005, 0.03, 0.001], INCONCLUSIVE),
    ],
)
def test_no_turbulence(share, verdict):
    points = [published({"backflow": share}, frequency=80, obstacle=each) for each in (1.5, 2.5)]
    assert verdict_of(g33, points) == verdict
    with pytest.raises(Untestable, match=r"obstacle 2\.5"):
        checks_of(g33, points[:1])


def blocked(local, scatter=1e-3):
    """Return beds with and without an obstacle, slowed everywhere or only close to it."""
    points = []
    for frequency in (20, 80):
        free = published(frequency=frequency, scatter=scatter)
        speed = velocity(free.parameters)

        def along(column, speed=speed):
            near = np.abs(column - 10 * BEAD) < 4 * BEAD
            return speed * np.where(near, 0.4, 1.0 if local else 0.5)

        profiles = {"column_velocity": along}
        stopped = published(profiles=profiles, frequency=frequency, obstacle=1.5, scatter=scatter)
        points += [free, stopped]
    return points


def test_the_effect_spreads_over_the_system():
    assert verdict_of(g34, blocked(local=False)) == REPRODUCED
    assert verdict_of(g34, blocked(local=True)) == NOT_REPRODUCED
    assert verdict_of(g34, blocked(local=False, scatter=0.5)) == INCONCLUSIVE
    with pytest.raises(Untestable, match=r"obstacle 1\.5"):
        checks_of(g34, blocked(local=False)[::2])


def test_a_uniform_slow_down_has_half_of_it_far_away():
    points = [
        published(frequency=frequency, obstacle=size) for frequency in (20, 80) for size in (0, 1.5)
    ]
    assert checks_of(g34, points)[0].value == pytest.approx(0.5)
