"""Judges of properties of the spheres: verdicts on correct, wrong, few or scattered flows."""

from dataclasses import replace

import numpy as np
import pytest

from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    READING_DEPENDENT,
    REPRODUCED,
)
from sim.papers.walton.judges.properties import _agitation, w15, w16, w20, w21, w22
from tests.made.chute_flows import (
    PACKING,
    SIZE,
    SLOPE,
    SPEEDS,
    UNIT,
    base_flows,
    flow,
    kinked_profile,
)
from tests.made.judging import (
    by_part,
    checks_of,
    judgement_of,
    letters,
    verdict_of,
)
from tests.made.results import SCATTER, made_results


def parts(judge, points) -> dict[str, str]:
    """Return the verdict on each part of a claim."""
    return by_part(checks_of(judge, points))


def ordered_flow(share, knee=2, rest=0.0, **options):
    """Return a flow with a crystalline share: a plug on ``knee`` diameters, or sheared."""
    scalars = {"crystalline_share": share, "layer_order": 0.6}
    profiles = riding(options["depth"], knee, rest, options.get("replicates", 5))
    return flow(15, scalars, profiles, **options)


def riding(depth, knee=2, rest=0.0, replicates=5):
    """Return profiles of a plug on ``knee`` diameters."""
    return {
        "velocity_profile": kinked_profile(knee, depth, rest, replicates),
        "packing_profile": lambda z: PACKING * (z < depth * SIZE / 0.9),
    }


def crystals(share=0.8, usual=0.8, spread=0.3, bumps=0.1, wide=0.6, rest=0.0, scatter=0.01):
    """Return stiff flows with crystalline plugs; a soft one, and its controls with weaker order."""
    options = {"scatter": scatter}
    narrow = {"depth": 10, "cell": 5} | options
    return [
        *(ordered_flow(share, depth=n, cell=5, stiffness=1000, **options) for n in (10, 20, 40)),
        ordered_flow(usual, **narrow),
        ordered_flow(spread, diameter_spread=0.1, rest=rest, **narrow),
        ordered_flow(bumps, bumps=1, **narrow),
        ordered_flow(wide, depth=10, cell=20, **options),
    ]


def test_flows_are_compared_whatever_their_state():
    """A control that shears throughout is one result of the change, and so is its order."""
    states = {"a": REPRODUCED, "b": REPRODUCED, "c": REPRODUCED, "d": REPRODUCED}
    assert parts(w15, crystals(rest=0.5)) == states
    assert parts(w15, crystals(rest=0.5, spread=0.85)) == states | {"b": NOT_REPRODUCED}
    checks = checks_of(w15, crystals(rest=0.5))
    (compared,) = (check for check in checks if check.part == "b" and check.has_vote)
    assert compared.tested[0] == pytest.approx(1 / 252)


def test_factors_are_compared_at_one_age():
    """The usual flow is less ordered when old, and only its control was watched that long."""
    usual = {"depth": 10, "cell": 5, "transient": 2000}
    old = ordered_flow(0.2, **usual, replicates=9)
    narrow = [point for point in crystals() if point.parameters.depth == 10]
    assert parts(w15, [*narrow, old])["b"] == REPRODUCED
    oldest = ordered_flow(0.3, **usual, diameter_spread=0.1, replicates=7)
    late = [*narrow[:2], old, oldest]
    (check,) = (check for check in checks_of(w15, late) if check.part == "b" and check.has_vote)
    assert check.points == (old.id, oldest.id) and check.verdict == NOT_REPRODUCED


def test_crystals_of_unlike_ages_are_not_compared():
    young = [ordered_flow(0.8, depth=40, cell=5, stiffness=1000, transient=100)]
    unlike = [*crystals()[:2], *young, *crystals()[3:]]
    assert parts(w15, unlike)["a"] == INCONCLUSIVE
    (reason,) = {c.withheld for c in checks_of(w15, unlike) if c.part == "a" and c.has_vote}
    assert reason == "flows of ages 100 and 300 √(σ/g) are compared"


