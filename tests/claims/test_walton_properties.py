"""Judges of what the spheres are like: verdicts on flows that are right, wrong, few, scattered."""

from dataclasses import replace

import numpy as np
import pytest

from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.claims.walton_properties import w15, w16, w20, w21, w22
from tests.claims.judging import checks_on, failed, verdict_on
from tests.made.chute_flows import PACKING, RUNAWAY, SIZE, SLOPE, SPEEDS, base_flows, flow
from tests.made.results import SCATTER


@pytest.mark.parametrize("judge", [w15, w16, w20, w21, w22])
def test_the_base_case_alone_tests_nothing(judge):
    with pytest.raises(Untestable, match="no "):
        checks_on(judge, base_flows({1.24: 4.4, 5: 8.2}))


def ordered_flow(share, layers=0.6, **options):
    return flow(15, {"crystalline_share": share, "layer_order": layers}, **options)


def crystals(share=0.8, layers=0.6, spread=0.3, bumps=0.1, wide=0.75, scatter=0.01):
    """Flows with crystalline plugs and their three controls, in which the order is weaker."""
    options = {"scatter": scatter}
    return [
        ordered_flow(wide, layers, depth=10, cell=10, **options),
        *(ordered_flow(share, layers, depth=n, cell=5, **options) for n in (20, 40)),
        ordered_flow(share, depth=10, cell=5, **options),
        ordered_flow(spread, depth=10, cell=5, diameter_spread=0.1, **options),
        ordered_flow(bumps, depth=10, cell=5, bumps=1, **options),
    ]


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        ({}, 0),
        ({"share": 0.4, "wide": 0.35}, 3),
        ({"layers": 0.1}, 3),
        ({"spread": 0.85}, 1),
        ({"bumps": 0.85}, 1),
        ({"wide": 0.85}, 1),
    ],
)
def test_crystals_and_what_weakens_them(changes, wrong):
    checks = checks_on(w15, crystals(**changes))
    assert len(failed(checks)) == wrong
    assert verdict_on(w15, crystals(**changes)) == (NOT_REPRODUCED if wrong else REPRODUCED)


def test_crystals_of_uncertain_extent_decide_nothing():
    assert verdict_on(w15, crystals(scatter=0.6)) == INCONCLUSIVE


@pytest.mark.parametrize("control", [3, 4, 5])
def test_crystals_without_a_control_are_untestable(control):
    with pytest.raises(Untestable, match="no "):
        checks_on(w15, [one for k, one in enumerate(crystals()) if k != control])


def resilient(speeds=(13, 9, 7), depths=(1.4, 2, 2.9), n=5, **options):
    """Flows at one depth along the restitution."""
    return [
        flow(speed, {"shear_depth": depth * SIZE}, depth=n, restitution=e, **options)
        for e, speed, depth in zip((0.7, 0.85, 0.95), speeds, depths, strict=True)
    ]


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        ({}, 0),
        ({"speeds": (7, 9, 13)}, 3),
        ({"speeds": (9, 13, 7)}, 1),
        ({"depths": (3, 2, 1.5)}, 3),
    ],
)
def test_more_elastic_is_slower_and_deeper(changes, wrong):
    assert len(failed(checks_on(w16, resilient(**changes)))) == wrong


def test_velocities_too_close_or_scattered_decide_nothing():
    assert verdict_on(w16, resilient()) == REPRODUCED
    assert verdict_on(w16, resilient(speeds=(9.001, 9, 8.999), scatter=0.01)) == INCONCLUSIVE
    assert verdict_on(w16, resilient(scatter=0.8)) == INCONCLUSIVE
    # The ends alone do not decide.
    assert verdict_on(w16, resilient(depths=(2, 2.0001, 2.9), scatter=0.01)) == INCONCLUSIVE


def test_flows_without_replicates_are_left_out():
    with pytest.raises(Untestable, match="three coefficients"):
        checks_on(w16, resilient(replicates=1))
    single = flow(4, depth=5, restitution=0.6, replicates=1)
    assert verdict_on(w16, [*resilient(), single]) == REPRODUCED


def soft(static=0.004, dynamic=0.05, slight=0.006, **options):
    """Flows of the softest spheres with quantiles of their overlaps."""
    overlaps = {"median_overlap": 0.001, "overlap_999": slight}
    return [
        *(flow(4.5, overlaps, depth=n, **options) for n in (1.24, 2.5)),
        flow(30, {"median_overlap": static, "overlap_999": dynamic}, depth=40, **options),
    ]


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        ({}, 0),
        ({"static": 0.002}, 1),
        ({"static": 0.011}, 1),
        ({"dynamic": 0.02}, 1),
        ({"slight": 0.012}, 2),
    ],
)
def test_overlaps_of_the_softest_spheres(changes, wrong):
    assert len(failed(checks_on(w20, soft(**changes)))) == wrong
    assert verdict_on(w20, soft(**changes)) == (NOT_REPRODUCED if wrong else REPRODUCED)


