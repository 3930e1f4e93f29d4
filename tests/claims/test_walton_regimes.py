"""Judges of regimes: verdicts on made-up flows that are right, wrong, few or scattered."""

from math import radians, tan

import pytest

from sim.claims.chute import CELLS
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.claims.walton_regimes import SLIPPERY, STARTED, w6, w7, w8, w19, w23, w25
from tests.claims.judging import checks_on, failed, verdict_on
from tests.made.chute_flows import PAPER, SLOPE, SPEEDS, UNIT, WIDE, base_flows, flow
from tests.made.results import made_boundary

TANGENT = tan(radians(PAPER.angle))


def accelerating(gain: float, error: float = 1e-3, speed: float = 60, **options):
    """A flow with dV/dt in g sin θ, known within a standard error."""
    trend = {
        "acceleration": gain * SLOPE,
        "acceleration_error": error * SLOPE,
        "acceleration_half_width": WIDE * error * SLOPE,
        "regime": "accelerating",
    }
    return flow(speed, trend, **options)


def slippery(change: float = 1.0, error: float = 1e-3, depths=(0.5, 10, 40)):
    """Flows that slide as a block does, but for a factor at depth 10."""
    return [
        accelerating((change if n == 10 else 1) * (1 - mu / TANGENT), error, friction=mu, depth=n)
        for mu in SLIPPERY
        for n in depths
    ]


def test_flows_that_slide_as_a_block_are_reproduced():
    assert verdict_on(w6, slippery()) == REPRODUCED


def test_flows_that_gain_less_than_a_block_fail():
    assert verdict_on(w6, slippery(0.8)) == NOT_REPRODUCED
    plateau = [flow(20, friction=0.3, depth=n) for n in (0.5, 40)]
    wrong = [point for point in slippery() if point.parameters.friction < 0.3]
    assert verdict_on(w6, [*wrong, *plateau]) == NOT_REPRODUCED


def test_a_gain_within_five_errors_of_none_decides_nothing():
    assert verdict_on(w6, slippery(error=0.005)) == INCONCLUSIVE


def test_sweeps_of_low_friction_must_be_complete():
    with pytest.raises(Untestable, match="friction 0"):
        checks_on(w6, [point for point in slippery() if point.parameters.friction != 0.3])
    with pytest.raises(Untestable, match="40"):
        checks_on(w6, slippery(depths=(0.5, 10)))
    # Another friction at that depth does not stand in for it.
    lacking = [point for point in slippery() if point.id != slippery()[2].id]
    with pytest.raises(Untestable, match=r"friction 0$"):
        checks_on(w6, lacking)


@pytest.mark.parametrize(("half_width", "verdict"), [(0.06, REPRODUCED), (0.08, INCONCLUSIVE)])
def test_a_single_run_has_the_interval_that_its_few_samples_leave(half_width, verdict):
    trend = {"acceleration_error": 0.02 * SLOPE, "acceleration_half_width": half_width * SLOPE}
    rolling = {"regime": "accelerating", "acceleration": 5 / 7 * SLOPE} | trend
    assert verdict_on(w7, [flow(60, rolling, depth=0.5, replicates=1)]) == verdict


def test_an_evident_acceleration_needs_few_samples_and_a_drift_many():
    few = {"independent_samples": 1.0}
    rolling = {"regime": "accelerating", "acceleration": 5 / 7 * SLOPE} | few
    assert verdict_on(w7, [flow(60, rolling, depth=0.5)]) == REPRODUCED
    others = [point for point in base_flows() if point.parameters.depth != 1.5]
    assert verdict_on(w8, [*others, flow(4.5, few, depth=1.5)]) == INCONCLUSIVE


@pytest.mark.parametrize(
    ("gain", "speed", "options", "verdict"),
    [
        (5 / 7, 60, {}, REPRODUCED),
        (0.6, 60, {}, NOT_REPRODUCED),
        (0.85, 60, {}, NOT_REPRODUCED),
        # Watched for too short a time.
        (5 / 7, 40, {}, INCONCLUSIVE),
        (5 / 7, 60, {"scatter": 0.3}, INCONCLUSIVE),
        (5 / 7, 52, {"scatter": 0.05}, INCONCLUSIVE),
    ],
)
def test_half_a_layer_rolls(gain, speed, options, verdict):
    assert verdict_on(w7, [accelerating(gain, speed=speed, depth=0.5, **options)]) == verdict


def test_a_plateau_of_half_a_layer_fails_and_a_flow_without_a_trend_decides_nothing():
    assert verdict_on(w7, [flow(40, depth=0.5)]) == NOT_REPRODUCED
    assert verdict_on(w7, [flow(2, {"regime": "undetermined"}, depth=0.5)]) == INCONCLUSIVE


def test_half_a_layer_must_be_there():
    with pytest.raises(Untestable, match=r"depth 0\.5"):
        checks_on(w7, base_flows())