def resilient(speeds=(13, 9, 7), depths=(1.4, 2, 2.9), n=5, **options):
    """Return flows at one depth along the restitution."""
    return [
        flow(speed, {"shear_depth": depth * SIZE}, depth=n, restitution=e, **options)
        for e, speed, depth in zip((0.7, 0.85, 0.95), speeds, depths, strict=True)
    ]


def test_each_of_three_depths_is_clear_by_itself():
    """Two of three restitutions are in order: with p = 0.03 at one depth, and one of three."""
    points = resilient(speeds=(13, 9, 9), depths=(2, 2, 2), replicates=3)
    velocity, _ = (check for check in checks_of(w16, points) if check.has_vote)
    alone = trend("V", [[point.scalars["velocity"] for point in points]], rising=False)
    assert alone.verdict == REPRODUCED and velocity.verdict == INCONCLUSIVE
    assert velocity.tested == pytest.approx((3 * alone.p_holds, 1.0))


def test_restitutions_are_compared_at_one_age():
    """More replicates of another age at one restitution do not count."""
    young = flow(20, {"shear_depth": SIZE}, depth=5, restitution=0.95, transient=40, replicates=9)
    checks = checks_of(w16, [*resilient(), young])
    assert checks == checks_of(w16, resilient())
    (reason,) = {check.withheld for check in checks_of(w16, [*resilient()[:2], young])}
    assert reason == "flows of ages 40 and 300 √(σ/g) are compared"


def test_stiffer_spheres_decide_where_they_were_run():
    soft, hard = resilient(speeds=(7, 9, 13)), resilient(stiffness=1000)
    checks = checks_of(w16, [*soft, *hard])
    assert {check.verdict for check in checks if check.has_vote} == {REPRODUCED}
    assert all("K1 = 1000 N/m" in check.what for check in checks)


def soft(median=0.003, dynamic=0.05, static=None, replicates=5, **options):
    """Return flows of the softest spheres with quantiles of their overlaps."""
    options["replicates"] = replicates
    thin = {"median_overlap": median, "overlap_999": 0.025}
    deep = {"median_overlap": 0.003, "overlap_999": dynamic}
    rest = {"regime": "arrested", "quality": "jammed", "independent_samples": 0.0}
    flows = [
        *(flow(4.5, thin, depth=n, **options) for n in (1.24, 2.5)),
        flow(30, deep, riding(40, replicates=replicates), depth=40, **options),
    ]
    if static:
        flows += [flow(0, rest | {"base_overlap": static}, depth=40, angle=0, **options)]
    return flows


def test_the_stiffness_of_the_softest_spheres_is_a_reading():
    """The paper has none: 130 N/m may hold at rest where 100 N/m does not."""
    flows = [*soft(static=0.012), *soft(static=0.009, stiffness=130)]
    assert parts(w20, flows)["c"] == NOT_REPRODUCED
    assert judgement_of("W20", flows).part_verdicts["c"] == READING_DEPENDENT


def mixed(point, riders, **scalars):
    """Return a flow with ``riders`` of ten replicates as a plug; the others shear throughout."""
    depth = point["depth"]
    profiles = riding(depth, replicates=10)
    sheared = riding(depth, knee=depth, replicates=10)["velocity_profile"]
    plugs = np.arange(10) < riders
    profiles["velocity_profile"] = np.where(plugs[:, None], profiles["velocity_profile"], sheared)
    scalars = {name: np.where(plugs, *values) for name, values in scalars.items()}
    return flow(15, scalars, profiles, replicates=10, **point)


