"""Judges of Walton's claims about the spheres: order and stiffness."""

from dataclasses import replace
from itertools import chain
from math import inf

import numpy as np

from sim.claims.checks import (
    Numbers,
    Pair,
    above,
    judge_parts,
    remove_votes,
    reported,
    withhold,
    within,
)
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import outranks
from sim.claims.place import Place, quotient, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.walton.judges.chute import (
    PROFILES,
    SOFT,
    depth_label,
    flows_of_one_age,
    majority_if_mixed,
    reason_incomparable,
    reason_unrankable,
    reasons_unrankable,
    report_states,
    withhold_unsettled,
)

#: Depth and cell of the controls.
CONTROL_SETTINGS = {"depth": 10, "cell": 5}

#: Shallow depths at which overlaps are judged.
SHALLOW = (1.24, 2.5)

#: Overlap that a quantile of all contacts has: its name in words, and the scalar.
QUANTILES = {
    0.5: ("median overlap", "median_overlap"),
    0.999: ("99.9th percentile of the overlaps", "overlap_999"),
}


def w15(
    evidence: Evidence,
    *,
    majority: float,
    depths: Numbers,
    cell: float,
    stiffness: float,
    spread: float,
    width: float,
) -> list[Check]:
    """Crystals at several depths of one age (a), and three factors that favour them (b, c, d).

    ``cell`` and ``width`` are widths of cells (σ), ``stiffness`` is in N/m.
    """
    return judge_parts(
        a=lambda: _crystals(evidence, majority, depths, cell, stiffness),
        b=lambda: _compare_order(
            evidence, f"diameters ±{100 * spread:g} %", diameter_spread=spread
        ),
        c=lambda: _compare_bumps(evidence),
        d=lambda: _compare_order(evidence, f"a cell of {width} σ", cell=width),
    )


