"""Judges of claims on what the steady velocity depends on."""

import pytest

from sim.papers.gallas.judges.steady import g37, g38, g39
from tests.made.paper_belt import paper_point
from tests.made.results import letters

ANGLES = (30, 45, 60)


def angles(velocity=None, **rest):
    """Return points at three angles, at one of them and 25 Hz with a velocity (m/s)."""
    changed = (30, 25)
    return [
        paper_point(
            {"velocity": velocity} if velocity and (angle, f) == changed else None,
            vibration_angle=angle,
            frequency=f,
            **rest,
        )
        for angle in ANGLES
        for f in (20, 25, 80)
    ]


CURVES = (
    *({"vibration_angle": angle} for angle in (30, 60)),
    *({"damping": g, "shear_damping": shear} for g, shear in ((0, 50), (10, 10), (50, 100))),
    *({"amplitude": amplitude} for amplitude in (0.5, 1.5)),
)


def curves(velocities=None, which=0, among=CURVES, **rest):
    """Return the curves of Figs. 1a and 1b, one with some velocities (m/s) by frequency (Hz)."""
    return [
        paper_point(
            {"velocity": velocities[f]}
            if curve is CURVES[which] and f in (velocities or {})
            else {},
            frequency=f,
            **curve,
            **rest,
        )
        for curve in among
        for f in (15, 18, 40, 60, 80, 100)
    ]


def started(faster=1.0, **rest):
    """Return beds that start at rest and ones that start fast, which end ``faster``."""
    points = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping, **rest}
        rest_point = paper_point(**where)
        velocity = faster * rest_point.scalars["velocity"]
        points += [rest_point, paper_point({"velocity": velocity}, initial_velocity=20, **where)]
    return points


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g37, "R", lambda: angles()),
    (g37, "N", lambda: angles(velocity=0.05)),
    (g37, "I", lambda: angles(scatter=0.3)),
    (g37, "-", lambda: angles()[:6]),
    (g38, "aR bR", lambda: curves()),
    # At once as fast as ever, and in steps.
    (g38, "aN bR", lambda: curves({15: 0.1, 18: 0.11})),
    (g38, "aR bN", lambda: curves({40: 0.2, 60: 0.2, 80: 0.2, 100: 0.5})),
    (g38, "aR bN", lambda: curves({40: 0.2, 60: 0.2, 80: 0.2, 100: 0.5}, which=-1)),
    (g38, "aR bI", lambda: curves({40: 0.2, 60: 0.27, 80: 0.26, 100: 0.36}, scatter=0.2)),
    (g38, "aI bR", lambda: curves(among=CURVES[:-1], scatter=1.5)),
    (g38, "aR bR", lambda: curves(among=CURVES[:-1])),
    (g39, "R", lambda: started()),
    (g39, "N", lambda: started(1.2)),
    (g39, "I", lambda: started(1.05)),
    (g39, "-", lambda: started()[:2]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
