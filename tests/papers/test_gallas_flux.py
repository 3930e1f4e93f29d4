"""Judges of claims about the mean velocity and the onset of transport."""

from functools import partial

import numpy as np
import pytest

from sim.claims.evidence import Evidence
from sim.papers.gallas.judges.flux import g1, g2, g8, g13
from sim.papers.gallas.judges.onset import find_onset, g3, g4, g5, g6, g7, g35
from sim.papers.gallas.judges.onset import g14 as judge_g14
from sim.parameters.belt import ONSET_TRANSPORT
from tests.made.paper_belt import paper_point
from tests.made.results import letters, made_boundary, made_results

#: A judge at another threshold.
g14 = partial(judge_g14, threshold=0.02)

ALL_FREQUENCIES = (10, 15, *range(16, 31, 2), 25, 40, 50, 60, 80, 100)


def rows(name, values, frequencies=(20, 50, 80), scalars=None, **rest):
    """Return points at all frequencies and values of a parameter."""
    return [
        paper_point(scalars, **{name: value}, frequency=frequency, **rest)
        for value in values
        for frequency in frequencies
    ]


def base(**rest):
    """Return the row of frequencies with the paper's other parameters."""
    return [paper_point(frequency=frequency, **rest) for frequency in ALL_FREQUENCIES]


#: Parameters of the curves of Figs. 1a and 1b but the usual one.
OTHERS = (
    *({"vibration_angle": angle} for angle in (30, 60)),
    *({"amplitude": amplitude} for amplitude in (0.5, 1.5)),
    {"damping": 0},
    {"damping": 10, "shear_damping": 10},
    {"shear_damping": 100},
)


def curves(**rest):
    """Return all curves of Figs. 1a and 1b."""
    flowing = (20, 25, 30, 40, 60, 80, 100)
    others = [
        paper_point(frequency=frequency, **other, **rest)
        for other in OTHERS
        for frequency in flowing
    ]
    return [*base(**rest), *others]


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

#: So few that scatter so much tell little.
FEW = {"replicates": 3, "scatter": 0.3}


def bent(angle, velocity):
    """Return points at an angle with a velocity (m/s) of their own."""
    return rows("vibration_angle", (angle,), scalars={"velocity": velocity})


#: The share of A_x ω that counts as transport, that of boundaries.
LEAST = ONSET_TRANSPORT

SCAN = (14, 15, 15.5, 16, 16.5, 17, 18, 20)
FINE = (*SCAN[:-1], 18.5, 19, 19.5, 20)
PAIRS = ((50, 50), (0, 50), (10, 10), (50, 100), (10, 50))

#: Velocity (m/s) well above a tenth of the belt's.
MOVING = 0.15


def scan(frequencies=SCAN, **parameters):
    """Return a row of frequencies."""
    return [paper_point(frequency=frequency, **parameters) for frequency in frequencies]


def early(start, frequencies=SCAN, **parameters):
    """Return a row of frequencies with transport from ``start`` (Hz) on."""
    return [
        paper_point(
            {"velocity": MOVING if frequency >= start else 0.0}, frequency=frequency, **parameters
        )
        for frequency in frequencies
    ]


def boundary(low, high, **parameters):
    """Return an onset found by refinement, from two seeds."""
    return [
        made_boundary("belt", "transport", "frequency", low, high, seed=seed, **parameters)
        for seed in (1, 2)
    ]


def onset_interval(points, boundaries=()):
    """Return value and half width (Hz) of the onset at the paper's parameters."""
    evidence = Evidence(made_results(*points, boundaries=boundaries), "published")
    value = find_onset(evidence, LEAST).frequency
    return value.nominal_value, 1.96 * value.std_dev


def crossing(low, high, share):
    """Return where a straight line from rest to a share of the belt's speed passes `LEAST`."""
    return low + (high - low) * LEAST / share


def test_a_scan_finds_where_the_mean_passes_a_tenth_of_the_belt():
    speed = 1e-3 * 2 * np.pi * 16
    points = early(16)
    value, half_width = onset_interval(points)
    assert value == pytest.approx(crossing(15.5, 16, MOVING / speed))
    assert half_width == pytest.approx(0.25)


def test_boundaries_serve_where_they_tell_it_better():
    point = [paper_point(frequency=30)]
    # Its ends are bounds of one side.
    bound = 0.125 * 1.96 / 1.645
    assert onset_interval(point, boundary(15.0, 15.25)) == pytest.approx((15.125, bound), rel=1e-3)
    two = [boundary(15.0, 15.25)[0], boundary(16.0, 16.25)[1]]
    value, half_width = onset_interval(point, two)
    assert value == pytest.approx(15.625)
    assert half_width == pytest.approx(12.7 * 0.5, rel=0.01)
    interval = onset_interval(early(16), boundary(15.5, 15.75))
    assert interval == pytest.approx((15.625, bound), rel=1e-3)