@pytest.mark.parametrize(("riders", "verdict"), [(9, REPRODUCED), (6, INCONCLUSIVE)])
def test_of_flows_in_two_states_most_must_hold(riders, verdict):
    states = {"crystalline_share": (0.8, 0.1), "layer_order": (0.6, 0.1)}
    flows = [
        mixed({"depth": n, "cell": 5, "stiffness": 1000}, riders, **states) for n in (10, 20, 40)
    ]
    assert parts(w15, flows)["a"] == verdict
    overlaps = {"overlap_999": (0.05, 0.01), "median_overlap": (1e-3, 1e-3)}
    deep = mixed({"depth": 40}, riders, **overlaps)
    assert parts(w20, [*soft()[:2], deep])["b"] == verdict


def stiff(slower=0.6, deeper=2.0, shallow=1.01, hotter=3.0, scatter=SCATTER, **options):
    """Return deep and shallow flows at two stiffnesses; arguments are ratios, stiff over soft."""
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
                        "velocity_profile": kinked_profile(2, n, replicates=5),
                        "packing_profile": lambda z, n=n: PACKING * (z < n * SIZE),
                        # What moves in the bottom layer and high above it does not count.
                        "vertical_temperature_profile": lambda z, heat=heat: np.where(
                            (z > SIZE) & (z < 2 * SIZE), heat, 1.0
                        ),
                    },
                    depth=n,
                    stiffness=stiffness,
                    scatter=scatter,
                    **options,
                )
            )
    return points


def layer(heat, shear, knee=1.75):
    """Return a flow with a temperature and a shear rate (√(g/σ)) up to a height, in the layer."""
    profiles = {
        "velocity_profile": np.tile(shear * kinked_profile(knee, 20, replicates=1), (5, 1)),
        "packing_profile": lambda z: PACKING * (z < 20 * SIZE),
        "vertical_temperature_profile": lambda z: np.where(
            (z > SIZE) & (z < 2 * SIZE), heat * UNIT**2, 1.0
        ),
    }
    return Evidence(made_results(flow(25, profiles=profiles, depth=20, scatter=0)), "published")


@pytest.mark.parametrize(
    ("heat", "shear", "knee", "agitation"),
    [
        (0.1, 1.0, 9, 0.1),
        # Twice the shear agitates four times as much by itself.
        (0.4, 2.0, 9, 0.1),
        # Over three quarters of the layer: the mean shear rate is 0.75 √(g/σ).
        (0.09, 1.0, 1.75, 0.16),
    ],
)
def test_agitation_is_that_of_the_shear_rate(heat, shear, knee, agitation):
    """T_z/(γ̇σ)² is heat/shear², as σ²γ̇² is shear² gσ."""
    place = layer(heat, shear, knee).at("chute", depth=20)
    assert _agitation(place, (1, 2)) == pytest.approx(np.full(5, agitation), rel=1e-6)


def test_faster_shear_alone_is_no_hopping():
    """Stiff spheres shear twice as fast and are three times as hot: less than four times."""
    points = stiff(hotter=3.0)
    fast = {"velocity_profile": 2 * points[5].profiles["velocity_profile"]}
    points[5] = replace(points[5], profiles=points[5].profiles | fast)
    assert verdict_of(w22, points) == NOT_REPRODUCED


def test_flows_with_and_without_a_plug_are_ranked_together():
    """The state is an outcome of the stiffness: half of the stiff runs shear throughout."""
    points = stiff()
    rows = points[5].profiles["velocity_profile"].copy()
    rows[:2] = kinked_profile(20, 20, replicates=2)
    points[5] = replace(points[5], profiles=points[5].profiles | {"velocity_profile": rows})
    (check,) = (check for check in checks_of(w22, points) if check.has_vote)
    assert check.verdict == REPRODUCED and check.tested[0] == pytest.approx(1 / 252)


def aged(transient, *kept):
    """Return flows at two stiffnesses; the stiff one at depth 20 has another age, or both."""
    hard = stiff(transient=transient)[5]
    return [*stiff()[:5], *kept, hard, *stiff()[6:]]


def of_deep_flows(points) -> list:
    """Return the checks with a vote on W21's deep flows and on W22."""
    deep = [check for check in checks_of(w21, points) if check.part == "b" and check.has_vote]
    return [*deep, *(check for check in checks_of(w22, points) if check.has_vote)]


