"""Judges of Walton's claims about the spheres: order, restitution, stiffness."""

from dataclasses import replace
from functools import partial
from itertools import chain
from math import inf

import numpy as np

from sim.claims.checks import above, judge_parts, remove_votes, reported, withhold, within
from sim.claims.chute import (
    CELLS,
    DEEPEST,
    SOFT,
    STIFF,
    depth_label,
    longest_lasting_row,
    reason_incomparable,
    reason_unrankable,
    select_replicated,
    withhold_unsettled,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, trend
from sim.claims.place import Place, quotient
from sim.claims.states import has_plug, majority_if_mixed, report_states
from sim.claims.verdict import Check, Untestable
from sim.measures import layers

#: Depths with crystals, and the least share of crystalline spheres there.
CRYSTALLINE, SHARE = (10, 20, DEEPEST), 0.5

#: Depth and cell of the controls, the spread of diameters, and the wide cell.
CONTROL_SETTINGS, SPREAD, WIDE = {"depth": 10, "cell": 5}, 0.1, 20

#: Depths at which the restitution is varied, by part; range that decides, and a reported value.
RESILIENT = {"a": 5, "b": 10, "c": 20}
RESTITUTIONS, LOWEST = (0.7, 0.95), 0.6

#: Overlaps in the paper's words.
DYNAMIC_OVERLAP, SLIGHT_OVERLAP = 0.05, 0.005

#: Depths at which the flow depends on the stiffness, and those at which it does not.
SENSITIVE = (20, DEEPEST)
INSENSITIVE = (1.24, 2.5)

#: Heights in diameters of the layer immediately above the bottom one.
ABOVE_BOTTOM = (1, 2)

#: Least number of replicates in one state for a comparison.
MIN_STATE_REPLICATES = 2


def w15(evidence: Evidence) -> list[Check]:
    """Crystals at three depths of one age (a), and three factors that favour them (b, c, d)."""
    return judge_parts(
        a=lambda: _crystals(evidence),
        b=lambda: _compare_order(
            evidence, f"diameters ±{100 * SPREAD:g} %", diameter_spread=SPREAD
        ),
        c=lambda: _compare_bumps(evidence),
        d=lambda: _compare_order(evidence, f"a cell of {WIDE} σ", cell=WIDE),
    )


def _crystals(evidence: Evidence) -> list[Check]:
    row = longest_lasting_row(evidence)
    deep = [(row if n == DEEPEST else evidence).at("chute", depth=n) for n in CRYSTALLINE]
    checks = []
    for place in deep:
        share, label = place.value("crystalline_share"), depth_label(place)
        check = above(f"crystalline share of the plug, {label}", share, SHARE, [place])
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


def w16(evidence: Evidence) -> list[Check]:
    """Trends of V and of the shear depth over the restitution, at each of three depths.

    Flows of 1,000 N/m are used where they were run: with 100 N/m some flows run away, outside the
    range of the law.
    """
    return judge_parts(
        **{part: partial(_over_restitution, evidence, n) for part, n in RESILIENT.items()}
    )


def _over_restitution(evidence: Evidence, depth: float) -> list[Check]:
    where = {"depth": depth, "cell": CELLS[depth]}
    for stiffness in (STIFF, SOFT):
        line = select_replicated(
            evidence.line("chute", "restitution", **where, stiffness=stiffness)
        )
        flows = {e: p for e, p in line.items() if RESTITUTIONS[0] <= e <= RESTITUTIONS[1]}
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
        quantity = f"V at e = {LOWEST:g} over that at {RESTITUTIONS[0]:g}, {label}"
        withheld_checks.append(reported(quantity, ratio, [line[LOWEST], places[0]]))
    return withheld_checks


def w20(evidence: Evidence, factor: float) -> list[Check]:
    """Overlaps of the softest spheres, within a factor ``factor`` of the paper's."""
    return judge_parts(
        a=lambda: [check for n in INSENSITIVE for check in _shallow_overlap(evidence, n, factor)],
        b=lambda: _deep_overlap(evidence, factor),
        c=lambda: _static_overlap(evidence, factor),
    )


def _shallow_overlap(evidence: Evidence, depth: float, factor: float) -> list[Check]:
    place = evidence.at("chute", depth=depth, stiffness=SOFT)
    bounds = SLIGHT_OVERLAP / factor, SLIGHT_OVERLAP * factor
    check = _overlap("median overlap", place, "median_overlap", bounds)
    extreme = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    return withhold_unsettled([check, *remove_votes([extreme])], [place])


def _deep_overlap(evidence: Evidence, factor: float) -> list[Check]:
    place = evidence.at("chute", depth=DEEPEST, stiffness=SOFT)
    bounds = DYNAMIC_OVERLAP / factor, DYNAMIC_OVERLAP * factor
    check = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    check = majority_if_mixed(check, place, 100 * place.values("overlap_999"))
    median = 100 * place.value("median_overlap")
    return withhold_unsettled([check, reported("median overlap, n = 40", median, [place])], [place])


def _static_overlap(evidence: Evidence, factor: float) -> list[Check]:
    place = evidence.at("chute", depth=DEEPEST, stiffness=SOFT, angle=0)
    bounds = SLIGHT_OVERLAP / factor, SLIGHT_OVERLAP * factor
    check = _overlap("mean overlap of the base contacts at rest", place, "base_overlap", bounds)
    moves = "" if place.regime == "arrested" else "the bed on the level plane is not at rest"
    # Nothing fluctuates at rest, so no further samples are needed.
    return withhold([replace(check, samples=inf)], moves)


def _overlap(quantity: str, place: Place, name: str, bounds: tuple[float, float]) -> Check:
    low, high = (100 * bound for bound in bounds)
    quantity = f"{quantity}, n = {place['depth']:g}"
    return within(quantity, 100 * place.value(name), low, high, [place], "% of σ")


def w21(evidence: Evidence, margin: float) -> list[Check]:
    """Stiffer against softest spheres, in shallow flows (a) and in deep ones (b).

    V of shallow flows is the same within ``margin``; V and shear depth of deep ones differ.
    """
    return judge_parts(
        a=lambda: chain.from_iterable(_insensitive(evidence, n, margin) for n in INSENSITIVE),
        b=lambda: chain.from_iterable(
            _sensitive(evidence, n) for n in _comparable_depths(evidence)
        ),
    )


def _comparable_depths(evidence: Evidence) -> list[float]:
    """Return the sensitive depths; the deepest only where a flow of the softest spheres lasts.

    Otherwise there is nothing to compare at that depth, whatever is run.
    """
    softest = evidence.line("chute", "stiffness", depth=DEEPEST).get(SOFT)
    lasts = softest is not None and softest.regime != "accelerating"
    return [n for n in SENSITIVE if n != DEEPEST or lasts]


def _insensitive(evidence: Evidence, depth: float, margin: float) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth):
        quantity = f"V at K1 = {stiffness:g} N/m over {SOFT} N/m, n = {depth:g}"
        ratio = quotient(stiff.velocity, soft.velocity)
        pair = [soft, stiff]
        withheld_checks = withhold(
            [within(quantity, ratio, 1 - margin, 1 + margin, pair)], reason_incomparable(pair)
        )
        checks += _limit_votes(withhold_unsettled(withheld_checks, pair), stiffness)
    return checks


