"""Judges of Walton's claims about flows as a whole: velocity and depth, energy, forces."""

from dataclasses import replace
from math import inf, nan, radians, tan

import numpy as np

from sim.claims.checks import below, remove_votes, reported, within
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import pooled_checks, trend
from sim.claims.place import Place, replicate_mean
from sim.claims.verdict import Check, Untestable
from sim.papers.walton.judges.chute import (
    WIDTHS,
    base_flows,
    driving_acceleration,
    reason_unrankable,
    select_replicated,
    steady_flows,
)

#: Least number of depths over which the velocity tends to rise.
MIN_DEPTHS = 6

#: Deviation of the dissipated power from N m g V sin θ that is shown as a threshold.
POWER = 0.02


def w5(evidence: Evidence, *, max_missing: float) -> list[Check]:
    """Largest missing energy of all replicates of all flows along any parameter of the paper.

    Points where a replicate has no ledger leave the claim open.
    """
    lines = [base_flows(evidence)]
    for along in ("friction", "restitution", "stiffness"):
        lines += [
            evidence.line("chute", along, depth=depth, cell=ANY, initial_velocity=ANY)
            for depth in lines[0]
        ]
    places = {place.id: place for line in lines for place in line.values()}
    missing_energy = {key: place.values("missing_energy") for key, place in places.items()}
    largest = {
        key: np.nanmax(values)
        for key, values in missing_energy.items()
        if np.isfinite(values).any()
    }
    if not largest:
        raise Untestable(f"no {evidence.protocol} flow with a ledger")
    worst = max(largest, key=largest.__getitem__)
    quantity = f"largest share of the energy that a ledger lacks, {len(largest)} points"
    checks = [below(quantity, largest[worst], max_missing, [places[worst]])]
    unknown = [
        places[key] for key, values in missing_energy.items() if not np.isfinite(values).all()
    ]
    if unknown:
        quantity = f"share of the energy where a replicate has no ledger, {len(unknown)} points"
        checks.append(below(quantity, nan, max_missing, unknown))
    # A ledger is exact bookkeeping: it needs no independent samples.
    return [replace(check, samples=inf) for check in checks]


def w9(evidence: Evidence, *, depths: tuple[float, float], deepest: float) -> list[Check]:
    """Trend of V from one depth to another, within each width of the cell.

    A depth counts once, by the mean of its replicates: the sentence is about depths. The deepest
    flow drifts, so it enters with a bound: the lowest velocity of any of its windows.
    """
    strata: list[list[np.ndarray]] = []
    places: list[Place] = []
    ranked: set[float] = set()
    low, high = depths
    for cell in WIDTHS:
        line = select_replicated(evidence.line("chute", "depth", cell=cell, transient=ANY))
        flows = {n: place for n, place in line.items() if low <= n <= high}
        flows = {n: place for n, place in flows.items() if not reason_unrankable(place)}
        groups = [np.array([place.values("velocity").mean()]) for place in flows.values()]
        windows = evidence.line("chute", "transient", depth=deepest, cell=cell)
        if windows:
            groups.append(
                np.array([min(window.values("velocity").min() for window in windows.values())])
            )
        if len(groups) > 1:
            strata.append(groups)
            places += flows.values()
            ranked |= flows.keys()
    if len(ranked) < MIN_DEPTHS or max(ranked, default=0) < high:
        raise Untestable(
            f"fewer than six depths from {low} to {high} whose flow does not accelerate"
        )
    return [trend(f"V and n, {len(ranked)} depths", strata, places)]


def w24(evidence: Evidence, *, min_share: float) -> list[Check]:
    """Share of friction in the losses of steady flows; their sum over N m g V sin θ has no vote."""
    flows = select_replicated(steady_flows(evidence))
    if not flows:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case with replicates")
    checks = []
    for n, place in flows.items():
        friction_power = place.values("frictional_power")
        collision_power = place.values("normal_power")
        weight = place["particles"] * place["mass"] * driving_acceleration(place)
        total = replicate_mean(
            (friction_power + collision_power) / (weight * place.values("velocity"))
        )
        share = replicate_mean(friction_power / (friction_power + collision_power))
        label = f"n = {n:g}"
        quantity = f"share of friction in the losses, {label}"
        checks.append(within(quantity, share, min_share, 1 - min_share, [place]))
        checks.append(reported(f"share of collisions in them, {label}", 1 - share, [place]))
        quantity = f"dissipated power over N m g V sin θ, {label}"
        checks += remove_votes([within(quantity, total, 1 - POWER, 1 + POWER, [place])])
    return checks


def w26(evidence: Evidence, *, max_ratio_error: float, max_normal_error: float) -> list[Check]:
    """Base forces of the steady flows against their weight, pooled over the flows.

    A single flow is known to half a percent at best, so it counts only where it clearly deviates.
    """
    ratios, pressures, flows = [], [], steady_flows(evidence)
    for place in flows.values():
        angle = radians(place["angle"])
        normal = place.value("base_normal", "base_normal_error")
        shear = place.value("base_shear", "base_shear_error")
        weight = place["particles"] * place["mass"] * place["gravity"]
        ratios.append(shear / normal / tan(angle) - 1)
        pressures.append(normal / (weight * np.cos(angle)) - 1)
    return [
        *pooled_checks("shear/normal over tan θ, less 1", flows, ratios, max_ratio_error),
        *pooled_checks("normal over N m g cos θ, less 1", flows, pressures, max_normal_error),
    ]
