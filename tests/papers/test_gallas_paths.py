"""Judges of claims about the paths of the beads."""

import numpy as np
import pytest

from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPORTED,
    REPRODUCED,
    Untestable,
    combined_verdict,
)
from sim.papers.gallas.judges.paths import g24, g25, g32
from tests.made.judging import by_part, checks_of, verdict_of
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


def test_from_ellipses_to_a_stream():
    assert verdict_of(g24, panels()) == REPRODUCED
    assert verdict_of(g24, panels(scatter=1)) == INCONCLUSIVE


@pytest.mark.parametrize(
    ("panel", "scalars", "wrong"),
    [
        ("a", {"path_drift": 3e-4}, "a"),
        ("a", {"path_tilt": np.radians(80)}, "a"),
        ("a", {"path_minor": 1e-5}, "a"),
        ("steeper", {"path_tilt": np.radians(40)}, "a"),
        ("b", {"path_tilt": np.radians(45)}, "b"),
        ("c", {"path_drift": -1e-3}, "c"),
        ("c", {"path_vertical": 1e-5}, "c"),
        ("e", {"path_drift": 1e-3}, "d"),
        ("e", {"path_tilt": np.radians(20)}, "d"),
    ],
)
def test_other_paths_are_not_those_of_the_paper(panel, scalars, wrong):
    verdicts = by_part(checks_of(g24, panels(panel, scalars)))
    assert verdicts == {part: NOT_REPRODUCED if part in wrong else REPRODUCED for part in "abcd"}


@pytest.mark.parametrize(
    ("missing", "tested"),
    [("a", "cd"), ("steeper", "bcd"), ("b", "acd"), ("c", "abd"), ("d", "abd"), ("e", "abc")],
)
def test_a_part_whose_panel_is_missing_is_not_tested(missing, tested):
    points = dict(zip(PANELS, panels(), strict=True))
    del points[missing]
    verdicts = by_part(checks_of(g24, list(points.values())))
    assert verdicts == dict.fromkeys(tested, REPRODUCED)


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


def test_what_makes_a_stream():
    def part_verdicts(points):
        checks = checks_of(g25, points)
        return [combined_verdict(check for check in checks if check.part == part) for part in "ab"]

    assert part_verdicts(streams()) == [REPRODUCED] * 2
    assert part_verdicts(streams({0: 1e-2, 2: 1e-6})) == [NOT_REPRODUCED, REPRODUCED]
    assert part_verdicts(streams({3: 1e-6})) == [REPRODUCED, NOT_REPRODUCED]
    assert part_verdicts(streams({3: 3e-4}, replicates=2))[1] == INCONCLUSIVE
    assert part_verdicts(streams()[:3])[0] == REPRODUCED
    with pytest.raises(Untestable, match="shear_damping 10"):
        checks_of(g25, streams()[1:2])


def blocked(scalars=None, **rest):
    """Return points at 80 Hz with an obstacle, and without it at 80 and 20 Hz."""
    return [
        paper_point(scalars, frequency=80, obstacle=1.5, **rest),
        paper_point(frequency=80, **rest),
        paper_point(frequency=20, **rest),
    ]


def test_paths_behind_an_obstacle():
    assert verdict_of(g32, blocked()) == REPRODUCED
    low = {"path_vertical": 1e-4, "path_drift": 1e-3}
    assert verdict_of(g32, blocked(low)) == NOT_REPRODUCED
    with pytest.raises(Untestable, match=r"obstacle 1\.5"):
        checks_of(g32, blocked()[1:])
    with pytest.raises(Untestable, match="backwards"):
        checks_of(g32, blocked({"path_drift": -1e-3}))


def test_slower_paths_as_flat_as_before_are_not_those_at_20_hz():
    flat = paper_point(frequency=80).scalars["path_vertical"]
    checks = checks_of(g32, blocked({"path_vertical": flat, "path_drift": 1e-4}))
    assert [check.verdict for check in checks] == [REPRODUCED, REPORTED]


def test_paths_halfway_decide_nothing():
    half = {"path_vertical": 0.84e-3, "path_drift": 3.6e-3}
    assert verdict_of(g32, blocked(half, scatter=0.2)) == INCONCLUSIVE