def _sensitive(evidence: Evidence, depth: float) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth):
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
        checks += _limit_votes(withhold(rank_checks, reason), stiffness)
        checks += report_states(f"{SOFT} N/m, n = {depth:g}", [soft])
        checks += report_states(f"{stiffness:g} N/m, n = {depth:g}", [stiff])
    return checks


def w22(evidence: Evidence) -> list[Check]:
    """Vertical granular temperature of the layer above the bottom one, stiffer against softest."""
    checks = []
    for n in _comparable_depths(evidence):
        for stiffness, soft, stiff in _stiffer(evidence, n):
            quantity = (
                f"share of pairs more agitated with {stiffness:g} N/m than {SOFT} N/m, n = {n:g}"
            )
            first, second = (_agitation(place) for place in (stiff, soft))
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
            checks += _limit_votes(withheld_checks, stiffness)
    return checks


def _stiffer(evidence: Evidence, depth: float) -> list[tuple[float, Place, Place]]:
    """Return stiffnesses above the softest, each with the places of softest and stiffer spheres.

    Raises `Untestable` where there is none with ten times the stiffness.
    """
    line = select_replicated(evidence.line("chute", "stiffness", depth=depth))
    if SOFT not in line or STIFF not in line:
        raise Untestable(f"no flows with K1 = {SOFT} and {STIFF} N/m at n = {depth:g}")
    return [(value, line[SOFT], place) for value, place in line.items() if value >= STIFF]


def _limit_votes(checks: list[Check], stiffness: float) -> list[Check]:
    """Return checks that vote at ten times the softest stiffness and nowhere else."""
    return checks if stiffness == STIFF else remove_votes(checks)


def _agitation(place: Place) -> np.ndarray:
    """Return the vertical granular temperature (R,) in m²/s² above the bottom layer."""
    low, high = (bound * place["diameter"] for bound in ABOVE_BOTTOM)

    def mean(height: np.ndarray, temperature: np.ndarray, packing: np.ndarray) -> float:
        return layers.mean_between(height, temperature, packing, low, high)

    return place.measure_replicates(mean, "vertical_temperature_profile", "packing_profile")
