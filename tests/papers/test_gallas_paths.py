"""Judges of claims about paths of beads, snapshots and the obstacle."""

from functools import partial
from math import nan

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
from sim.papers.gallas.judges.obstacle import g31, g33, g34
from sim.papers.gallas.judges.paths import g24, g25, g32
from sim.papers.gallas.judges.snapshots import g26, g27, g28
from tests.made.judging import by_part, checks_of, verdict_of
from tests.made.paper_belt import BEAD, paper_point, velocity

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


def behind_obstacle(scalars=None, **rest):
    """Return points at 80 Hz with an obstacle, and without it at 80 and 20 Hz."""
    return [
        paper_point(scalars, frequency=80, obstacle=1.5, **rest),
        paper_point(frequency=80, **rest),
        paper_point(frequency=20, **rest),
    ]


def test_paths_behind_an_obstacle():
    assert verdict_of(g32, behind_obstacle()) == REPRODUCED
    low = {"path_vertical": 1e-4, "path_drift": 1e-3}
    assert verdict_of(g32, behind_obstacle(low)) == NOT_REPRODUCED
    with pytest.raises(Untestable, match=r"obstacle 1\.5"):
        checks_of(g32, behind_obstacle()[1:])
    with pytest.raises(Untestable, match="backwards"):
        checks_of(g32, behind_obstacle({"path_drift": -1e-3}))


def test_slower_paths_as_flat_as_before_are_not_those_at_20_hz():
    flat = paper_point(frequency=80).scalars["path_vertical"]
    checks = checks_of(g32, behind_obstacle({"path_vertical": flat, "path_drift": 1e-4}))
    assert [check.verdict for check in checks] == [REPRODUCED, REPORTED]


def test_paths_halfway_decide_nothing():
    half = {"path_vertical": 0.84e-3, "path_drift": 3.6e-3}
    assert verdict_of(g32, behind_obstacle(half, scatter=0.2)) == INCONCLUSIVE


LOOSE = {"frequency": 40, "vibration_angle": 30, "damping": 10, "shear_damping": 10}
SNAPSHOTS = {"a": {"frequency": 10, "vibration_angle": 60}, "b": LOOSE, "c": {"frequency": 100}}


def snapshots(changed="", scalars=None, profiles=None, **rest):
    """Return the points of Figs. 5a to 5c, the one of panel ``changed`` with other data."""
    return [
        paper_point(
            scalars if name == changed else None,
            profiles if name == changed else None,
            **parameters,
            **rest,
        )
        for name, parameters in SNAPSHOTS.items()
    ]


def test_block_holes_and_void():
    assert verdict_of(g26, snapshots()) == REPRODUCED
    assert verdict_of(g26, snapshots(scatter=0.6)) == INCONCLUSIVE
    # What has no runs has no checks.
    assert {check.part for check in checks_of(g26, snapshots()[::2])} == {"a", "c"}


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
    assert verdict_of(g26, snapshots(panel, scalars, profiles)) == NOT_REPRODUCED


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
    assert verdict_of(g27, occupied(*shares)) == verdict


def test_a_void_is_one_at_the_beginning_of_the_cycle_too():
    lacking = occupied(0.1, 0.005, 0.001, phase=None)
    assert verdict_of(g27, lacking) == INCONCLUSIVE
    assert verdict_of(g27, occupied(0.1, 0.005, 0.001, phase=0.08)) == NOT_REPRODUCED


def test_what_makes_a_void_is_a_number_of_ours():
    points = occupied(0.1, 0.025, 0.001)
    assert verdict_of(partial(g27, max_occupancy=0.02), points) == NOT_REPRODUCED


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


SIZES = (0, 0.5, 1.5, 2.5)


def obstacles(velocities=None, sizes=SIZES, **rest):
    """Return points at two frequencies and several diameters, with velocities (m/s) if given."""
    scalars_by_size = (
        [None] * len(sizes) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, obstacle=size, **rest)
        for frequency in (20, 80)
        for size, scalars in zip(sizes, scalars_by_size, strict=True)
    ]


