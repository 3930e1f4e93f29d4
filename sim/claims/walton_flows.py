"""Judges of Walton's claims about flows as a whole: velocity and depth, energy, forces."""

from dataclasses import replace
from math import inf, nan, radians, tan

import numpy as np

from sim.claims.checks import below, remove_votes, reported, within
from sim.claims.chute import (
    DEEPEST,
    WIDTHS,
    base_flows,
    driving_acceleration,
    reason_unrankable,
    select_replicated,
    steady_flows,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.place import Place, replicate_mean
from sim.claims.trends import pooled_checks
from sim.claims.verdict import Check, Untestable
from sim.dataset.caveats import CLOSED_SHARE

#: Ends of the depths over which the velocity tends to rise, and the least number of them.
RISING_DEPTHS, MIN_DEPTHS = (1.24, 20), 6

#: Least share of the dissipated power for each of the two kinds of losses.
MIN_LOSS_SHARE = 0.05

#: Largest deviations of shear/normal from tan θ, of the normal force from N m g cos θ, and of the
#: dissipated power from N m g V sin θ.
RATIO, NORMAL, POWER = 0.005, 0.002, 0.02


def w5(evidence: Evidence) -> list[Check]:
    """Largest missing energy of all replicates of all flows along any parameter of the paper.

    Points where a replicate has no ledger leave the claim open.
    """
    lines = [base_flows(evidence)]
    for along in ("friction", "restitution", "stiffness"):
        lines += [evidence.line("chute", along, depth=depth) for depth in lines[0]]
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
    checks = [below(quantity, largest[worst], CLOSED_SHARE, [places[worst]])]
    unknown = [
        places[key] for key, values in missing_energy.items() if not np.isfinite(values).all()
    ]
    if unknown:
        quantity = f"share of the energy where a replicate has no ledger, {len(unknown)} points"
        checks.append(below(quantity, nan, CLOSED_SHARE, unknown))
    # A ledger is exact bookkeeping: it needs no independent samples.
    return [replace(check, samples=inf) for check in checks]


def w9(evidence: Evidence) -> list[Check]:
    """Trend of V over the depths, within each width of the cell.

    The deepest flow drifts, so it enters with a bound: the lowest velocity of any of its windows.
    """
    strata: list[list[np.ndarray]] = []
    places: list[Place] = []
    depths: set[float] = set()
    for cell in WIDTHS:
        line = select_replicated(evidence.line("chute", "depth", cell=cell))
        flows = {n: place for n, place in line.items() if RISING_DEPTHS[0] <= n <= RISING_DEPTHS[1]}
        flows = {n: place for n, place in flows.items() if not reason_unrankable(place)}
        groups = [place.values("velocity") for place in flows.values()]
        windows = evidence.line("chute", "transient", depth=DEEPEST, cell=cell)
        if windows:
            groups.append(
                np.array([min(window.values("velocity").min() for window in windows.values())])
            )
        if len(groups) > 1:
            strata.append(groups)
            places += flows.values()
            depths |= flows.keys()
    if len(depths) < MIN_DEPTHS or max(depths, default=0) < RISING_DEPTHS[1]:
        raise Untestable("fewer than six depths from 1.24 to 20 whose flow does not accelerate")
    return [trend(f"V and n, {len(depths)} depths", strata, places)]


def w24(evidence: Evidence) -> list[Check]:
    """Share of friction in the losses of steady flows; their sum over N m g V sin θ has no vote."""
    flows = select_replicated(steady_flows(evidence))
    if not flows:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case with replicates")
    checks = []
    for n, place in flows.items():
        friction_power, collision_power = (
            place.values("frictional_power"),
            place.values("normal_power"),
        )
        weight = place["particles"] * place["mass"] * driving_acceleration(place)
        total = replicate_mean(
            (friction_power + collision_power) / (weight * place.values("velocity"))
        )
        share, label = (
            replicate_mean(friction_power / (friction_power + collision_power)),
            f"n = {n:g}",
        )
        checks.append(
            within(
                f"share of friction in the losses, {label}",
                share,
                MIN_LOSS_SHARE,
                1 - MIN_LOSS_SHARE,
                [place],
            )
        )
        checks.append(reported(f"share of collisions in them, {label}", 1 - share, [place]))
        quantity = f"dissipated power over N m g V sin θ, {label}"
        checks += remove_votes([within(quantity, total, 1 - POWER, 1 + POWER, [place])])
    return checks


def w26(evidence: Evidence) -> list[Check]:
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
        *pooled_checks("shear/normal over tan θ, less 1", flows, ratios, -RATIO, RATIO),
        *pooled_checks("normal over N m g cos θ, less 1", flows, pressures, -NORMAL, NORMAL),
    ]