def _crystals(
    evidence: Evidence, majority: float, depths: Numbers, cell: float, stiffness: float
) -> list[Check]:
    wheres = [{"depth": n, "cell": cell, "stiffness": stiffness} for n in depths]
    deep = flows_of_one_age(evidence, wheres)
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

    All runs of one age are compared by rank, whatever their state: the state is an outcome of the
    change. The states are reported.
    """
    usual, control = flows_of_one_age(evidence, [CONTROL_SETTINGS, CONTROL_SETTINGS | change])
    quantity = (
        f"share of pairs more crystalline than with {name}, n = {CONTROL_SETTINGS['depth']:g}"
    )
    first, second = (place.values("crystalline_share") for place in (usual, control))
    check = outranks(quantity, first, second, [usual, control])
    cells_differ = usual["cell"] != control["cell"]
    moving = reasons_unrankable([usual, control], compare_cells=not cells_differ)
    state_reports = report_states("usual", [usual]) + report_states(f"with {name}", [control])
    return [*withhold([check], moving), *state_reports]


def w20(
    evidence: Evidence,
    *,
    factor: float,
    max_depth: float,
    slight: float,
    depth: float,
    large: float,
    quantile: float,
    stiffness: float,
) -> list[Check]:
    """Overlaps of the softest spheres, of a ``stiffness`` (N/m), against those of the paper."""
    few, many = ((overlap / factor, overlap * factor) for overlap in (slight, large))
    shallow = [n for n in SHALLOW if n < max_depth]
    softest = evidence.with_reading(stiffness=stiffness)
    return judge_parts(
        a=lambda: chain.from_iterable(_shallow_overlap(softest, n, few, quantile) for n in shallow),
        b=lambda: _deep_overlap(softest, depth, many),
        c=lambda: _static_overlap(softest, depth, few),
    )


def _shallow_overlap(
    evidence: Evidence, depth: float, bounds: Pair, quantile: float
) -> list[Check]:
    place = evidence.at("chute", cell=ANY, depth=depth)
    checks = {
        one: _overlap(name, place, scalar, bounds) for one, (name, scalar) in QUANTILES.items()
    }
    check = checks.pop(quantile)
    return withhold_unsettled([check, *remove_votes(checks.values())], [place])


def _deep_overlap(evidence: Evidence, depth: float, bounds: Pair) -> list[Check]:
    place = evidence.at("chute", cell=ANY, depth=depth)
    check = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    check = majority_if_mixed(check, place, 100 * place.values("overlap_999"))
    median = 100 * place.value("median_overlap")
    # The sentence is about overlaps in a layer that shears fast, in whatever flow.
    return [check, reported(f"median overlap, n = {depth}", median, [place], "% of σ")]


def _static_overlap(evidence: Evidence, depth: float, bounds: Pair) -> list[Check]:
    place = evidence.at("chute", cell=ANY, depth=depth, angle=0)
    check = _overlap("mean overlap of the base contacts at rest", place, "base_overlap", bounds)
    moves = "" if place.regime == "arrested" else "the bed on the level plane is not at rest"
    # Nothing fluctuates at rest, so no further samples are needed.
    return withhold([replace(check, samples=inf)], moves)


def _overlap(quantity: str, place: Place, name: str, bounds: Pair) -> Check:
    low, high = (100 * bound for bound in bounds)
    quantity = f"{quantity}, n = {place['depth']:g}"
    return within(quantity, 100 * place.value(name), low, high, [place], "% of σ")


def w21(
    evidence: Evidence, *, margin: float, shallow: Numbers, deep: Numbers, stiffnesses: Pair
) -> list[Check]:
    """Stiffer against softest spheres, in shallow flows (a) and in deep ones (b).

    V of shallow flows is the same within ``margin``; V and shear depth of deep ones differ. The
    first of the stiffnesses (N/m) votes, the others up to the last are shown.
    """
    return judge_parts(
        a=lambda: chain.from_iterable(
            _insensitive(evidence, n, stiffnesses, margin) for n in shallow
        ),
        b=lambda: chain.from_iterable(_sensitive(evidence, n, stiffnesses) for n in deep),
    )


def _insensitive(evidence: Evidence, depth: float, stiffnesses: Pair, margin: float) -> list[Check]:
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


def _sensitive(evidence: Evidence, depth: float, stiffnesses: Pair) -> list[Check]:
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
        ranked = withhold(rank_checks, reasons_unrankable(pair))
        checks += _limit_votes(ranked, stiffness == stiffnesses[0])
        checks += report_states(f"{SOFT} N/m, n = {depth:g}", [soft])
        checks += report_states(f"{stiffness:g} N/m, n = {depth:g}", [stiff])
    return checks


def w22(
    evidence: Evidence, *, layer: Pair, stiffness: float, softest: float, depths: Numbers
) -> list[Check]:
    """Agitation of a layer (σ) above the bottom at its shear rate, stiffer against softest.

    The agitation is T_z/(γ̇σ)², since faster shear alone agitates more.
    """
    checks = []
    for n in depths:
        for value, soft, stiff in _stiffer(evidence, n, (stiffness, inf), softest):
            quantity = (
                f"share of pairs more agitated with {value:g} N/m than {softest} N/m, n = {n:g}"
            )
            first, second = (_agitation(place, layer) for place in (stiff, soft))
            check = outranks(quantity, first, second, [stiff, soft])
            ranked = withhold([check], reasons_unrankable([soft, stiff]))
            checks += _limit_votes(ranked, value == stiffness)
    return checks


def _stiffer(
    evidence: Evidence, depth: float, stiffnesses: Pair, softest: float = SOFT
) -> list[tuple[float, Place, Place]]:
    """Return stiffnesses between two (N/m), each with the places of softest and stiffer spheres.

    Raises `Untestable` where there is none with the first of the two.
    """
    low, high = stiffnesses
    line = select_replicated(evidence.line("chute", "stiffness", depth=depth, cell=ANY))
    if softest not in line or low not in line:
        raise Untestable(f"no flows with K1 = {softest} and {low} N/m at n = {depth:g}")
    found = []
    for value in line:
        if low <= value <= high:
            wheres = [{"depth": depth, "stiffness": k, "cell": ANY} for k in (softest, value)]
            soft, stiff = flows_of_one_age(evidence, wheres)
            found.append((value, soft, stiff))
    return found


def _limit_votes(checks: list[Check], has_vote: bool) -> list[Check]:
    """Return checks that vote at one stiffness and nowhere else."""
    return checks if has_vote else remove_votes(checks)


def _agitation(place: Place, layer: Pair) -> np.ndarray:
    """Return T_z/(γ̇σ)² (R,) of a layer (σ): its vertical temperature at its shear rate."""
    low, high = (bound * place["diameter"] for bound in layer)

    def agitation(
        height: np.ndarray, temperature: np.ndarray, velocity: np.ndarray, packing: np.ndarray
    ) -> float:
        bottom, top = np.interp((low, high), height, velocity)
        shear = (top - bottom) / (high - low) * place["diameter"]
        return layers.mean_between(height, temperature, packing, low, high) / shear**2

    return place.measure_replicates(agitation, "vertical_temperature_profile", *PROFILES)
