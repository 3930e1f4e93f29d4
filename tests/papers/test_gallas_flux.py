"""Judges of claims about the mean velocity, on belts that follow the paper and on others."""

from functools import partial

import pytest

from sim.papers.gallas.judges.flux import g1, g2, g8, g13
from sim.papers.gallas.judges.onset import g14 as judge_g14
from tests.made.judging import letters
from tests.made.paper_belt import paper_point

#: The judge of the other reading, on frequencies in fine steps.
fine_g1 = partial(g1, step=2)

#: A judge at another threshold.
g14 = partial(judge_g14, threshold=0.02)

FREQUENCIES = (10, 15, *range(16, 31, 2), 25, 40, 50, 60, 80, 100)


def rows(name, values, frequencies=(20, 50, 80), scalars=None, **rest):
    """Return points at all frequencies and values of a parameter."""
    return [
        paper_point(scalars, **{name: value}, frequency=frequency, **rest)
        for value in values
        for frequency in frequencies
    ]


def base(**rest):
    """Return the row of frequencies with the paper's other parameters."""
    return [paper_point(frequency=frequency, **rest) for frequency in FREQUENCIES]


def replaced(points, scalars, **parameters):
    """Return points, one of them replaced by one with other scalars."""
    new = paper_point(scalars, **parameters)
    assert new.id in {point.id for point in points}
    return [new if point.id == new.id else point for point in points]


STIFF = (500, 700, 1000, 2000, 5000)


def halved(frequencies=(14, 14.5, 15, 15.5, 16, 17, 20, 80), **rest):
    """Return rows of the whole system and of half of it."""
    small = [
        paper_point(frequency=frequency, beads=100, width=10, **rest) for frequency in frequencies
    ]
    return small + [paper_point(frequency=frequency, **rest) for frequency in frequencies]


#: Many beds show what few cannot.
MANY = {"replicates": 8}


def bent(angle, velocity):
    """Return points at an angle with a velocity (m/s) of their own."""
    return rows("vibration_angle", (angle,), scalars={"velocity": velocity})


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g1, "R", lambda: base()),
    # On frequencies 10 Hz apart a dip between them does not show.
    (g1, "R", lambda: replaced(base(**MANY), {"velocity": 0.05}, frequency=25, **MANY)),
    (fine_g1, "N", lambda: replaced(base(**MANY), {"velocity": 0.05}, frequency=25, **MANY)),
    (g1, "N", lambda: replaced(base(**MANY), {"velocity": 0.1}, frequency=60, **MANY)),
    (g1, "I", lambda: base(scatter=1.5, replicates=3)),
    (g1, "-", lambda: [point for point in base() if point.parameters.frequency != 50]),
    (g2, "R", lambda: rows("vibration_angle", (30, 45, 60))),
    (g2, "N", lambda: [*rows("vibration_angle", (45,)), *bent(30, 1e-3), *bent(60, 0.5)]),
    (g2, "I", lambda: rows("vibration_angle", (30, 45, 60), scatter=3, replicates=2)),
    (g2, "-", lambda: rows("vibration_angle", (30, 45, 60), frequencies=(16,))),
    (g8, "R", lambda: rows("amplitude", (0.5, 1, 1.5), (25, 50))),
    (
        g8,
        "N",
        lambda: [
            *rows("amplitude", (0.5, 1), (25, 50)),
            *rows("amplitude", (1.5,), (25, 50), scalars={"velocity": 1e-3}),
        ],
    ),
    (g8, "I", lambda: rows("amplitude", (0.5, 1, 1.5), (25, 50), scatter=3, replicates=2)),
    (g8, "-", lambda: rows("amplitude", (0.5, 1))),
    (g13, "R", lambda: rows("stiffness", STIFF)),
    (
        g13,
        "N",
        lambda: replaced(rows("stiffness", STIFF), {"velocity": 0.4}, frequency=80, stiffness=5000),
    ),
    (g13, "I", lambda: rows("stiffness", STIFF, scatter=0.2)),
    # One that was not run leaves the claim open, and the limit itself is reported.
    (g13, "I", lambda: rows("stiffness", (500, 1000, 2000, 5000))),
    (
        g13,
        "R",
        lambda: replaced(rows("stiffness", STIFF), {"velocity": 0.1}, frequency=20, stiffness=500),
    ),
    (g13, "-", lambda: rows("stiffness", (500, 1000))),
    (g14, "R", lambda: halved()),
    (g14, "N", lambda: replaced(halved(), {"velocity": 0.2}, frequency=80, beads=100, width=10)),
    (g14, "-", lambda: base()),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
