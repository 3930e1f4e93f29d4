"""Judges of Walton's claims about the spheres: order, restitution, stiffness."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from math import inf

import numpy as np

from sim.claims.checks import above, judge_parts, remove_votes, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, trend
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.walton.judges.chute import (
    CELLS,
    SOFT,
    depth_label,
    longest_lasting_row,
    reason_incomparable,
    reason_unrankable,
    select_replicated,
    withhold_unsettled,
)
from sim.papers.walton.judges.states import has_plug, majority_if_mixed, report_states

#: Depth and cell of the controls.
CONTROL_SETTINGS = {"depth": 10, "cell": 5}

#: Depths at which the restitution is varied, by part; the stiffness (N/m) of these flows, where
#: they were run; and a restitution that is reported.
RESILIENT, STIFFER, LOWEST = {"a": 5, "b": 10, "c": 20}, 1000, 0.6

#: Shallow depths at which overlaps are judged.
SHALLOW = (1.24, 2.5)

#: Least number of replicates in one state for a comparison.
MIN_STATE_REPLICATES = 2


def w15(
    evidence: Evidence,
    *,
    majority: float,
    depths: Sequence[float],
    stiffness: float,
    spread: float,
    width: float,
) -> list[Check]:
    """Crystals at several depths of one age (a), and three factors that favour them (b, c, d).

    ``majority`` is the least share of crystalline spheres. The last depth is of a larger
    ``stiffness`` (N/m) where no flow of the softest spheres lasts. The factors are a spread of the
    diameters, bumps, and the width (σ) of the cell.
    """
    return judge_parts(
        a=lambda: _crystals(evidence, majority, depths, stiffness),
        b=lambda: _compare_order(
            evidence, f"diameters ±{100 * spread:g} %", diameter_spread=spread
        ),
        c=lambda: _compare_bumps(evidence),
        d=lambda: _compare_order(evidence, f"a cell of {width} σ", cell=width),
    )


def _crystals(
    evidence: Evidence, majority: float, depths: Sequence[float], stiffness: float
) -> list[Check]:
    row = longest_lasting_row(evidence, depths[-1], stiffness)
    deep = [(row if n == depths[-1] else evidence).at("chute", depth=n) for n in depths]
    checks = []
    for place in deep:
        share, label = place.value("crystalline_share"), depth_label(place)
        check = above(f"crystalline share of the plug, {label}", share, majority, [place])
        check = majority_if_mixed(check, place, place.values("crystalline_share"))
        reason = reason_unrankable(place) or reason_incomparable(deep, compare_cells=False)
        checks += withhold([check], reason)
        layered = place.value("layer_order")
        checks.append(reported(f"amplitude of its layers, {label}", layered, [place]))
    return checks


def _compare_bumps(evidence: Evidence) -> list[Check]:
    line = evidence.line("chute", "bumps", **CONTROL_SETTINGS)
    size = max(line, default=0)
    if not size > 0:
        raise Untestable("no flow over a bumpy plane")
    return _compare_order(evidence, f"bumps of {size:g} σ", bumps=size)


def _compare_order(evidence: Evidence, name: str, **change: float) -> list[Check]:
    """Return the checks that a change of the base case lowers the crystalline share.

    The flows are compared by rank, within the state that they share. Their states are reported.
    """
    usual = evidence.at("chute", **CONTROL_SETTINGS)
    control = evidence.at("chute", **CONTROL_SETTINGS | change)
    quantity = (
        f"share of pairs more crystalline than with {name}, n = {CONTROL_SETTINGS['depth']:g}"
    )
    first, second = (place.values("crystalline_share") for place in (usual, control))
    try:
        first, second, state = pick_common_state(usual, control, first, second)
        check, reason = outranks(f"{quantity}, {state}", first, second, [usual, control]), ""
    except Untestable as error:
        check, reason = outranks(quantity, first, second, [usual, control]), str(error)
    cells_differ = usual["cell"] != control["cell"]
    moving = (
        reason_unrankable(usual)
        or reason_unrankable(control)
        or reason_incomparable([usual, control], compare_cells=not cells_differ)
    )
    state_reports = report_states("usual", [usual]) + report_states(f"with {name}", [control])
    return [*withhold([check], moving or reason), *state_reports]


def pick_common_state(
    first_place: Place, second_place: Place, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return quantities (R,) of two points in the state most frequent in both, and its name.

    Raises `Untestable` where they share no state.
    """
    plugs = has_plug(first_place), has_plug(second_place)
    by_state = {
        name: (first[plugs[0] == state], second[plugs[1] == state])
        for name, state in (("with a plug", True), ("without a plug", False))
    }
    name, (first_values, second_values) = max(
        by_state.items(), key=lambda item: min(map(len, item[1]))
    )
    if min(len(first_values), len(second_values)) < MIN_STATE_REPLICATES:
        raise Untestable("the two are in different states: more replicates of both")
    return first_values, second_values, name


