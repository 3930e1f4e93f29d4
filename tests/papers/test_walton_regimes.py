"""Judges of regimes: verdicts on correct, wrong, few or scattered synthetic flows."""

from math import radians, tan

import pytest

from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.papers.walton.judges.chute import CELLS
from sim.papers.walton.judges.regimes import w6, w7, w8, w19, w23, w25
from tests.made.chute_flows import PAPER, SLOPE, SPEEDS, WIDE, base_flows, flow
from tests.made.judging import by_part, checks_of, failed_quantities, headline_bounds, verdict_of
from tests.made.results import made_boundary

TANGENT = tan(radians(PAPER.angle))


def accelerating(gain: float, error: float = 1e-3, speed: float = 60, **options):
    """Return a flow with dV/dt in g sin θ, known within a standard error."""
    trend = {
        "acceleration": gain * SLOPE,
        "acceleration_error": error * SLOPE,
        "acceleration_half_width": WIDE * error * SLOPE,
        "regime": "accelerating",
    }
    return flow(speed, trend, **options)


def slippery(change: float = 1.0, error: float = 1e-3, depths=(0.5, 10, 40)):
    """Return flows that slide as a block does, but for a factor at depth 10."""
    return [
        accelerating((change if n == 10 else 1) * (1 - mu / TANGENT), error, friction=mu, depth=n)
        for mu in headline_bounds(w6)["frictions"]
        for n in depths
    ]


def test_flows_that_slide_as_a_block_are_reproduced():
    assert verdict_of(w6, slippery()) == REPRODUCED


def test_flows_that_gain_less_than_a_block_fail():
    assert verdict_of(w6, slippery(0.8)) == NOT_REPRODUCED
    plateau = [flow(20, friction=0.3, depth=n) for n in (0.5, 40)]
    wrong = [point for point in slippery() if point.parameters.friction < 0.3]
    assert verdict_of(w6, [*wrong, *plateau]) == NOT_REPRODUCED


def test_a_gain_within_five_errors_of_none_decides_nothing():
    assert verdict_of(w6, slippery(error=0.005)) == INCONCLUSIVE


def test_sweeps_of_low_friction_must_be_complete():
    with pytest.raises(Untestable, match="friction 0"):
        checks_of(w6, [point for point in slippery() if point.parameters.friction != 0.3])
    with pytest.raises(Untestable, match="40"):
        checks_of(w6, slippery(depths=(0.5, 10)))
    # Another friction at that depth does not stand in for it.
    lacking = [point for point in slippery() if point.id != slippery()[2].id]
    with pytest.raises(Untestable, match=r"friction 0$"):
        checks_of(w6, lacking)


@pytest.mark.parametrize(("half_width", "verdict"), [(0.1, REPRODUCED), (0.15, INCONCLUSIVE)])
def test_what_single_runs_know_of_their_slope_averages_out(half_width, verdict):
    trend = {"acceleration_half_width": half_width * SLOPE}
    rolling = {"acceleration": 5 / 7 * SLOPE} | trend
    assert verdict_of(w7, [flow(60, rolling, depth=0.5, replicates=2)]) == verdict
    with pytest.raises(Untestable, match="replicates"):
        checks_of(w7, [flow(60, rolling, depth=0.5, replicates=1)])


def test_an_evident_acceleration_needs_few_samples_and_a_drift_many():
    few = {"independent_samples": 1.0}
    rolling = {"regime": "accelerating", "acceleration": 5 / 7 * SLOPE} | few
    assert verdict_of(w7, [flow(60, rolling, depth=0.5)]) == REPRODUCED
    others = [point for point in base_flows() if point.parameters.depth != 1.5]
    assert verdict_of(w8, [*others, flow(4.5, few, depth=1.5)]) == INCONCLUSIVE


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
    assert verdict_of(w7, [accelerating(gain, speed=speed, depth=0.5, **options)]) == verdict


def test_a_plateau_of_half_a_layer_fails_and_a_flow_without_a_trend_decides_nothing():
    assert verdict_of(w7, [flow(40, depth=0.5)]) == NOT_REPRODUCED
    unclear = {"acceleration_half_width": SLOPE}
    assert verdict_of(w7, [flow(2, unclear, depth=0.5)]) == INCONCLUSIVE


def test_half_a_layer_must_be_there():
    with pytest.raises(Untestable, match=r"depth 0\.5"):
        checks_of(w7, base_flows())


