"""Judges of claims about the paths of the beads."""

import numpy as np
import pytest

from sim.papers.gallas.judges.paths import g24, g25, g32
from tests.made.judging import letters
from tests.made.paper_belt import paper_point

PANELS = {
    "a": {"frequency": 10},
    "steeper": {"frequency": 10, "vibration_angle": 60},
    "b": {"frequency": 10, "shear_damping": 1},
    "c": {"frequency": 20},
    "d": {"frequency": 80},
    "e": {"frequency": 80, "shear_damping": 0},
}


def panels(changed="", scalars=None, **rest):
    """Return the points of Fig. 4; that of one panel has other measures."""
    return [
        paper_point(scalars if name == changed else None, **parameters, **rest)
        for name, parameters in PANELS.items()
    ]


STREAMS = (
    {"vibration_angle": 30},
    {},
    {"vibration_angle": 60},
    {"damping": 10, "shear_damping": 10},
)


def streams(changed=None, **rest):
    """Return points at 80 Hz; those named by their place have paths of that height (m)."""
    return [
        paper_point(
            {"path_vertical": changed[index]} if index in (changed or {}) else None,
            frequency=80,
            **parameters,
            **rest,
        )
        for index, parameters in enumerate(STREAMS)
    ]


def blocked(scalars=None, **rest):
    """Return points at 80 Hz with an obstacle, and without it at 80 and 20 Hz."""
    return [
        paper_point(scalars, frequency=80, obstacle=1.5, **rest),
        paper_point(frequency=80, **rest),
        paper_point(frequency=20, **rest),
    ]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g24, "aR bR cR dR", lambda: panels()),
    (g24, "aN bR cR dR", lambda: panels("a", {"path_drift": 3e-4})),
    (g24, "aR bN cR dR", lambda: panels("b", {"path_tilt": np.radians(45)})),
    (g24, "aR bR cN dR", lambda: panels("c", {"path_drift": -1e-3})),
    (g24, "aR bR cR dN", lambda: panels("e", {"path_drift": 1e-3})),
    (g24, "aI bI cI dI", lambda: panels(scatter=1)),
    (g24, "bR cR dR", lambda: panels()[:1] + panels()[2:]),
    (g25, "aR bR", lambda: streams()),
    (g25, "aN bR", lambda: streams({0: 1e-2, 2: 1e-6})),
    (g25, "aR bN", lambda: streams({3: 1e-6})),
    (g25, "aR bI", lambda: streams({3: 3e-4}, replicates=2)),
    (g25, "-", lambda: streams()[1:2]),
    (g32, "R", lambda: blocked()),
    (g32, "N", lambda: blocked({"path_vertical": 1e-4, "path_drift": 1e-3})),
    (g32, "I", lambda: blocked({"path_vertical": 0.84e-3, "path_drift": 3.6e-3}, scatter=0.2)),
    (g32, "-", lambda: blocked()[1:]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
