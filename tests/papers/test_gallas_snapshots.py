"""Judges of claims about snapshots."""

from math import nan

import pytest

from sim.papers.gallas.judges.snapshots import g26, g27, g28
from tests.made.judging import letters
from tests.made.paper_belt import BEAD, paper_point

LOOSE = {"frequency": 40, "vibration_angle": 30, "damping": 10, "shear_damping": 10}
PANELS = {"a": {"frequency": 10, "vibration_angle": 60}, "b": LOOSE, "c": {"frequency": 100}}


def panels(changed="", scalars=None, profiles=None, **rest):
    """Return the points of Figs. 5a to 5c, the one of panel ``changed`` with other data."""
    return [
        paper_point(
            scalars if name == changed else None,
            profiles if name == changed else None,
            **parameters,
            **rest,
        )
        for name, parameters in PANELS.items()
    ]


def occupied(*shares, frequencies=(20, 80, 100), phase=0.01):
    """Return points with shares of the beads near the mean belt position, and at phase 0."""
    early = {"base_occupancy_at_phase_0": nan if phase is None else phase}
    return [
        paper_point({"base_occupancy": share} | early, frequency=frequency)
        for frequency, share in zip(frequencies, shares, strict=True)
    ]


def firm_and_soft(profiles=None, **rest):
    """Return beds at two coefficients of damping; the softer one may have other profiles."""
    soft = paper_point(profiles=profiles, frequency=100, damping=1, **rest)
    return [paper_point(frequency=100, **rest), soft]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g26, "aR bR cR", lambda: panels()),
    (g26, "aN bR cR", lambda: panels("a", {"path_vertical": 2e-4})),
    (
        g26,
        "aR bN cR",
        lambda: panels("b", None, {"packing_profile": lambda height: 0.95 + 0 * height}),
    ),
    (g26, "aR bR cN", lambda: panels("c", {"base_occupancy_at_phase_0": 0.1})),
    (g26, "aR cR", lambda: panels()[::2]),
    (g27, "aR bR", lambda: occupied(0.1, 0.005, 0.001)),
    (g27, "aN bR", lambda: occupied(0.1, 0.05, 0.001)),
    (g27, "aI bR", lambda: occupied(0.1, [0.005, 0.05, 0.01, 0.02, 0.02], 0.001)),
    (g27, "aR bI", lambda: occupied(0.1, 0.005, 0.001, phase=None)),
    (g27, "aR bN", lambda: occupied(0.1, 0.005, 0.001, phase=0.08)),
    (g27, "-", lambda: occupied(0.1, 0.001, frequencies=(20, 80))),
    (g28, "R", lambda: firm_and_soft()),
    (
        g28,
        "N",
        lambda: firm_and_soft({"packing_profile": lambda height: 0.8 * (height < 20 * BEAD)}),
    ),
    (g28, "I", lambda: firm_and_soft(scatter=0.5)),
    (g28, "-", lambda: firm_and_soft()[:1]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
