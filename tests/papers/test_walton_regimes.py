"""Judges of regimes: verdicts on correct, wrong, few or scattered synthetic flows."""

from math import radians, tan

import pytest

from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.papers.walton.judges.chute import CELLS
from sim.papers.walton.judges.regimes import w6, w7, w8, w19, w23, w25
from tests.made.chute_flows import PAPER, SLOPE, SPEEDS, WIDE, base_flows, flow
from tests.made.judging import (
    by_part,
    checks_of,
    headline_bounds,
    letters,
    verdict_of,
)
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


def from_two_seeds(low: float) -> list[dict[str, object]]:
    return [
        made_boundary("chute", "acceleration", "depth", low, low + 0.1, seed=seed)
        for seed in (1, 2)
    ]


def test_the_least_depth_may_be_of_the_other_protocol():
    outside = [boundary | {"protocol": "converged"} for boundary in from_two_seeds(0.7)]
    assert checks_of(w8, base_flows(), outside)[-1].value == pytest.approx(0.75)


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


def test_friction_beyond_three_times_the_tangent_is_reported():
    """The sentence begins at twice: beds that rest at more cannot stand for it."""
    moving = [*swept(arrested=(1.2,), moving=(0.65,)), *sweeps((), (1.24, 10))]
    votes = [check for check in checks_of(w19, moving) if check.part == "b" and check.has_vote]
    assert [vote.text.split(" (")[0] for vote in votes] == ["40 of 50"]


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


def windows(rest: float, runaway: float, width: float = 0.25, depths=(5, 10), seeds=(1, 2)):
    return [
        made_boundary("chute", of, "angle", low, low + width, depth=n, seed=seed)
        for n in depths
        for seed in seeds
        for of, low in (("flow", rest), ("acceleration", runaway))
    ]


#: Velocities at all depths but one between the first and the second layer.
OTHERS = {depth: speed for depth, speed in SPEEDS.items() if depth != 1.5}

#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w6, "R", lambda: slippery()),
    (w6, "N", lambda: slippery(0.8)),
    # A gain within five errors of none decides nothing.
    (w6, "I", lambda: slippery(error=0.005)),
    (w6, "-", lambda: slippery(depths=(0.5, 10))),
    (w7, "R", lambda: [accelerating(5 / 7, depth=0.5)]),
    (w7, "N", lambda: [accelerating(0.85, depth=0.5)]),
    (w7, "N", lambda: [flow(40, depth=0.5)]),
    # Watched for too short a time.
    (w7, "I", lambda: [accelerating(5 / 7, speed=40, depth=0.5)]),
    (w7, "-", lambda: base_flows()),
    (w8, "R", lambda: (base_flows(), from_two_seeds(0.7))),
    (w8, "N", lambda: [*base_flows(OTHERS), accelerating(0.02, 1e-3, 4.5, depth=1.5)]),
    (w8, "N", lambda: [*base_flows(OTHERS), flow(5.2, depth=1.5)]),
    (w8, "I", lambda: base_flows(scatter=0.2)),
    (w8, "-", lambda: base_flows(average=50)),
    (w19, "aR bR", lambda: sweeps()),
    (w19, "aN bR", lambda: sweeps((5, 10, 20), (1.24, 2.5, 5, 10, 20))),
    (
        w19,
        "aR bN",
        lambda: [flow for n in (1.24, 5, 10) for flow in swept((0.32, 0.4), (), (0.65,), n)],
    ),
    # Where two depths were run, a third may be steady or not.
    (w19, "aI bR", lambda: sweeps((), (1.24, 5))),
    (w23, "aR bR cR", lambda: started(depths=(2.5, 5, 10))),
    (w23, "aN bN cN", lambda: started(1.05, depths=(2.5, 5, 10))),
    (w23, "aI bI cI", lambda: started(scatter=0.05, depths=(2.5, 5, 10))),
    (w23, "aR bR cN", lambda: [*started(), *started(1.2, depths=(10,))]),
    (w23, "-", lambda: base_flows()),
    (w25, "R", lambda: (base_flows({5: 8}), windows(13, 20))),
    (w25, "N", lambda: (base_flows({5: 8}), windows(16, 16.25))),
    (w25, "N", lambda: (base_flows({5: 8}), windows(18, 17))),
    # How much starts differ is not known.
    (w25, "I", lambda: (base_flows({5: 8}), windows(13, 20, seeds=(1,)))),
    (w25, "-", lambda: (base_flows({5: 8}), windows(13, 20, depths=(5, 20)))),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