def w16(evidence: Evidence, *, restitutions: tuple[float, float]) -> list[Check]:
    """Trends of V and of the shear depth from one restitution to another, at three depths.

    Flows of 1,000 N/m are used where they were run: with 100 N/m some flows run away, outside the
    range of the law.
    """
    return judge_parts(
        **{
            part: partial(_over_restitution, evidence, n, restitutions)
            for part, n in RESILIENT.items()
        }
    )


def _over_restitution(
    evidence: Evidence, depth: float, restitutions: tuple[float, float]
) -> list[Check]:
    where = {"depth": depth, "cell": CELLS[depth]}
    for stiffness in (STIFFER, SOFT):
        line = select_replicated(
            evidence.line("chute", "restitution", **where, stiffness=stiffness)
        )
        flows = {e: p for e, p in line.items() if restitutions[0] <= e <= restitutions[1]}
        if len(flows) > 2:
            break
    else:
        raise Untestable(f"no three coefficients of restitution with replicates at n = {depth:g}")
    places, label = list(flows.values()), f"n = {depth:g}, K1 = {stiffness:g} N/m"
    checks = []
    for quantity, name, rising in (("V", "velocity", False), ("shear depth", "shear_depth", True)):
        groups = [place.values(name) for place in places]
        values = ", ".join(f"{e:g}" for e in flows)
        checks.append(
            trend(f"{quantity} over e = {values}, {label}", [groups], places, rising=rising)
        )
    reasons = dict.fromkeys(
        filter(None, [*map(reason_unrankable, places), reason_incomparable(places)])
    )
    withheld_checks = withhold(checks, "; ".join(reasons))
    if LOWEST in line:
        ratio = quotient(line[LOWEST].velocity, places[0].velocity)
        quantity = f"V at e = {LOWEST:g} over that at {restitutions[0]:g}, {label}"
        withheld_checks.append(reported(quantity, ratio, [line[LOWEST], places[0]]))
    return withheld_checks


def w20(
    evidence: Evidence,
    *,
    factor: float,
    max_depth: float,
    slight: float,
    depth: float,
    large: float,
) -> list[Check]:
    """Overlaps of the softest spheres, within a factor ``factor`` of the paper's.

    They are slight below ``max_depth`` and at rest, and large in flows of a greater depth.
    """
    few, many = ((overlap / factor, overlap * factor) for overlap in (slight, large))
    shallow = [n for n in SHALLOW if n < max_depth]
    return judge_parts(
        a=lambda: chain.from_iterable(_shallow_overlap(evidence, n, few) for n in shallow),
        b=lambda: _deep_overlap(evidence, depth, many),
        c=lambda: _static_overlap(evidence, depth, few),
    )


def _shallow_overlap(evidence: Evidence, depth: float, bounds: tuple[float, float]) -> list[Check]:
    place = evidence.at("chute", depth=depth, stiffness=SOFT)
    check = _overlap("median overlap", place, "median_overlap", bounds)
    extreme = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    return withhold_unsettled([check, *remove_votes([extreme])], [place])


def _deep_overlap(evidence: Evidence, depth: float, bounds: tuple[float, float]) -> list[Check]:
    place = evidence.at("chute", depth=depth, stiffness=SOFT)
    check = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    check = majority_if_mixed(check, place, 100 * place.values("overlap_999"))
    median = 100 * place.value("median_overlap")
    typical = reported(f"median overlap, n = {depth}", median, [place])
    return withhold_unsettled([check, typical], [place])


def _static_overlap(evidence: Evidence, depth: float, bounds: tuple[float, float]) -> list[Check]:
    place = evidence.at("chute", depth=depth, stiffness=SOFT, angle=0)
    check = _overlap("mean overlap of the base contacts at rest", place, "base_overlap", bounds)
    moves = "" if place.regime == "arrested" else "the bed on the level plane is not at rest"
    # Nothing fluctuates at rest, so no further samples are needed.
    return withhold([replace(check, samples=inf)], moves)


def _overlap(quantity: str, place: Place, name: str, bounds: tuple[float, float]) -> Check:
    low, high = (100 * bound for bound in bounds)
    quantity = f"{quantity}, n = {place['depth']:g}"
    return within(quantity, 100 * place.value(name), low, high, [place], "% of σ")


def w21(
    evidence: Evidence,
    *,
    margin: float,
    shallow: Sequence[float],
    deep: Sequence[float],
    stiffnesses: tuple[float, float],
) -> list[Check]:
    """Stiffer against softest spheres, in shallow flows (a) and in deep ones (b).

    V of shallow flows is the same within ``margin``; V and shear depth of deep ones differ. The
    first of the stiffnesses (N/m) votes, the others up to the last are shown.
    """
    return judge_parts(
        a=lambda: chain.from_iterable(
            _insensitive(evidence, n, stiffnesses, margin) for n in shallow
        ),
        b=lambda: chain.from_iterable(
            _sensitive(evidence, n, stiffnesses) for n in _comparable_depths(evidence, deep)
        ),
    )