def test_thin_flows_that_are_steady_and_slowest_are_reproduced():
    assert verdict_on(w8, base_flows(), from_two_seeds(0.7)) == REPRODUCED
    outside = checks_on(w8, base_flows(), from_two_seeds(1.1))
    assert failed(outside) == ["least depth of a steady flow"]
    # One seed does not tell how much starts differ.
    assert verdict_on(w8, base_flows(), from_two_seeds(0.7)[:1]) == INCONCLUSIVE


def from_two_seeds(low: float) -> list[dict[str, object]]:
    return [
        made_boundary("chute", "acceleration", "depth", low, low + 0.1, seed=seed)
        for seed in (1, 2)
    ]


def test_thin_flows_that_drift_or_are_fast_fail():
    others = base_flows({n: speed for n, speed in SPEEDS.items() if n != 1.5})
    drifting = accelerating(0.02, 1e-3, 4.5, depth=1.5)
    assert failed(checks_on(w8, [*others, drifting])) == ["dV/dt over g sin θ, n = 1.5"]
    assert failed(checks_on(w8, [*others, flow(5.2, depth=1.5)])) == [
        "V at n = 1.5 over that at n = 2.5"
    ]
    unsure = flow(4.5, {"acceleration_half_width": 0.03 * SLOPE}, depth=1.5)
    assert verdict_on(w8, [*others, unsure]) == INCONCLUSIVE
    assert verdict_on(w8, base_flows(scatter=0.2)) == INCONCLUSIVE


def test_a_least_depth_of_the_other_protocol_counts():
    outside = [one | {"protocol": "converged"} for one in from_two_seeds(1.5)]
    assert failed(checks_on(w8, base_flows(), outside)) == ["least depth of a steady flow"]


def test_thin_flows_must_be_slower_than_every_deeper_one():
    unsure = flow(6, depth=7, scatter=0.6)
    assert verdict_on(w8, [*base_flows(), unsure]) == INCONCLUSIVE


def test_thin_flows_must_be_three_and_long():
    with pytest.raises(Untestable, match="1 ≤ n ≤ 2"):
        checks_on(w8, base_flows({1: 4.2, 1.24: 4.4, 2.5: 5, 5: 8, 10: 15}))
    with pytest.raises(Untestable, match="1 ≤ n ≤ 2"):
        checks_on(w8, base_flows(average=50))


def test_points_that_a_bisection_leaves_do_not_count():
    left = [
        accelerating(0.5, speed=40, depth=1.1, replicates=1),
        flow(3, depth=3, replicates=1),
    ]
    assert verdict_on(w8, [*base_flows(), *left]) == REPRODUCED
    assert verdict_on(w19, [*swept(), left[0]]) == REPRODUCED
    with pytest.raises(Untestable, match="replicates"):
        checks_on(w8, base_flows(replicates=1))


def test_thin_flows_that_drift_may_have_been_faster():
    # 0.009 g sin θ over 200 √(σ/g) is 0.5 √(gσ).
    drift = {"regime": "undetermined", "acceleration": -0.009 * SLOPE}
    others = [point for point in base_flows() if point.parameters.depth != 1.5]
    assert verdict_on(w8, [*others, flow(4.5, depth=1.5)]) == REPRODUCED
    assert verdict_on(w8, [*others, flow(4.5, drift, depth=1.5)]) == INCONCLUSIVE


def swept(steady=(0.32, 0.4), arrested=(0.65, 0.8), moving=(), depth=5):
    """A sweep of friction at one depth."""
    resting = {"regime": "arrested", "quality": "jammed", "independent_samples": 0.0}
    return [
        *(flow(8, friction=mu, depth=depth) for mu in steady),
        *(flow(1e-5, resting, friction=mu, depth=depth) for mu in arrested),
        *(flow(3, friction=mu, depth=depth) for mu in moving),
    ]


def test_flows_that_rest_beyond_twice_the_tangent_are_reproduced():
    assert verdict_on(w19, swept()) == REPRODUCED


def test_flows_in_the_wrong_regime_fail():
    moving = checks_on(w19, swept(arrested=(0.8,), moving=(0.65,)))
    assert failed(moving) == ["at rest (1) or not (0), μ = 0.65, n = 5"]
    rest = checks_on(w19, swept(steady=(0.32,), arrested=(0.4, 0.65, 0.8)))
    assert failed(rest) == ["V/√(gσ), μ = 0.4, n = 5"]


def test_a_base_flow_that_runs_away_fails():
    runaway = accelerating(0.9, speed=110, depth=40)
    assert failed(checks_on(w19, [*swept(), runaway])) == ["dV/dt over g sin θ, μ = 0.4, n = 40"]