def test_uncertain_overlaps_decide_nothing():
    assert verdict_on(w20, soft(scatter=0.8)) == INCONCLUSIVE
    assert verdict_on(w20, soft(replicates=1)) == INCONCLUSIVE


def stiff(slower=0.6, deeper=2.0, shallow=1.01, hotter=3.0, scatter=SCATTER):
    """Deep and shallow flows at two stiffnesses, with the ratios of the stiffer to the softer."""
    points = []
    for n in (1.24, 2.5, 20, 40):
        for stiffness in (100, 1000):
            hard = stiffness == 1000
            speed = SPEEDS[n] * ((slower if n > 10 else shallow) if hard else 1)
            heat = 1e-4 * (hotter if hard else 1)
            points.append(
                flow(
                    speed,
                    {"shear_depth": (deeper if hard else 1) * SIZE},
                    {
                        "packing_profile": lambda z, n=n: PACKING * (z < n * SIZE),
                        # What moves in the bottom layer and high above it does not count.
                        "vertical_temperature_profile": lambda z, heat=heat: np.where(
                            (z > SIZE) & (z < 5 * SIZE), heat, 1.0
                        ),
                    },
                    depth=n,
                    stiffness=stiffness,
                    scatter=scatter,
                )
            )
    return points


@pytest.mark.parametrize(
    ("judge", "changes", "wrong"),
    [
        (w21, {}, 0),
        (w21, {"slower": 0.95}, 2),
        (w21, {"deeper": 0.9}, 2),
        (w21, {"shallow": 1.08}, 2),
        (w21, {"shallow": 0.92}, 2),
        (w22, {}, 0),
        (w22, {"hotter": 0.8}, 2),
    ],
)
def test_stiffer_spheres(judge, changes, wrong):
    assert len(failed(checks_on(judge, stiff(**changes)))) == wrong
    assert verdict_on(judge, stiff(**changes)) == (NOT_REPRODUCED if wrong else REPRODUCED)


@pytest.mark.parametrize("judge", [w21, w22])
def test_stiffer_spheres_with_scattered_flows_decide_nothing(judge):
    assert verdict_on(judge, stiff(scatter=1.5)) == INCONCLUSIVE


def test_stiffest_spheres_count_where_they_were_run():
    fast = flow(24, {"shear_depth": 3 * SIZE}, depth=20, stiffness=10_000)
    assert failed(checks_on(w21, [*stiff(), fast])) == ["V at K1 = 10000 N/m over 100 N/m, n = 20"]


def test_flows_that_drift_count_with_all_that_it_leaves():
    others = [one for one in stiff() if one.parameters.depth != 40]
    settled = flow(40, {"shear_depth": 2 * SIZE}, depth=40, stiffness=1000)
    # In the window of 200 √(σ/g) the velocity changes by 2.3 √(gσ).
    drift = {"regime": "undetermined", "acceleration": 0.04 * SLOPE, "shear_depth": SIZE}
    for speed, verdict in ((90, REPRODUCED), (46, INCONCLUSIVE), (30, NOT_REPRODUCED)):
        drifting = flow(speed, drift, depth=40)
        assert verdict_on(w21, [*others, drifting, settled]) == verdict


def unsettled(points, number: int):
    """Points, one of them as if it ran away."""
    scalars = points[number].scalars | {
        "regime": np.full(5, "accelerating", object),
        "acceleration": np.full(5, RUNAWAY["acceleration"]),
    }
    return [*points[:number], replace(points[number], scalars=scalars), *points[number + 1 :]]


@pytest.mark.parametrize(
    ("judge", "points", "number"),
    [
        (w15, crystals(), 2),
        (w15, crystals(), 3),
        (w15, crystals(), 4),
        (w16, resilient(), 0),
        (w20, soft(), 0),
        (w20, soft(), 2),
        (w21, stiff(), 1),
        (w21, stiff(), 4),
        (w22, stiff(), 6),
    ],
)
def test_flows_that_have_not_settled_decide_nothing(judge, points, number):
    assert verdict_on(judge, points) == REPRODUCED
    assert verdict_on(judge, unsettled(points, number)) == INCONCLUSIVE
