"""Judges of Walton's claims about restitution: velocity, shear, agitation and losses."""

from contextlib import suppress
from functools import partial

import numpy as np

from sim.claims.checks import Numbers, Pair, correct_for, judge_parts, reported, withhold
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import reported_order, trend
from sim.claims.place import Place, quotient, replicate_mean, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.walton.judges.chute import (
    CELLS,
    SOFT,
    flows_of_one_age,
    lost_power,
    natural_speed,
    reasons_unrankable,
)

#: Depths at which the restitution is varied, by part, and the stiffness (N/m) of these flows, where
#: they were run.
RESILIENT, STIFFER = {"a": 5, "b": 10, "c": 20}, 1000


def w16(evidence: Evidence, *, restitutions: Pair) -> list[Check]:
    """Trends of V and of the shear depth from one restitution to another, at three depths."""
    return judge_parts(
        **{
            part: partial(_slower_and_deeper, evidence, n, restitutions)
            for part, n in RESILIENT.items()
        }
    )


def _slower_and_deeper(evidence: Evidence, depth: float, restitutions: Pair) -> list[Check]:
    places = _flows_over_restitution(evidence, depth, restitutions)
    checks, orders = [], []
    for quantity, name, rising in (("V", "velocity", False), ("shear depth", "shear_depth", True)):
        groups = [place.values(name) for place in places]
        quantity_over_e = f"{quantity} over e = {_values(places)}, {_label(places)}"
        check = trend(quantity_over_e, [groups], places, rising=rising)
        checks.append(correct_for(len(RESILIENT), check))
        order = f"{quantity} {'rises' if rising else 'falls'} over e, {_label(places)}"
        orders.append(reported_order(order, [groups], rising=rising))
    return withhold([*checks, *orders], reasons_unrankable(places))


def w27(evidence: Evidence, *, restitutions: Pair, near: Pair, far: Pair) -> list[Check]:
    """Trend over the restitution of T_z of a far layer (σ) over that of a near one, by depth."""
    return judge_parts(
        **{
            part: partial(_reach, evidence, n, restitutions, near, far)
            for part, n in RESILIENT.items()
        }
    )


def _reach(
    evidence: Evidence, depth: float, restitutions: Pair, near: Pair, far: Pair
) -> list[Check]:
    places = _flows_over_restitution(evidence, depth, restitutions)

    def ratio(height: np.ndarray, temperature: np.ndarray, packing: np.ndarray) -> float:
        diameter = places[0]["diameter"]
        upper, lower = (
            layers.mean_between(height, temperature, packing, low * diameter, high * diameter)
            for low, high in (far, near)
        )
        return upper / lower

    names = "vertical_temperature_profile", "packing_profile"
    groups = [place.measure_replicates(ratio, *names) for place in places]
    quantity = f"T_z at {far[0]} to {far[1]} σ over that at {near[0]} to {near[1]} σ"
    check = trend(f"{quantity}, over e = {_values(places)}, {_label(places)}", [groups], places)
    return [
        *withhold([correct_for(len(RESILIENT), check)], reasons_unrankable(places)),
        *(
            reported(
                f"{quantity}, e = {place['restitution']:g}, {_label(places)}",
                replicate_mean(group),
                [place],
            )
            for place, group in zip(places, groups, strict=True)
        ),
    ]


def w28(evidence: Evidence, *, restitutions: Pair, depths: Numbers) -> list[Check]:
    """Trend over the restitution of the power lost per sphere, flows of a depth together.

    Depths whose flows cannot be ranked are left out.
    """
    strata, flows, reports = [], [], []
    for n in depths:
        with suppress(Untestable):
            places = _flows_over_restitution(evidence, n, restitutions)
            if reasons_unrankable(places):
                continue
            losses = [_loss_per_sphere(place) for place in places]
            strata.append(losses)
            flows += places
            quantity = f"loss at e = {_values(places[-1:])} over that at {_values(places[:1])}"
            ratio = quotient(*(replicate_mean(losses[end]) for end in (-1, 0)))
            reports.append(reported(f"{quantity}, {_label(places)}", ratio, places))
    if not strata:
        raise Untestable("no depth with three coefficients of restitution and replicates")
    return [trend(f"loss per sphere and e, {len(strata)} depths", strata, flows), *reports]


def _loss_per_sphere(place: Place) -> np.ndarray:
    """Return the power lost per sphere (R,), in m g √(gσ)."""
    return lost_power(place) / (
        place["particles"] * place["mass"] * place["gravity"] * natural_speed(place)
    )


def _flows_over_restitution(evidence: Evidence, depth: float, restitutions: Pair) -> list[Place]:
    """Return flows of one age over the restitution; raise `Untestable` for fewer than three."""
    where = {"depth": depth, "cell": CELLS[depth]}
    for stiffness in (STIFFER, SOFT):
        line = select_replicated(
            evidence.line("chute", "restitution", **where, stiffness=stiffness, transient=ANY)
        )
        compared = [e for e in line if restitutions[0] <= e <= restitutions[1]]
        if len(compared) > 2:
            wheres = [where | {"stiffness": stiffness, "restitution": e} for e in compared]
            return flows_of_one_age(evidence, wheres)
    raise Untestable(f"no three coefficients of restitution with replicates at n = {depth:g}")


def _values(places: list[Place]) -> str:
    return ", ".join(f"{place['restitution']:g}" for place in places)


def _label(places: list[Place]) -> str:
    return f"n = {places[0]['depth']:g}, K1 = {places[0]['stiffness']:g} N/m"
