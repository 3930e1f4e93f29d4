"""Judges of claims about velocity and agitation over height, and about density waves."""

import numpy as np
import pytest

from sim.papers.gallas.judges.velocity import g21, g22, g23, g29, g30
from tests.made.judging import letters
from tests.made.paper_belt import BEAD, paper_point, temperature_profile, velocity_profile

FREQUENCIES = (10, 20, 60, 80)


def row(frequencies=FREQUENCIES, profiles=None, **rest):
    """Return points at several frequencies; ``profiles`` replaces profiles by frequency."""
    return [
        paper_point(profiles=(profiles or {}).get(frequency), frequency=frequency, **rest)
        for frequency in frequencies
    ]


def started(fast_lag=0.0, long_lag=0.1, short_lag=0.4, initial=20.0, scatter=1e-3):
    """Return runs from rest under both protocols, and fast starts, with lags at the top."""
    points = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping, "scatter": scatter}
        for lag, rest in (
            (short_lag, {"protocol": "published"}),
            (long_lag, {"protocol": "converged"}),
            (fast_lag, {"protocol": "published", "initial_velocity": initial}),
        ):
            usual = paper_point(**where, **rest)
            profile = velocity_profile(usual.parameters, lag)
            points.append(paper_point(profiles={"velocity_profile": profile}, **where, **rest))
    return points


def angles(values=(30, 45, 60, 90), **rest):
    """Return points at several angles."""
    return [paper_point(frequency=60, vibration_angle=angle, **rest) for angle in values]


def waves(early, later=2.0, **rest):
    """Return points with a power of density waves in the first cycles, and another later."""
    usual = {"early_wave_power": early, "wave_power": later}
    loose = {"vibration_angle": 30, "damping": 10, "shear_damping": 10}
    return [
        paper_point(usual, frequency=40, **rest),
        paper_point(usual, frequency=40, **loose, **rest),
    ]


#: A bed that has not relaxed, one at 20 Hz, and few beds that differ.
YOUNG = paper_point(frequency=80, damping=10, shear_damping=10)
HOT = paper_point(frequency=20)
FEW = {"scatter": 3, "replicates": 2}

#: Velocities that fall with the frequency.
EVEN = {f: {"velocity_profile": lambda z, v=v: v + 0 * z} for f, v in ((10, 1.0), (80, 1e-4))}


#: A wave of its own in the velocity of each bed.
WAVES = 0.2 + 0.2 * np.array([[0.2], [-0.2], [0.3], [-0.1], [0.05]]) * np.sin(
    2 * np.arange(200) + 1
)


def profile(velocity):
    """Return a velocity over height of the bed at 60 Hz."""
    return {60: {"velocity_profile": velocity}}


def heat(temperature):
    """Return a temperature over height of the bed at 20 Hz."""
    return {20: {"fluctuation_temperature_profile": np.array(temperature)}}


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g21, "aR bR cR", lambda: [*row(), YOUNG]),
    (g21, "aN bR cN", lambda: [*row(profiles=profile(lambda z: 0.02 * z / BEAD)), YOUNG]),
    (
        g21,
        "aR bN cN",
        lambda: [
            *row(profiles=profile(velocity_profile(row((60,))[0].parameters, lag=-0.3))),
            YOUNG,
        ],
    ),
    (g21, "aI bI", lambda: row(profiles=profile(WAVES))),
    # Of runs that have relaxed no fall is asked for.
    (g21, "aR bR", lambda: row()),
    (g21, "-", lambda: row((20, 60))),
    (g22, "R", lambda: started()),
    (g22, "N", lambda: started(fast_lag=0.3)),
    (g22, "N", lambda: started(long_lag=0.6)),
    (g22, "-", lambda: started(initial=0.1)),
    (g23, "R", lambda: [*row((10, 20, 80)), *angles()]),
    (g23, "N", lambda: [*row((10, 20, 80), EVEN), *angles()]),
    (g23, "I", lambda: [*row((10, 20, 80), **FEW), *angles(**FEW)]),
    (g23, "-", lambda: [*row((10, 20, 80)), *angles((30, 45, 60))]),
    (g29, "R", lambda: row((18, 20))),
    (g29, "N", lambda: row((18, 20), heat(0.05 * np.exp(-HOT.height / BEAD)))),
    (
        g29,
        "I",
        lambda: row(
            (18, 20),
            heat(
                [
                    *[temperature_profile(HOT.parameters)(HOT.height)] * 3,
                    *[np.full_like(HOT.height, 0.02)] * 2,
                ]
            ),
        ),
    ),
    (g29, "-", lambda: row((20,))),
    (g30, "aR bR", lambda: waves(4.0, scatter=0.01)),
    (g30, "aN bN", lambda: waves(1.6, scatter=0.01)),
    (g30, "aI bI", lambda: waves(2.2, scatter=0.5)),
    (g30, "-", lambda: waves(4.0)[:1]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