def _comparable_depths(evidence: Evidence, depths: Sequence[float]) -> list[float]:
    """Return the depths; the last one only where a flow of the softest spheres lasts.

    Otherwise there is nothing to compare at that depth, whatever is run.
    """
    softest = evidence.line("chute", "stiffness", depth=depths[-1]).get(SOFT)
    lasts = softest is not None and softest.regime != "accelerating"
    return [n for n in depths if n != depths[-1] or lasts]


def _insensitive(
    evidence: Evidence, depth: float, stiffnesses: tuple[float, float], margin: float
) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth, stiffnesses):
        quantity = f"V at K1 = {stiffness:g} N/m over {SOFT} N/m, n = {depth:g}"
        ratio = quotient(stiff.velocity, soft.velocity)
        pair = [soft, stiff]
        withheld_checks = withhold(
            [within(quantity, ratio, 1 - margin, 1 + margin, pair)], reason_incomparable(pair)
        )
        has_vote = stiffness == stiffnesses[0]
        checks += _limit_votes(withhold_unsettled(withheld_checks, pair), has_vote)
    return checks


def _sensitive(evidence: Evidence, depth: float, stiffnesses: tuple[float, float]) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth, stiffnesses):
        label, pair = f"{stiffness:g} N/m against {SOFT} N/m, n = {depth:g}", [soft, stiff]
        speeds = [place.values("velocity") for place in pair]
        depths = [place.values("shear_depth") for place in pair]
        rank_checks = [
            outranks(f"share of pairs slower with {label}", speeds[0], speeds[1], pair),
            outranks(
                f"share of pairs with a deeper shear layer, {label}", depths[1], depths[0], pair
            ),
        ]
        reason = reason_unrankable(soft) or reason_unrankable(stiff) or reason_incomparable(pair)
        checks += _limit_votes(withhold(rank_checks, reason), stiffness == stiffnesses[0])
        checks += report_states(f"{SOFT} N/m, n = {depth:g}", [soft])
        checks += report_states(f"{stiffness:g} N/m, n = {depth:g}", [stiff])
    return checks


def w22(
    evidence: Evidence,
    *,
    layer: tuple[float, float],
    stiffness: float,
    softest: float,
    depths: Sequence[float],
) -> list[Check]:
    """Vertical granular temperature of a layer (σ) above the bottom, stiffer against softest."""
    checks = []
    for n in _comparable_depths(evidence, depths):
        for value, soft, stiff in _stiffer(evidence, n, (stiffness, inf), softest):
            quantity = (
                f"share of pairs more agitated with {value:g} N/m than {softest} N/m, n = {n:g}"
            )
            first, second = (_agitation(place, layer) for place in (stiff, soft))
            reason = (
                reason_unrankable(soft)
                or reason_unrankable(stiff)
                or reason_incomparable([soft, stiff])
            )
            try:
                first, second, state = pick_common_state(stiff, soft, first, second)
                quantity += f", {state}"
            except Untestable as error:
                reason = reason or str(error)
            withheld_checks = withhold([outranks(quantity, first, second, [stiff, soft])], reason)
            checks += _limit_votes(withheld_checks, value == stiffness)
    return checks


def _stiffer(
    evidence: Evidence, depth: float, stiffnesses: tuple[float, float], softest: float = SOFT
) -> list[tuple[float, Place, Place]]:
    """Return stiffnesses between two (N/m), each with the places of softest and stiffer spheres.

    Raises `Untestable` where there is none with the first of the two.
    """
    low, high = stiffnesses
    line = select_replicated(evidence.line("chute", "stiffness", depth=depth))
    if softest not in line or low not in line:
        raise Untestable(f"no flows with K1 = {softest} and {low} N/m at n = {depth:g}")
    return [(value, line[softest], place) for value, place in line.items() if low <= value <= high]


def _limit_votes(checks: list[Check], has_vote: bool) -> list[Check]:
    """Return checks that vote at one stiffness and nowhere else."""
    return checks if has_vote else remove_votes(checks)


def _agitation(place: Place, layer: tuple[float, float]) -> np.ndarray:
    """Return the vertical granular temperature (R,) in m²/s² of a layer (σ)."""
    low, high = (bound * place["diameter"] for bound in layer)

    def mean(height: np.ndarray, temperature: np.ndarray, packing: np.ndarray) -> float:
        return layers.mean_between(height, temperature, packing, low, high)

    return place.measure_replicates(mean, "vertical_temperature_profile", "packing_profile")