def test_thin_flows_that_are_steady_and_slowest_are_reproduced():
    assert verdict_of(w8, base_flows(), from_two_seeds(0.7)) == REPRODUCED
    # The least depth is reported, as are the ends of the range.
    assert verdict_of(w8, base_flows(), from_two_seeds(1.1)) == REPRODUCED
    fast = [*base_flows({n: v for n, v in SPEEDS.items() if n != 1}), flow(6, depth=1)]
    assert verdict_of(w8, fast) == REPRODUCED


def from_two_seeds(low: float) -> list[dict[str, object]]:
    return [
        made_boundary("chute", "acceleration", "depth", low, low + 0.1, seed=seed)
        for seed in (1, 2)
    ]


def test_thin_flows_that_drift_or_are_fast_fail():
    others = base_flows({n: speed for n, speed in SPEEDS.items() if n != 1.5})
    drifting = accelerating(0.02, 1e-3, 4.5, depth=1.5)
    assert failed_quantities(checks_of(w8, [*others, drifting])) == ["dV/dt over g sin θ, n = 1.5"]
    assert failed_quantities(checks_of(w8, [*others, flow(5.2, depth=1.5)])) == [
        "V at n = 1.5 over that at n = 2.5"
    ]
    unsure = flow(4.5, {"acceleration_half_width": 0.05 * SLOPE}, depth=1.5)
    assert verdict_of(w8, [*others, unsure]) == INCONCLUSIVE
    assert verdict_of(w8, base_flows(scatter=0.2)) == INCONCLUSIVE


def test_the_least_depth_may_be_of_the_other_protocol():
    outside = [boundary | {"protocol": "converged"} for boundary in from_two_seeds(0.7)]
    assert checks_of(w8, base_flows(), outside)[-1].value == pytest.approx(0.75)


def test_thin_flows_are_compared_with_the_next_deeper_one_alone():
    slow = flow(3, depth=7)
    assert verdict_of(w8, [*base_flows(), slow]) == REPRODUCED


def test_thin_flows_must_be_two_and_long():
    with pytest.raises(Untestable, match="1 < n < 2"):
        checks_of(w8, base_flows({1: 4.2, 1.24: 4.4, 2: 4.5, 2.5: 5, 5: 8, 10: 15}))
    with pytest.raises(Untestable, match="1 < n < 2"):
        checks_of(w8, base_flows(average=50))


def test_points_that_a_bisection_leaves_do_not_count():
    leftovers = [
        accelerating(0.5, speed=40, depth=1.1, replicates=1),
        flow(3, depth=3, replicates=1),
    ]
    assert verdict_of(w8, [*base_flows(), *leftovers]) == REPRODUCED
    left = flow(3, depth=5, friction=0.35, replicates=1)
    assert parts(w19, [*sweeps(), left]) == {"a": REPRODUCED, "b": REPRODUCED}
    with pytest.raises(Untestable, match="replicates"):
        checks_of(w8, base_flows(replicates=1))


RESTING = {
    "regime": "arrested",
    "quality": "jammed",
    "independent_samples": 0.0,
    "transient_end": 0.5,
}


def swept(steady=(0.32, 0.4), arrested=(0.65, 0.8), moving=(), depth=5, starts=(0.5, 1.0)):
    """Return a sweep of friction at one depth; rough flows are started slowly."""
    return [
        *(flow(8, friction=mu, depth=depth, cell=CELLS[depth]) for mu in steady),
        *(
            flow(speed, rest, friction=mu, depth=depth, cell=CELLS[depth], initial_velocity=start)
            for frictions, speed, rest in ((arrested, 1e-5, RESTING), (moving, 3, None))
            for mu in frictions
            for start in starts
        ),
    ]


def sweeps(running=(), depths=(1.24, 5, 10)):
    """Return sweeps at several depths, of which some flows run away just above tan θ."""
    return [
        *(point for n in depths for point in swept(depth=n)),
        *(accelerating(0.05, friction=0.35, depth=n, cell=CELLS[n]) for n in running),
    ]


def parts(judge, points) -> dict[str, str]:
    """Return the verdict on each part of a claim."""
    return by_part(checks_of(judge, points))


def test_flows_that_rest_beyond_twice_the_tangent_are_reproduced():
    assert parts(w19, sweeps()) == {"a": REPRODUCED, "b": REPRODUCED}


def test_flows_that_move_beyond_twice_the_tangent_fail():
    moving = [point for n in (1.24, 5, 10) for point in swept(arrested=(), moving=(0.65,), depth=n)]
    assert parts(w19, moving) == {"a": REPRODUCED, "b": NOT_REPRODUCED}
    (vote,) = (check for check in checks_of(w19, moving) if check.part == "b" and check.has_vote)
    assert vote.text.startswith("0 of 30 (0 to ")


