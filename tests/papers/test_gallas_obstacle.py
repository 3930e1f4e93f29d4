"""Judges of claims about the obstacle."""

import numpy as np
import pytest

from sim.papers.gallas.judges.obstacle import g31, g33, g34
from tests.made.judging import letters
from tests.made.paper_belt import BEAD, paper_point, velocity

SIZES = (0, 0.5, 1.5, 2.5)


def rows(velocities=None, sizes=SIZES, **rest):
    """Return points at two frequencies and several diameters, with velocities (m/s) if given."""
    scalars_by_size = (
        [None] * len(sizes) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, obstacle=size, **rest)
        for frequency in (20, 80)
        for size, scalars in zip(sizes, scalars_by_size, strict=True)
    ]


def turbulent(share):
    """Return points behind two obstacles with a share of beads that move backwards."""
    return [paper_point({"backflow": share}, frequency=80, obstacle=size) for size in (1.5, 2.5)]


def blocked(local, scatter=1e-3, far_height=1.2):
    """Return beds with and without an obstacle, slowed everywhere or only close to it.

    Behind it the paths are 1.2 times as high as without it, and ``far_height`` times as high far
    away.
    """
    points = []
    for frequency in (20, 80):
        free = paper_point(frequency=frequency)
        speed = velocity(free.parameters)

        def along(column, speed=speed):
            near = np.abs(column - 10 * BEAD) < 4 * BEAD
            return speed * np.where(near, 0.4, 1.0 if local else 0.5)

        height = free.scalars["path_vertical"].mean()
        scalars = {"path_vertical": 1.2 * height, "path_vertical_far": far_height * height}
        profiles = {"column_velocity": along}
        stopped = paper_point(scalars, profiles, frequency=frequency, obstacle=1.5, scatter=scatter)
        points += [free, stopped]
    return points


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g31, "R", lambda: rows()),
    (g31, "N", lambda: rows([0.3, 0.25, 0.1, 0.05])),
    (g31, "I", lambda: rows(scatter=0.5)),
    (g31, "-", lambda: rows(sizes=SIZES[:-1])),
    (g33, "R", lambda: turbulent(0.001)),
    (g33, "N", lambda: turbulent(0.05)),
    (g33, "I", lambda: turbulent([0.0, 0.02, 0.005, 0.03, 0.001])),
    (g33, "-", lambda: turbulent(0.001)[:1]),
    (g34, "R", lambda: blocked(local=False)),
    # The shape changes nowhere but close to the obstacle.
    (g34, "N", lambda: blocked(local=True, far_height=1.0)),
    (g34, "I", lambda: blocked(local=False, scatter=1.5)),
    (g34, "-", lambda: blocked(local=False)[::2]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
