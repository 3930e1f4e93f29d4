"""Judges of claims about snapshots."""

from functools import partial
from math import nan

import pytest

from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.papers.gallas.judges.snapshots import g26, g27, g28
from tests.made.judging import by_part, checks_of, verdict_of
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


def test_block_holes_and_void():
    assert verdict_of(g26, panels()) == REPRODUCED
    assert verdict_of(g26, panels(scatter=0.6)) == INCONCLUSIVE
    # What has no runs has no checks.
    assert {check.part for check in checks_of(g26, panels()[::2])} == {"a", "c"}


@pytest.mark.parametrize(
    ("panel", "scalars", "profiles"),
    [
        ("a", {"path_vertical": 2e-4}, None),
        ("a", None, {"granular_temperature_profile": lambda height: 1e-2 + 0 * height}),
        ("b", None, {"granular_temperature_profile": lambda height: 1e-4 + 0 * height}),
        ("b", None, {"packing_profile": lambda height: 0.95 + 0 * height}),
        ("c", {"base_occupancy_at_phase_0": 0.1}, None),
    ],
)
def test_other_pictures_are_not_those_of_the_paper(panel, scalars, profiles):
    assert verdict_of(g26, panels(panel, scalars, profiles)) == NOT_REPRODUCED


def test_a_picture_is_one_of_the_beginning_of_the_cycle():
    """How many beads there are in the mean over the cycle is another statement."""
    assert verdict_of(g26, panels("c", {"base_occupancy": 0.1})) == REPRODUCED
    lacking = panels("c", {"base_occupancy_at_phase_0": nan})
    assert by_part(checks_of(g26, lacking)) == {"a": REPRODUCED, "b": REPRODUCED, "c": INCONCLUSIVE}


def occupied(*shares, frequencies=(20, 80, 100), phase=0.01):
    """Return points with shares of the beads near the mean belt position.

    ``phase`` is the share at the beginning of the cycle, if any.
    """
    early = {"base_occupancy_at_phase_0": nan if phase is None else phase}
    return [
        paper_point({"base_occupancy": share} | early, frequency=frequency)
        for frequency, share in zip(frequencies, shares, strict=True)
    ]


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.1, 0.005, 0.001), REPRODUCED),
        ((0.1, 0.05, 0.001), NOT_REPRODUCED),
        # How many there are at 20 Hz is reported.
        ((0.01, 0.005, 0.001), REPRODUCED),
        ((0.1, 0.025, 0.001), REPRODUCED),
        ((0.1, [0.005, 0.05, 0.01, 0.02, 0.02], 0.001), INCONCLUSIVE),
    ],
)
def test_a_void_within_the_belts_reach(shares, verdict):
    assert by_part(checks_of(g27, occupied(*shares))) == {"a": verdict, "b": REPRODUCED}


@pytest.mark.parametrize(
    ("phase", "verdict"), [(None, INCONCLUSIVE), (0.01, REPRODUCED), (0.08, NOT_REPRODUCED)]
)
def test_a_void_at_the_beginning_of_the_cycle_is_another_part(phase, verdict):
    checks = checks_of(g27, occupied(0.1, 0.005, 0.001, phase=phase))
    assert by_part(checks) == {"a": REPRODUCED, "b": verdict}


def test_what_makes_a_void_is_a_number_of_ours():
    checks = checks_of(partial(g27, max_occupancy=0.02), occupied(0.1, 0.025, 0.001))
    assert by_part(checks) == {"a": NOT_REPRODUCED, "b": REPRODUCED}


def test_a_void_needs_all_frequencies():
    with pytest.raises(Untestable, match="frequency 100"):
        checks_of(g27, occupied(0.1, 0.001, frequencies=(20, 80)))


def test_more_friction_more_compact():
    firm, soft = paper_point(frequency=100), paper_point(frequency=100, damping=1)
    assert verdict_of(g28, [firm, soft]) == REPRODUCED
    dense = paper_point(
        profiles={"packing_profile": lambda height: 0.8 * (height < 20 * BEAD)},
        frequency=100,
        damping=1,
    )
    assert verdict_of(g28, [firm, dense]) == NOT_REPRODUCED
    noisy = [paper_point(frequency=100, damping=damping, scatter=0.5) for damping in (50, 1)]
    assert verdict_of(g28, noisy) == INCONCLUSIVE
    with pytest.raises(Untestable, match="damping 1"):
        checks_of(g28, [firm])