def test_flows_of_other_ages_are_not_compared():
    reasons = {check.withheld for check in of_deep_flows(aged(900))}
    assert reasons == {"flows of ages 300 and 900 √(σ/g) are compared"}
    # Windows of one age are compared, whatever others there are.
    checks = of_deep_flows(aged(900, stiff()[5]))
    assert len(checks) == 3 and {check.verdict for check in checks} == {REPRODUCED}
    assert {check.points for check in checks} == {
        (stiff()[4].id, stiff()[5].id),
        (stiff()[5].id, stiff()[4].id),
    }


@pytest.mark.parametrize(("transient", "comparable"), [(300.02, True), (306, False)])
def test_ages_are_equal_within_a_sample(transient, comparable):
    assert [not check.withheld for check in of_deep_flows(aged(transient))] == [comparable] * 3


def runaway(points, number: int):
    """Return points, one of them as if it ran away."""
    gain = np.full(5, 0.1 * SLOPE)
    scalars = points[number].scalars | {"acceleration": gain}
    return [*points[:number], replace(points[number], scalars=scalars), *points[number + 1 :]]


@pytest.mark.parametrize(
    ("judge", "points", "number", "part"),
    [
        (w15, crystals(), 2, "a"),
        (w15, crystals(), 4, "b"),
        (w16, resilient(), 0, "a"),
        (w20, soft(), 0, "a"),
        (w21, stiff(), 1, "a"),
        (w21, stiff(), 4, "b"),
        (w22, stiff(), 4, ""),
    ],
)
def test_flows_that_have_not_settled_decide_nothing(judge, points, number, part):
    assert parts(judge, points)[part] == REPRODUCED
    assert parts(judge, runaway(points, number))[part] == INCONCLUSIVE


def test_overlaps_of_a_flow_that_runs_away_count():
    """The sentence is on a layer that shears fast, in whatever flow."""
    assert parts(w20, runaway(soft(), 2))["b"] == REPRODUCED
    assert parts(w20, runaway(soft(dynamic=0.02), 2))["b"] == NOT_REPRODUCED


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w15, "aR bR cR dR", lambda: crystals()),
    (w15, "aN bR cR dR", lambda: crystals(share=0.4)),
    (w15, "aR bN cR dR", lambda: crystals(spread=0.85)),
    (w15, "aR bR cN dR", lambda: crystals(bumps=0.85)),
    (w15, "aR bR cR dN", lambda: crystals(wide=0.85)),
    (w15, "aR bR cR", lambda: crystals()[:-1]),
    (w15, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
    (w16, "aR", lambda: resilient()),
    (w16, "aN", lambda: resilient(speeds=(7, 9, 13))),
    (w16, "aN", lambda: resilient(depths=(3, 2, 1.5))),
    (w16, "aI", lambda: resilient(speeds=(9, 9, 9))),
    (w16, "-", lambda: resilient(replicates=1)),
    (w20, "aR bR", lambda: soft()),
    (w20, "aN bR", lambda: soft(median=0.011)),
    (w20, "aR bN", lambda: soft(dynamic=0.02)),
    (w20, "aR bR cR", lambda: soft(static=0.0056)),
    (w20, "aR bR cN", lambda: soft(static=0.02)),
    (w20, "aI bI", lambda: soft(scatter=0.8)),
    (w21, "aR bR", lambda: stiff()),
    (w21, "aR bN", lambda: stiff(slower=1.05)),
    (w21, "aR bN", lambda: stiff(deeper=0.9)),
    (w21, "aN bR", lambda: stiff(shallow=1.08)),
    (w21, "aI bI", lambda: stiff(slower=1, shallow=1.03, scatter=0.5)),
    (w21, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
    (w22, "R", lambda: stiff()),
    (w22, "N", lambda: stiff(hotter=0.8)),
    (w22, "I", lambda: stiff(hotter=1.0)),
    (w22, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
