"""Judges of claims about the mean velocity, on belts that follow the paper and on others."""

from functools import partial

import pytest

from sim.claims.evidence import Evidence
from sim.claims.verdict import INCONCLUSIVE, REPORTED, REPRODUCED, Untestable
from sim.papers.gallas.judges.flux import g1, g2, g8, g13
from sim.papers.gallas.judges.onset import g14 as judge_g14
from tests.made.judging import checks_of, headline_bounds, letters, verdict_of
from tests.made.paper_belt import paper_point
from tests.made.results import made_results

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


def test_a_fine_grid_of_too_wide_steps_decides_nothing():
    """From 20 to 30 Hz the grid is one of 5 Hz: a fall between may be missed, or not be one."""
    wide = [
        point for point in base(replicates=8) if point.parameters.frequency not in (22, 24, 26, 28)
    ]
    for points in (wide, replaced(wide, {"velocity": 0.05}, replicates=8, frequency=25)):
        fine, coarse = checks_of(fine_g1, points)[:2]
        assert (coarse.verdict, fine.verdict) == (REPORTED, INCONCLUSIVE)
        assert verdict_of(g1, points) == REPRODUCED
        assert fine.withheld == "frequencies up to 2 Hz apart"
    # Above 30 Hz any steps will do.
    gap = [point for point in base() if point.parameters.frequency != 28]
    assert verdict_of(fine_g1, gap) == INCONCLUSIVE


def test_angles_are_compared_from_20_hz_on_and_with_several_beds():
    points = rows("vibration_angle", (30, 45, 60))
    slow = rows("vibration_angle", (30, 45, 60), frequencies=(16,))
    single = rows("vibration_angle", (30, 45, 60), frequencies=(60,), replicates=1)
    check, likely = checks_of(g2, points + slow + single)
    assert likely.verdict == REPORTED and likely.value == 1
    assert "3 frequencies from 20 Hz on" in check.what
    with pytest.raises(Untestable, match="20 Hz"):
        checks_of(g2, slow + single)


STIFF = (500, 700, 1000, 2000, 5000)


def test_with_the_restitution_kept_stiffer_beads_are_compared_with_the_usual_ones():
    usual = [paper_point({"velocity": 0.1}, frequency=f) for f in (20, 50, 80)]
    stiff = {"stiffness_keeps": "restitution"}
    stiffer = [
        paper_point({"velocity": 0.1}, frequency=f, stiffness=y, **stiff)
        for f in (20, 50, 80)
        for y in (700, 2000, 5000)
    ]
    evidence = Evidence(made_results(*usual, *stiffer), "published", stiff)
    judged = g13(evidence, **headline_bounds(g13))
    checks = [check for check in judged if check.what.startswith("change of V")]
    assert len(checks) == 9 and {check.verdict for check in checks} == {REPRODUCED}


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