def scans(start=None):
    """Return scans at three scans; with ``start`` the flattest begins to flow there."""
    flat = early(start, FINE, vibration_angle=30) if start else scan(vibration_angle=30)
    return [*flat, *scan(), *scan(vibration_angle=60)]


def damped(last):
    """Return the onsets at five pairs of damping, the last one chosen."""
    return [
        boundary_row
        for (damping, shear), low in zip(PAIRS, (15.5, 15.75, 15.5, 15.75, last), strict=True)
        for boundary_row in boundary(low, low + 0.25, damping=damping, shear_damping=shear)
    ]


SHARP = (14, 15, 15.5, 16, 16.5, 17, 18, 20, 25, 40, 80)


def sweeps(down=15.75, **rest):
    """Return a scan and a boundary of the sweep down."""
    points = scan(SHARP, **rest)
    return points, boundary(down, down + 0.25, prior_frequency=25)


#: Frequencies (Hz) of half the amplitude.
SMALL = (15, 16, 17, 17.5, 18, 19, 20)


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g1, "aR bR", lambda: curves()),
    # One reversal refutes a rise, of whichever curve.
    (g1, "aN bR", lambda: replaced(curves(**MANY), {"velocity": 0.05}, frequency=25, **MANY)),
    (
        g1,
        "aN bR",
        lambda: replaced(curves(**MANY), {"velocity": 0.05}, frequency=60, amplitude=1.5, **MANY),
    ),
    # The others have to be known where none is seen.
    (g1, "aI bR", lambda: base()),
    (g1, "aN bR", lambda: replaced(base(**MANY), {"velocity": 0.05}, frequency=25, **MANY)),
    (g1, "aN bN", lambda: replaced(curves(**MANY), {"velocity": 0.1}, frequency=60, **MANY)),
    (g1, "aI bI", lambda: replaced(curves(**FEW), {"velocity": 0.26}, frequency=60, **FEW)),
    (g2, "R", lambda: rows("vibration_angle", (30, 45, 60))),
    (g2, "N", lambda: [*rows("vibration_angle", (45,)), *bent(30, 1e-3), *bent(60, 0.5)]),
    (g2, "I", lambda: rows("vibration_angle", (30, 45, 60), scatter=3, replicates=2)),
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
    (g14, "R", lambda: halved()),
    (g14, "N", lambda: replaced(halved(), {"velocity": 0.2}, frequency=80, beads=100, width=10)),
    (g3, "R", lambda: scans()),
    (g3, "N", lambda: scans(start=19)),
    (g3, "I", lambda: scans(start=15.35)),
    (g4, "R", lambda: ([paper_point()], damped(15.75))),
    (g4, "N", lambda: ([paper_point()], damped(17))),
    (g4, "I", lambda: ([paper_point()], damped(16.5))),
    (g5, "aR bR", lambda: (scan((15, 20), amplitude=1.5), boundary(16, 16.25, amplitude=1.5))),
    (g5, "aI bR", lambda: (scan((15, 20), amplitude=1.5), boundary(15, 15.25, amplitude=1.5))),
    (g5, "aN bR", lambda: (scan((15, 20), amplitude=1.5), boundary(13, 13.25, amplitude=1.5))),
    (g5, "aR bN", lambda: (early(14, (15, 20), amplitude=1.5), boundary(16, 16.25, amplitude=1.5))),
    # The paper's 18 Hz is Γ = 0.64, its Γ = 0.8 is 20.1 Hz.
    (g6, "aR bN", lambda: scan(SMALL, amplitude=0.5)),
    (g6, "aN bR", lambda: (scan(SMALL, amplitude=0.5), boundary(20, 20.1, amplitude=0.5))),
    (g7, "R", lambda: ([paper_point()], boundary(15.75, 16))),
    (g7, "N", lambda: ([paper_point()], boundary(14, 14.25))),
    (g7, "I", lambda: ([paper_point()], boundary(15, 15.25))),
    (g7, "-", lambda: scan((17, 18, 20))),
    (g7, "-", lambda: scan((14, 15))),
    (g35, "R", lambda: sweeps()),
    (g35, "N", lambda: sweeps(down=13)),
    (g35, "I", lambda: sweeps(down=15)),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