def test_friction_beyond_three_times_the_tangent_is_reported():
    """The sentence begins at twice: beds that rest at more cannot stand for it."""
    moving = [*swept(arrested=(1.2,), moving=(0.65,)), *sweeps((), (1.24, 10))]
    votes = [check for check in checks_of(w19, moving) if check.part == "b" and check.has_vote]
    assert [vote.text.split(" (")[0] for vote in votes] == ["40 of 50"]


@pytest.mark.parametrize(
    ("running", "depths", "steady", "verdict"),
    [
        # Three depths are a variety, whichever they are.
        ((), (1.24, 5, 10), 3, REPRODUCED),
        ((20,), (1.24, 5, 10, 20), 3, REPRODUCED),
        ((5, 20), (1.24, 2.5, 5, 10, 20), 3, REPRODUCED),
        ((5, 10, 20), (1.24, 2.5, 5, 10, 20), 2, NOT_REPRODUCED),
        ((5,), (1.24, 5, 10), 2, NOT_REPRODUCED),
        # Where two depths were run, a third may be steady or not.
        ((), (1.24, 5), 2, INCONCLUSIVE),
        ((1.24, 5), (1.24, 5), 0, INCONCLUSIVE),
    ],
)
def test_a_variety_of_depths_is_steady(running, depths, steady, verdict):
    vote, *by_depth = (
        check for check in checks_of(w19, sweeps(running, depths)) if check.part == "a"
    )
    assert (vote.verdict, vote.value, vote.low) == (verdict, steady, 2.5)
    assert len(by_depth) == len(depths) and not any(check.has_vote for check in by_depth)


def test_a_depth_at_which_a_flow_rests_is_open():
    rest = flow(1e-5, RESTING, friction=0.35, depth=5)
    checks = [check for check in checks_of(w19, [*sweeps(), rest]) if check.part == "a"]
    assert (checks[0].verdict, checks[0].value) == (INCONCLUSIVE, 2)
    assert "1 of them do not move" in {check.withheld for check in checks}


def test_slopes_of_a_depth_count_together():
    """Each friction alone leaves its slope open."""
    wide = {"acceleration_half_width": 0.035 * SLOPE}
    points = [
        flow(8, wide, friction=mu, depth=n) for n in (1.24, 2.5, 5) for mu in (0.32, 0.35, 0.4)
    ]
    assert parts(w19, points)["a"] == REPRODUCED
    assert parts(w19, points[:-2])["a"] == INCONCLUSIVE
    with pytest.raises(Untestable, match="two frictions"):
        checks_of(w19, points[::3])


def test_the_time_until_a_flow_rests_is_reported():
    reports = [
        check for check in checks_of(w19, swept()) if check.what.startswith("time until at rest")
    ]
    assert len(reports) == 4 and not any(check.has_vote for check in reports)
    assert reports[0].value == pytest.approx(0.5 / PAPER.time_unit)


def test_fast_starts_beyond_twice_the_tangent_are_reported():
    fast = flow(3, friction=0.8, depth=5)
    assert parts(w19, [*swept(), fast])["b"] == REPRODUCED
    checks = checks_of(w19, [*swept(starts=()), fast])
    assert [check.has_vote for check in checks if check.part == "b"] == [False]


def test_flows_that_slow_decide_nothing_and_those_that_go_on_fail():
    def going(gain):
        rough = {"friction": 0.9, "depth": 5, "initial_velocity": 1, "replicates": 8}
        return [*swept(arrested=()), flow(3, {"acceleration": gain}, **rough)]

    assert parts(w19, going(-0.05))["b"] == INCONCLUSIVE
    assert parts(w19, going(1e-4))["b"] == NOT_REPRODUCED


@pytest.mark.parametrize("other", ["undetermined", "steady"])
def test_replicates_that_do_not_all_rest_decide_nothing(other):
    regimes = ["arrested", "arrested", "arrested", other]
    rough = {"friction": 0.9, "depth": 5, "replicates": 4, "initial_velocity": 1}
    halting = flow([0, 0, 0, 0.3], {"regime": regimes}, **rough)
    assert parts(w19, [*swept(arrested=()), halting])["b"] == INCONCLUSIVE


def started(late: float = 1.0, scatter: float = 1e-3, depths=(2.5, 5), scalars=None):
    """Return flows after three starts; the fast start has its own velocity and ``scalars``."""
    return [
        flow(
            SPEEDS[n] * (late if start == 2 else 1),
            scalars if start == 2 else None,
            depth=n,
            cell=CELLS[n],
            initial_velocity=start * SPEEDS[n],
            scatter=scatter,
            replicates=8,
        )
        for n in depths
        for start in (0.5, 1, 2)
    ]


