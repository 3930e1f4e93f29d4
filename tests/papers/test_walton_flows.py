"""Judges of flows as a whole: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPRODUCED,
    Untestable,
    combined_verdict,
)
from sim.dataset.replicates import CLOSED_SHARE
from sim.papers.walton.judges.flows import w5, w9, w24, w26
from tests.made.chute_flows import SLOPE, SPEEDS, base_flows, flow
from tests.made.judging import checks_of, failed_quantities, headline_bounds, verdict_of
from tests.made.results import made_point

JUDGES = [w5, w9, w24, w26]


@pytest.mark.parametrize("judge", JUDGES)
def test_right_flows_are_reproduced(judge):
    assert verdict_of(judge, base_flows()) == REPRODUCED


@pytest.mark.parametrize("judge", JUDGES)
def test_without_flows_nothing_is_tested(judge):
    with pytest.raises(Untestable, match=r"flow|depth"):
        checks_of(judge, [made_point("belt", {"velocity": 0.1})])


@pytest.mark.parametrize("judge", [w9, w26])
def test_scattered_flows_decide_nothing(judge):
    assert verdict_of(judge, base_flows(scatter=5, replicates=2)) == INCONCLUSIVE


def test_powers_that_scatter_decide_nothing():
    right = flow(8, depth=5).scalars["normal_power"]
    scattered = {"normal_power": right * [1.0, 0.01, 0.01, 0.001, 0.01]}
    assert verdict_of(w24, [flow(8, scattered, depth=5)]) == INCONCLUSIVE


@pytest.mark.parametrize("judge", [w24, w26])
def test_balances_are_those_of_steady_flows_alone(judge):
    drift = {"acceleration": 0.1 * SLOPE, "base_shear": 1.0, "normal_power": 1.0}
    wrong = flow(9, drift, depth=7)
    assert verdict_of(judge, [*base_flows(), wrong]) == REPRODUCED
    with pytest.raises(Untestable, match="steady"):
        checks_of(judge, [wrong])


def test_a_ledger_closes_as_caveats_demand():
    assert headline_bounds(w5) == {"max_missing": CLOSED_SHARE}


def test_one_leaking_replicate_fails_the_ledger_wherever_it_is():
    leaking = flow(8, {"missing_energy": [1e-5, 0.006, 1e-5, 1e-5, 1e-5]}, depth=5, friction=0.5)
    checks = checks_of(w5, [*base_flows(), leaking])
    assert checks[0].value == pytest.approx(0.006) and checks[0].points == (leaking.id,)
    assert failed_quantities(checks) == [
        "largest share of the energy that a ledger lacks, 11 points"
    ]


def test_a_replicate_without_a_ledger_leaves_the_claim_open():
    lacking = {"missing_energy": [1e-5, np.nan, 1e-5, 1e-5, 1e-5]}
    unknown = flow(8, lacking, depth=5, friction=0.5)
    leaking = flow(8, {"missing_energy": 0.006}, depth=5, friction=0.6)
    assert verdict_of(w5, [*base_flows(), unknown]) == INCONCLUSIVE
    assert verdict_of(w5, [*base_flows(), unknown, leaking]) == NOT_REPRODUCED


def test_velocities_without_order_fail_and_close_ones_decide_nothing():
    depths = list(SPEEDS)
    shuffled = dict(zip(depths, [9, 4, 12, 3, 8, 15, 5, 10, 4.5, 7], strict=True))
    assert verdict_of(w9, base_flows(shuffled, replicates=2)) == INCONCLUSIVE
    falling = dict(zip(depths, range(20, 0, -2), strict=True))
    assert verdict_of(w9, base_flows(falling)) == NOT_REPRODUCED


def test_the_deepest_flow_counts_with_the_lowest_velocity_of_any_window():
    drift = {"acceleration": 0.1 * SLOPE}
    windows = [flow(v, drift, depth=40, transient=t) for v, t in ((50, 60), (3, 250))]
    others = base_flows({n: speed for n, speed in SPEEDS.items() if n < 40})
    single, bounded = (checks_of(w9, [*others, *more])[0] for more in (windows[:1], windows))
    assert single.value > bounded.value > 0
    assert single.verdict == REPRODUCED


def test_a_depth_counts_once_however_many_beds_it_has():
    """Replicates are no depths: four depths in order of six are as sure with 30 beds as with 3."""
    speeds = dict(zip((1.24, 1.5, 2.5, 5, 10, 20), (4, 5, 6, 7, 5.5, 4.5), strict=True))
    few, many = (
        checks_of(w9, base_flows(speeds, replicates=count, cell=10))[0] for count in (3, 30)
    )
    assert few.verdict == many.verdict == INCONCLUSIVE
    assert few.tested == many.tested
    # All of six in order: one of 720 orders.
    (rising,) = checks_of(w9, base_flows(dict(zip(speeds, range(4, 10), strict=True)), cell=10))
    assert rising.p_holds == pytest.approx(1 / 720, rel=1e-6)


def test_cells_are_not_mixed():
    """Flows in the narrow cell are twice as fast at any depth, which is no trend."""
    wide = base_flows({n: 8 + 0.1 * n for n in (1.24, 2.5, 5, 10)})
    narrow = [flow(v, depth=n, cell=5) for n, v in ((10, 19), (20, 18), (40, 17))]
    first, second = (
        checks_of(w9, [*more, flow(4, depth=1.5), flow(5, depth=2)])[0]
        for more in ([*wide, *narrow], [*wide, *narrow[1:]])
    )
    assert second.value > first.value


def test_flows_that_accelerate_have_no_place_in_the_order():
    trend = {"acceleration": 0.02 * SLOPE}
    points = [point for point in base_flows() if point.parameters.depth != 5]
    assert "7 depths" in checks_of(w9, [*points, flow(60, trend, depth=5)])[0].what
    few = {n: speed for n, speed in SPEEDS.items() if n < 20}
    with pytest.raises(Untestable, match=r"1\.24 to 20"):
        checks_of(w9, [*base_flows(few), flow(60, trend, depth=20)])


def test_the_sum_of_the_losses_is_shown_and_does_not_vote():
    right = flow(8, depth=5)
    power = {name: 0.9 * right.scalars[name] for name in ("normal_power", "frictional_power")}
    checks = checks_of(w24, [flow(8, power, depth=5)])
    assert combined_verdict(checks) == REPRODUCED
    assert checks[-1].value == pytest.approx(0.9) and not checks[-1].votes


def test_single_runs_do_not_decide_on_the_power():
    wrong = flow(4.5, {"normal_power": 1.0}, depth=1.7, replicates=1)
    assert verdict_of(w24, [*base_flows(), wrong]) == REPRODUCED
    with pytest.raises(Untestable, match="replicates"):
        checks_of(w24, [wrong])


def test_dissipation_by_collisions_alone_fails():
    right = flow(8, depth=5)
    power = {"normal_power": 1.98 * right.scalars["normal_power"]}
    power["frictional_power"] = 0.02 * right.scalars["frictional_power"]
    assert failed_quantities(checks_of(w24, [flow(8, power, depth=5)])) == [
        "share of friction in the losses, n = 5"
    ]


@pytest.mark.parametrize("name", ["base_normal", "base_shear"])
def test_base_forces_off_by_one_percent_fail(name):
    wrong = {name: 1.01 * flow(8, depth=5).scalars[name]}
    assert verdict_of(w26, [*base_flows({1.24: 4.4}), flow(8, wrong, depth=5)]) == NOT_REPRODUCED


def test_balances_that_single_flows_leave_open_are_decided_together():
    scattered = {
        "base_shear": flow(8, depth=5).scalars["base_shear"] * [1, 0.994, 1.006, 0.99, 1.01]
    }
    point = flow(8, scattered, depth=5)
    assert verdict_of(w26, [point]) == INCONCLUSIVE
    assert verdict_of(w26, [point, *base_flows({1.24: 4.4, 2.5: 4.8})]) == REPRODUCED


def test_too_few_independent_samples_decide_nothing():
    few = flow(8.2, {"independent_samples": 1.0}, depth=5)
    assert verdict_of(w26, base_flows({5: 8.2})) == REPRODUCED
    with pytest.raises(Untestable, match="steady"):
        checks_of(w26, [few])