def test_an_obstacle_slows_the_flow():
    assert verdict_of(g31, obstacles()) == REPRODUCED
    assert verdict_of(g31, obstacles([0.3, 0.25, 0.1, 0.05])) == NOT_REPRODUCED
    assert verdict_of(g31, obstacles([0.3, 0.1, 0.2, 0.05], replicates=8)) == REPRODUCED
    assert verdict_of(g31, obstacles(scatter=0.5)) == INCONCLUSIVE
    with pytest.raises(Untestable, match=r"obstacle 2\.5"):
        checks_of(g31, obstacles(sizes=SIZES[:-1]))


@pytest.mark.parametrize(
    ("share", "verdict"),
    [
        (0.001, REPRODUCED),
        (0.05, NOT_REPRODUCED),
        ([0.0, 0.02, 0.005, 0.03, 0.001], INCONCLUSIVE),
    ],
)
def test_no_turbulence(share, verdict):
    points = [paper_point({"backflow": share}, frequency=80, obstacle=size) for size in (1.5, 2.5)]
    assert verdict_of(g33, points) == verdict
    with pytest.raises(Untestable, match=r"obstacle 2\.5"):
        checks_of(g33, points[:1])


def blocked(local, scatter=1e-3, far_height=1.2):
    """Return beds with and without an obstacle, slowed everywhere or only close to it.

    Behind it the paths are 1.2 times as high as without it, and ``far_height`` times as high far
    away.
    """
    points = []
    for frequency in (20, 80):
        free = paper_point(frequency=frequency)
        speed = velocity(free.parameters)

        def along(column, speed=speed):
            near = np.abs(column - 10 * BEAD) < 4 * BEAD
            return speed * np.where(near, 0.4, 1.0 if local else 0.5)

        height = free.scalars["path_vertical"].mean()
        scalars = {"path_vertical": 1.2 * height, "path_vertical_far": far_height * height}
        profiles = {"column_velocity": along}
        stopped = paper_point(scalars, profiles, frequency=frequency, obstacle=1.5, scatter=scatter)
        points += [free, stopped]
    return points


def test_the_effect_spreads_over_the_system():
    assert verdict_of(g34, blocked(local=False)) == REPRODUCED
    # The shape changes nowhere but close to the obstacle.
    assert verdict_of(g34, blocked(local=True, far_height=1.0)) == NOT_REPRODUCED
    assert verdict_of(g34, blocked(local=False, scatter=1.5)) == INCONCLUSIVE
    with pytest.raises(Untestable, match=r"obstacle 1\.5"):
        checks_of(g34, blocked(local=False)[::2])


def test_paths_that_change_only_close_to_the_obstacle_are_no_effect_on_the_system():
    checks = checks_of(g34, blocked(local=False, far_height=0.5))
    assert [check.verdict for check in checks] == [NOT_REPRODUCED, REPORTED] * 2


def test_shares_of_the_slow_down_are_taken_bed_by_bed():
    uneven = np.array([0.1, 0.2, 0.3, 0.4, 0.5])[:, None]
    points = []
    for frequency in (20, 80):
        shape = np.where(np.abs(np.arange(20) - 9.5) < 5, 0.4, 0.5)
        for size, slowed in ((0, np.ones(20)), (1.5, shape)):
            profiles = {"column_velocity": uneven * slowed}
            points.append(paper_point(profiles=profiles, frequency=frequency, obstacle=size))
    check = checks_of(g34, points)[1]
    assert check.value == pytest.approx(0.25 / 0.55)
    assert check.half_width == pytest.approx(0, abs=1e-9)


def test_a_uniform_slow_down_has_half_of_it_far_away():
    points = [
        paper_point(frequency=frequency, obstacle=size)
        for frequency in (20, 80)
        for size in (0, 1.5)
    ]
    assert checks_of(g34, points)[1].value == pytest.approx(0.5)
