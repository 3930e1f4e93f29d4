"""Judges of Walton's claims about what the spheres are like: order, restitution, stiffness."""

from dataclasses import replace
from functools import partial
from itertools import chain
from math import inf

import numpy as np

from sim.claims.checks import above, beside, in_parts, reported, withheld, within
from sim.claims.chute import (
    CELLS,
    DEEPEST,
    SOFT,
    STIFF,
    at_depth,
    lasting,
    of_settled,
    repeated,
    still_changing,
    unlike,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, trend
from sim.claims.place import Place, quotient
from sim.claims.states import has_plug, of_most, shares
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures import layers

#: Depths with crystals, and the least share of crystalline spheres there.
CRYSTALLINE, SHARE = (10, 20, DEEPEST), 0.5

#: Depth and cell of the controls, the spread of diameters, and the wide cell.
CONTROLLED, SPREAD, WIDE = {"depth": 10, "cell": 5}, 0.1, 20

#: Depths at which the restitution is varied, by part; the values that decide and one reported.
RESILIENT = {"a": 5, "b": 10, "c": 20}
RESTITUTIONS, LOWEST = (0.7, 0.95), 0.6

#: Overlaps in the paper's words.
DYNAMIC, SLIGHT = 0.05, 0.005

#: Depths that depend on the stiffness and those that do not, and stiffnesses that decide it.
SENSITIVE = (20, DEEPEST)
INSENSITIVE = (1.24, 2.5)

#: Heights in diameters of the layer immediately above the bottommost one.
ABOVE_BOTTOM = (1, 2)

#: Replicates in one state without which states are not compared.
FEW = 2


def w15(evidence: Evidence) -> list[Check]:
    """Crystals at three depths of one age (a), and three factors that favour them (b, c, d)."""
    return in_parts(
        a=lambda: _crystals(evidence),
        b=lambda: _favoured(evidence, f"diameters ±{100 * SPREAD:g} %", diameter_spread=SPREAD),
        c=lambda: _on_bumps(evidence),
        d=lambda: _favoured(evidence, f"a cell of {WIDE} σ", cell=WIDE),
    )


def _crystals(evidence: Evidence) -> list[Check]:
    row = lasting(evidence)
    deep = [(row if n == DEEPEST else evidence).at("chute", depth=n) for n in CRYSTALLINE]
    checks = []
    for place in deep:
        share, at = place.value("crystalline_share"), at_depth(place)
        check = above(f"crystalline share of the plug, {at}", share, SHARE, [place])
        check = of_most(check, place, place.values("crystalline_share"))
        reason = still_changing(place) or unlike(deep, cells=False)
        checks += withheld([check], reason)
        layered = place.value("layer_order")
        checks.append(reported(f"amplitude of its layers, {at}", layered, [place]))
    return checks


def _on_bumps(evidence: Evidence) -> list[Check]:
    line = evidence.line("chute", "bumps", **CONTROLLED)
    size = max(line, default=0)
    if not size > 0:
        raise Untestable("no flow over a bumpy plane")
    return _favoured(evidence, f"bumps of {size:g} σ", bumps=size)


def _favoured(evidence: Evidence, name: str, **change: float) -> list[Check]:
    """Return the check that the crystalline share ranks above that of a control, state by state."""
    usual = evidence.at("chute", **CONTROLLED)
    control = evidence.at("chute", **CONTROLLED | change)
    what = f"share of pairs more crystalline than with {name}, n = {CONTROLLED['depth']:g}"
    first, second = (place.values("crystalline_share") for place in (usual, control))
    try:
        first, second, state = same_state(usual, control, first, second)
        check, reason = outranks(f"{what}, {state}", first, second, [usual, control]), ""
    except Untestable as error:
        check, reason = outranks(what, first, second, [usual, control]), str(error)
    changed = usual["cell"] != control["cell"]
    moving = (
        still_changing(usual)
        or still_changing(control)
        or unlike([usual, control], cells=not changed)
    )
    told = shares("usual", [usual]) + shares(f"with {name}", [control])
    return [*withheld([check], moving or reason), *told]


def same_state(
    one: Place, other: Place, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return quantities (R,) of two points in the state that both are in most often, and which.

    Raises `Untestable` where they share none.
    """
    plugs = has_plug(one), has_plug(other)
    alike = {
        name: (first[plugs[0] == state], second[plugs[1] == state])
        for name, state in (("with a plug", True), ("without a plug", False))
    }
    name, (ours, theirs) = max(alike.items(), key=lambda held: min(map(len, held[1])))
    if min(len(ours), len(theirs)) < FEW:
        raise Untestable("the two are in different states: more replicates of both")
    return ours, theirs, name


def w16(evidence: Evidence) -> list[Check]:
    """Trends of V and of the shear depth over the restitution, at each of three depths.

    With 1,000 N/m where that was run: flows that 100 N/m lets run away are outside its range.
    """
    return in_parts(
        **{part: partial(_over_restitution, evidence, n) for part, n in RESILIENT.items()}
    )


def _over_restitution(evidence: Evidence, depth: float) -> list[Check]:
    where = {"depth": depth, "cell": CELLS[depth]}
    for stiffness in (STIFF, SOFT):
        line = repeated(evidence.line("chute", "restitution", **where, stiffness=stiffness))
        flows = {e: p for e, p in line.items() if RESTITUTIONS[0] <= e <= RESTITUTIONS[1]}
        if len(flows) > 2:
            break
    else:
        raise Untestable(f"no three coefficients of restitution with replicates at n = {depth:g}")
    places, at = list(flows.values()), f"n = {depth:g}, K1 = {stiffness:g} N/m"
    checks = []
    for what, name, rising in (("V", "velocity", False), ("shear depth", "shear_depth", True)):
        groups = [place.values(name) for place in places]
        over = ", ".join(f"{e:g}" for e in flows)
        checks.append(trend(f"{what} over e = {over}, {at}", [groups], places, rising=rising))
    reasons = dict.fromkeys(filter(None, [*map(still_changing, places), unlike(places)]))
    found = withheld(checks, "; ".join(reasons))
    if LOWEST in line:
        ratio = quotient(line[LOWEST].velocity, places[0].velocity)
        what = f"V at e = {LOWEST:g} over that at {RESTITUTIONS[0]:g}, {at}"
        found.append(reported(what, ratio, [line[LOWEST], places[0]]))
    return found


def w20(evidence: Evidence, order: float) -> list[Check]:
    """Overlaps of the softest spheres, within a factor ``order`` of the paper's."""
    return in_parts(
        a=lambda: [check for n in INSENSITIVE for check in _shallow_overlap(evidence, n, order)],
        b=lambda: _deep_overlap(evidence, order),
        c=lambda: _static_overlap(evidence, order),
    )


def _shallow_overlap(evidence: Evidence, depth: float, order: float) -> list[Check]:
    place = evidence.at("chute", depth=depth, stiffness=SOFT)
    bounds = SLIGHT / order, SLIGHT * order
    check = _overlap("median overlap", place, "median_overlap", bounds)
    extreme = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    return of_settled([check, *beside([extreme])], [place])


def _deep_overlap(evidence: Evidence, order: float) -> list[Check]:
    place = evidence.at("chute", depth=DEEPEST, stiffness=SOFT)
    bounds = DYNAMIC / order, DYNAMIC * order
    check = _overlap("99.9th percentile of the overlaps", place, "overlap_999", bounds)
    check = of_most(check, place, 100 * place.values("overlap_999"))
    median = 100 * place.value("median_overlap")
    return of_settled([check, reported("median overlap, n = 40", median, [place])], [place])


def _static_overlap(evidence: Evidence, order: float) -> list[Check]:
    place = evidence.at("chute", depth=DEEPEST, stiffness=SOFT, angle=0)
    bounds = SLIGHT / order, SLIGHT * order
    check = _overlap("mean overlap of the base contacts at rest", place, "base_overlap", bounds)
    moves = "" if place.regime == "arrested" else "the bed on the level plane is not at rest"
    # At rest nothing fluctuates, so that samples are not what is lacking.
    return withheld([replace(check, samples=inf)], moves)


def _overlap(what: str, place: Place, name: str, bounds: tuple[float, float]) -> Check:
    low, high = (100 * bound for bound in bounds)
    what = f"{what}, n = {place['depth']:g}"
    return within(what, 100 * place.value(name), low, high, [place], "% of σ")


def w21(evidence: Evidence, equal: float) -> list[Check]:
    """Stiffer against softest: V of shallow flows the same but for a share ``equal`` (a), V and
    shear depth of deep ones not (b)."""
    return in_parts(
        a=lambda: chain.from_iterable(_insensitive(evidence, n, equal) for n in INSENSITIVE),
        b=lambda: chain.from_iterable(_sensitive(evidence, n) for n in _comparable(evidence)),
    )


def _comparable(evidence: Evidence) -> list[float]:
    """Return the sensitive depths, without the deepest where no flow of the softest lasts there.

    Then there is nothing to compare at that depth, whatever is run.
    """
    softest = evidence.line("chute", "stiffness", depth=DEEPEST).get(SOFT)
    lasts = softest is not None and softest.regime != "accelerating"
    return [n for n in SENSITIVE if n != DEEPEST or lasts]


def _insensitive(evidence: Evidence, depth: float, equal: float) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth):
        what = f"V at K1 = {stiffness:g} N/m over {SOFT} N/m, n = {depth:g}"
        ratio = quotient(stiff.velocity, soft.velocity)
        pair = [soft, stiff]
        found = withheld([within(what, ratio, 1 - equal, 1 + equal, pair)], unlike(pair))
        checks += _of_stiffness(of_settled(found, pair), stiffness)
    return checks


def _sensitive(evidence: Evidence, depth: float) -> list[Check]:
    checks = []
    for stiffness, soft, stiff in _stiffer(evidence, depth):
        at, pair = f"{stiffness:g} N/m against {SOFT} N/m, n = {depth:g}", [soft, stiff]
        speeds = [place.values("velocity") for place in pair]
        depths = [place.values("shear_depth") for place in pair]
        found = [
            outranks(f"share of pairs slower with {at}", speeds[0], speeds[1], pair),
            outranks(f"share of pairs with a deeper shear layer, {at}", depths[1], depths[0], pair),
        ]
        reason = still_changing(soft) or still_changing(stiff) or unlike(pair)
        checks += _of_stiffness(withheld(found, reason), stiffness)
        checks += shares(f"{SOFT} N/m, n = {depth:g}", [soft])
        checks += shares(f"{stiffness:g} N/m, n = {depth:g}", [stiff])
    return checks


def w22(evidence: Evidence) -> list[Check]:
    """Vertical granular temperature of the layer above the bottommost, stiffer above softest."""
    checks = []
    for n in _comparable(evidence):
        for stiffness, soft, stiff in _stiffer(evidence, n):
            what = f"share of pairs more agitated with {stiffness:g} N/m than {SOFT} N/m, n = {n:g}"
            first, second = (_agitation(place) for place in (stiff, soft))
            reason = still_changing(soft) or still_changing(stiff) or unlike([soft, stiff])
            try:
                first, second, state = same_state(stiff, soft, first, second)
                what += f", {state}"
            except Untestable as error:
                reason = reason or str(error)
            found = withheld([outranks(what, first, second, [stiff, soft])], reason)
            checks += _of_stiffness(found, stiffness)
    return checks


def _stiffer(evidence: Evidence, depth: float) -> list[tuple[float, Place, Place]]:
    """Return stiffnesses above the softest, with the places of the softest and of theirs.

    Raises `Untestable` where there is none with ten times the stiffness.
    """
    line = repeated(evidence.line("chute", "stiffness", depth=depth))
    if SOFT not in line or STIFF not in line:
        raise Untestable(f"no flows with K1 = {SOFT} and {STIFF} N/m at n = {depth:g}")
    return [(value, line[SOFT], place) for value, place in line.items() if value >= STIFF]


def _of_stiffness(checks: list[Check], stiffness: float) -> list[Check]:
    """Return checks that vote at ten times the softest; stiffer spheres are shown beside."""
    return checks if stiffness == STIFF else beside(checks)


def _agitation(place: Place) -> np.ndarray:
    """Return the vertical granular temperature (R,) in m²/s² above the bottom layer."""
    low, high = (bound * place["diameter"] for bound in ABOVE_BOTTOM)

    def mean(height: np.ndarray, temperature: np.ndarray, packing: np.ndarray) -> float:
        return layers.mean_between(height, temperature, packing, low, high)

    return place.each(mean, "vertical_temperature_profile", "packing_profile")