def test_flows_that_slow_decide_nothing_and_those_that_go_on_fail():
    slowing = {"regime": "undetermined", "acceleration": -0.05}
    assert verdict_on(w19, [*swept(), flow(3, slowing, friction=0.9, depth=5)]) == INCONCLUSIVE
    going = {"regime": "undetermined", "acceleration": 1e-4}
    assert verdict_on(w19, [*swept(), flow(3, going, friction=0.9, depth=5)]) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="two frictions"):
        checks_on(w19, swept(arrested=(0.8,)))


@pytest.mark.parametrize("other", ["undetermined", "steady"])
def test_replicates_that_do_not_all_rest_decide_nothing(other):
    regimes = ["arrested", "arrested", "arrested", other]
    halting = flow([0, 0, 0, 0.3], {"regime": regimes}, friction=0.9, depth=5, replicates=4)
    assert verdict_on(w19, [*swept(), halting]) == INCONCLUSIVE


def test_drifts_of_replicates_do_not_cancel():
    """Each changes its velocity by 12 % over the window, half of them up and half of them down."""
    change = 0.12 * 8 / 200 * UNIT / PAPER.time_unit
    drift = {"regime": "undetermined", "acceleration": [change, -change] * 2}
    going = flow(8, drift, friction=0.9, depth=5, replicates=4)
    assert verdict_on(w19, [*swept(), going]) == INCONCLUSIVE


def started(late: float = 1.0, scatter: float = 1e-3, depths=STARTED, scalars=None):
    """Flows after three starts, the fast one with another velocity and what ``scalars`` say."""
    return [
        flow(
            SPEEDS[n] * (late if start == 2 else 1),
            scalars if start == 2 else None,
            depth=n,
            cell=CELLS[n],
            initial_velocity=start * SPEEDS[n],
            scatter=scatter,
        )
        for n in depths
        for start in (0.5, 1, 2)
    ]


@pytest.mark.parametrize(
    ("late", "scatter", "verdict"),
    [(1.0, 1e-3, REPRODUCED), (1.05, 1e-3, NOT_REPRODUCED), (1.0, 0.05, INCONCLUSIVE)],
)
def test_the_start_is_forgotten_or_not(late, scatter, verdict):
    assert verdict_on(w23, started(late, scatter)) == verdict


@pytest.mark.parametrize(
    ("late", "gain", "verdict"),
    [(1.6, -0.02, NOT_REPRODUCED), (1.6, 0.02, NOT_REPRODUCED), (1.0, -0.02, INCONCLUSIVE)],
)
def test_a_start_that_is_not_forgotten_yet_counts_with_its_drift(late, gain, verdict):
    # 0.02 g sin θ over 200 √(σ/g) is 1.2 √(gσ), 16 % of 1.6 times the velocity at depth 2.5.
    regime = "accelerating" if gain > 0 else "undetermined"
    drift = {"acceleration": gain * SLOPE, "regime": regime}
    points = [*started(depths=(5, 10)), *started(late, depths=(2.5,), scalars=drift)]
    assert verdict_on(w23, points) == verdict


def test_a_start_that_comes_to_rest_is_not_forgotten():
    rest = {"velocity": 1e-9, "regime": "arrested", "quality": "jammed"}
    points = [*started(depths=(5, 10)), *started(depths=(2.5,), scalars=rest)]
    assert verdict_on(w23, points) == NOT_REPRODUCED


def test_starts_must_be_far_from_the_steady_velocity():
    with pytest.raises(Untestable, match="starts"):
        checks_on(w23, base_flows())
    with pytest.raises(Untestable, match=r"n = 10"):
        checks_on(w23, started(depths=(2.5, 5)))


def test_a_start_must_be_near_the_steady_velocity():
    far = [one for one in started() if one.parameters.initial_velocity != SPEEDS[5]]
    with pytest.raises(Untestable, match="n = 5"):
        checks_on(w23, far)


def windows(rest: float, runaway: float, width: float = 0.25, depths=(5, 10), seeds=(1, 2)):
    return [
        made_boundary("chute", of, "angle", low, low + width, depth=n, seed=seed)
        for n in depths
        for seed in seeds
        for of, low in (("flow", rest), ("acceleration", runaway))
    ]


@pytest.mark.parametrize(
    ("bounds", "verdict"),
    [
        (windows(13, 20), REPRODUCED),
        (windows(16, 16.25), NOT_REPRODUCED),
        (windows(18, 17), NOT_REPRODUCED),
        (windows(16, 17.5, width=1.0), INCONCLUSIVE),
        # How much starts differ is not known.
        (windows(13, 20, seeds=(1,)), INCONCLUSIVE),
    ],
)
def test_window_of_angles(bounds, verdict):
    # A boundary is sharp or not, whatever the samples of single runs.
    assert verdict_on(w25, base_flows({5: 8}), bounds) == verdict


def test_windows_need_both_bounds_at_two_depths():
    with pytest.raises(Untestable, match="bounds"):
        checks_on(w25, base_flows({5: 8}), windows(13, 20, depths=(5, 20)))
