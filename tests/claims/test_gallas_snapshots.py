"""Judges of claims about snapshots."""

import pytest

from sim.claims.gallas_snapshots import g26, g27, g28
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from tests.made.paper_belt import BEAD, checks_of, published, verdict_of

LOOSE = {"frequency": 40, "vibration_angle": 30, "damping": 10, "shear_damping": 10}
PANELS = {"a": {"frequency": 10, "vibration_angle": 60}, "b": LOOSE, "c": {"frequency": 100}}


def panels(changed="", scalars=None, profiles=None, **rest):
    """Return the points of Figs. 5a to 5c; that of one panel is another."""
    return [
        published(
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
    with pytest.raises(Untestable, match="vibration_angle 30"):
        checks_of(g26, panels()[::2])


@pytest.mark.parametrize(
    ("panel", "scalars", "profiles"),
    [
        ("a", {"path_vertical": 2e-4}, None),
        ("a", None, {"granular_temperature_profile": lambda height: 1e-2 + 0 * height}),
        ("b", None, {"granular_temperature_profile": lambda height: 1e-4 + 0 * height}),
        ("b", None, {"packing_profile": lambda height: 0.95 + 0 * height}),
        ("c", {"base_occupancy": 0.1}, None),
    ],
)
def test_other_pictures_are_not_those_of_the_paper(panel, scalars, profiles):
    assert verdict_of(g26, panels(panel, scalars, profiles)) == NOT_REPRODUCED


def occupied(*shares, frequencies=(20, 80, 100)):
    """Return points with shares of the beads near the mean belt position."""
    return [
        published({"base_occupancy": share}, frequency=frequency)
        for frequency, share in zip(frequencies, shares, strict=True)
    ]


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.1, 0.005, 0.001), REPRODUCED),
        ((0.1, 0.05, 0.001), NOT_REPRODUCED),
        ((0.01, 0.005, 0.001), NOT_REPRODUCED),
        ((0.1, [0.005, 0.05, 0.01, 0.02, 0.02], 0.001), INCONCLUSIVE),
    ],
)
def test_a_void_within_the_belts_reach(shares, verdict):
    assert verdict_of(g27, occupied(*shares)) == verdict


def test_a_void_needs_all_frequencies():
    with pytest.raises(Untestable, match="frequency 100"):
        checks_of(g27, occupied(0.1, 0.001, frequencies=(20, 80)))


def test_more_friction_more_compact():
    firm, soft = published(frequency=100), published(frequency=100, damping=1)
    assert verdict_of(g28, [firm, soft]) == REPRODUCED
    dense = published(
        profiles={"packing_profile": lambda height: 0.8 * (height < 20 * BEAD)},
        frequency=100,
        damping=1,
    )
    assert verdict_of(g28, [firm, dense]) == NOT_REPRODUCED
    noisy = [published(frequency=100, damping=each, scatter=0.5) for each in (50, 1)]
    assert verdict_of(g28, noisy) == INCONCLUSIVE
    with pytest.raises(Untestable, match="damping 1"):
        checks_of(g28, [firm])