@pytest.mark.parametrize(
    ("late", "scatter", "verdict"),
    [(1.0, 1e-3, REPRODUCED), (1.05, 1e-3, NOT_REPRODUCED), (1.0, 0.05, INCONCLUSIVE)],
)
def test_the_start_is_forgotten_or_not(late, scatter, verdict):
    points = started(late, scatter, depths=(2.5, 5, 10))
    assert parts(w23, points) == dict.fromkeys("abc", verdict)


def test_each_depth_forgets_its_start_by_itself():
    """Depth 10 is a part as the others are: a start that it remembers counts."""
    points = [*started(), *started(1.2, depths=(10,))]
    assert parts(w23, points) == {"a": REPRODUCED, "b": REPRODUCED, "c": NOT_REPRODUCED}


def test_starts_are_compared_at_one_age():
    def late(factor, start, transient, replicates):
        where = {"depth": 5, "initial_velocity": start * SPEEDS[5], "cell": CELLS[5]}
        return flow(factor * SPEEDS[5], **where, transient=transient, replicates=replicates)

    # The flow is faster when old, and of the fast start alone there are more old runs.
    points = [*started(), late(1.2, 2, 2000, 9)]
    assert parts(w23, points)["b"] == REPRODUCED
    old = [late(1.2, start, 2000, 9) for start in (0.6, 1.2, 2.4)]
    assert parts(w23, [*started(depths=(2.5,)), *old])["b"] == REPRODUCED
    unlike = [*started(depths=(2.5,)), *old[:2], late(1.2, 2.4, 300, 9)]
    (reason, same) = (check.withheld for check in checks_of(w23, unlike) if check.part == "b")
    assert {reason, same} == {"", "flows of ages 300 and 2000 √(σ/g) are compared"}


@pytest.mark.parametrize(
    ("late", "gain", "verdict"),
    [(1.6, -0.02, INCONCLUSIVE), (1.6, 0.02, INCONCLUSIVE), (1.6, -0.005, NOT_REPRODUCED)],
)
def test_a_flow_that_still_forgets_its_start_decides_nothing(late, gain, verdict):
    # 0.02 g sin θ over 200 √(σ/g) is 1.2 √(gσ), 16 % of 1.6 times the velocity at depth 2.5.
    drift = {"acceleration": gain * SLOPE}
    points = [*started(depths=(5,)), *started(late, depths=(2.5,), scalars=drift)]
    assert parts(w23, points) == {"a": verdict, "b": REPRODUCED}


def test_a_start_that_comes_to_rest_is_not_forgotten():
    rest = {"velocity": 1e-9, "regime": "arrested", "quality": "jammed"}
    points = [*started(depths=(5,)), *started(depths=(2.5,), scalars=rest)]
    assert parts(w23, points) == {"a": NOT_REPRODUCED, "b": REPRODUCED}


def test_starts_must_be_far_from_the_steady_velocity():
    with pytest.raises(Untestable, match=r"n = 2.5.*n = 5.*n = 10"):
        checks_of(w23, base_flows())
    assert parts(w23, started(depths=(2.5,))) == {"a": REPRODUCED}


def test_a_start_must_be_near_the_steady_velocity():
    far = [point for point in started() if point.parameters.initial_velocity != SPEEDS[5]]
    assert parts(w23, far) == {"a": REPRODUCED}
    with pytest.raises(Untestable, match="n = 5"):
        checks_of(w23, far[3:])


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
        # One seed of one depth knows its upper limit to ten degrees.
        (
            [
                *windows(5, 20),
                made_boundary("chute", "flow", "angle", 5, 5.5, depth=20, seed=1),
                made_boundary("chute", "flow", "angle", 5, 5.5, depth=20, seed=2),
                made_boundary("chute", "acceleration", "angle", 6, 20, depth=20, seed=1),
                made_boundary("chute", "acceleration", "angle", 19, 20, depth=20, seed=2),
            ],
            NOT_REPRODUCED,
        ),
        # How much starts differ is not known.
        (windows(13, 20, seeds=(1,)), INCONCLUSIVE),
    ],
)
def test_window_of_angles(bounds, verdict):
    # A boundary is sharp or not, whatever the samples of single runs.
    assert verdict_of(w25, base_flows({5: 8}), bounds) == verdict


def test_windows_need_both_bounds_at_two_depths():
    with pytest.raises(Untestable, match="bounds"):
        checks_of(w25, base_flows({5: 8}), windows(13, 20, depths=(5, 20)))
