"""Judges of Walton's claims about flows as a whole: depth, starts, energy."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from math import inf, nan
from string import ascii_lowercase

import numpy as np

from sim.claims.checks import (
    Numbers,
    Pair,
    below,
    judge_parts,
    remove_votes,
    reported,
    withhold,
    within,
)
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import same_by_rank, trend
from sim.claims.place import Place, quotient, replicate_mean, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.papers.walton.judges.chute import (
    CELLS,
    WIDTHS,
    base_flows,
    flows_of_one_age,
    is_flowing,
    lost_power,
    lost_share,
    natural_speed,
    reason_incomparable,
    reason_unrankable,
    reason_unsettled,
    reasons_unrankable,
    report_states,
    steady_flows,
    withhold_unsettled,
)

#: Least number of depths over which the velocity tends to rise.
MIN_DEPTHS = 6

#: Deviation of the dissipated power from N m g V sin θ that is shown as a threshold.
POWER = 0.02

#: Depths at which states are reported by start.
STATE_DEPTHS = (10, 20)

#: Largest distance of a start from the steady velocity it leads to, relative to it.
NEAR_TOLERANCE = 0.25


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


def w9(evidence: Evidence, *, depths: Pair, deepest: float) -> list[Check]:
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
        total = replicate_mean(lost_share(place))
        share = replicate_mean(place.values("frictional_power") / lost_power(place))
        label = f"n = {n:g}"
        quantity = f"share of friction in the losses, {label}"
        checks.append(within(quantity, share, min_share, 1 - min_share, [place]))
        checks.append(reported(f"share of collisions in them, {label}", 1 - share, [place]))
        quantity = f"dissipated power over N m g V sin θ, {label}"
        checks += remove_votes([within(quantity, total, 1 - POWER, 1 + POWER, [place])])
    return checks


def w23(
    evidence: Evidence, *, margin: float, depths: Numbers, slow: Pair, fast: Pair
) -> list[Check]:
    """Velocities after slower and faster starts equal that after the nearest one within ``margin``.

    Each of the ``depths`` is a part. The nearest start is the one closest to the velocity it led
    to. ``slow`` and ``fast`` are fractions of that velocity, each as numerator and denominator. The
    states of deep flows are reported by their start.
    """
    checks = judge_parts(
        **{
            part: partial(_check_starts, evidence, n, margin, slow, fast)
            for part, n in zip(ascii_lowercase, depths, strict=False)
        }
    )
    return [*checks, *chain.from_iterable(_report_start_states(evidence, n) for n in STATE_DEPTHS)]


def _check_starts(
    evidence: Evidence, depth: float, margin: float, slow: Pair, fast: Pair
) -> list[Check]:
    where = {"depth": depth, "cell": CELLS[depth]}
    starts = [*evidence.line("chute", "initial_velocity", **where, transient=ANY)]
    wheres = [where | {"initial_velocity": start} for start in starts]
    line = dict(zip(starts, flows_of_one_age(evidence, wheres), strict=True)) if starts else {}
    near = _nearest_start(line)
    missing = Untestable(f"no starts at V, half and twice of it at n = {depth:g}")
    if near is None:
        raise missing
    steady = line.pop(near)
    reached = steady.velocity.nominal_value / natural_speed(steady)
    relative = {start: start / reached for start in line}
    slowest, fastest = min(relative.values(), default=inf), max(relative.values(), default=0)
    is_spread = slowest <= slow[0] / slow[1] and fastest >= fast[0] / fast[1]
    if abs(near / reached - 1) > NEAR_TOLERANCE or not is_spread:
        raise missing
    checks: list[Check] = []
    for start, place in line.items():
        quantity = f"V after a start at {relative[start]:.2g} V, n = {depth:g}, over the usual V"
        pair = [place, steady]
        if depth in STATE_DEPTHS:
            # Runs in several states have no common mean.
            speeds = [flow.values("velocity") for flow in pair]
            ranked = same_by_rank(f"{quantity}, medians", speeds[0], speeds[1], margin, pair)
            checks += withhold([ranked], reasons_unrankable(pair))
            continue
        ratio = quotient(place.velocity, steady.velocity)
        bounds = 1 - margin, 1 + margin
        # A flow that has come to rest has not forgotten its start.
        moving = [flow for flow in pair if is_flowing(flow)]
        check = withhold([within(quantity, ratio, *bounds, pair)], reason_incomparable(pair))
        checks += withhold_unsettled(check, moving)
    return checks


def _report_start_states(evidence: Evidence, depth: float) -> list[Check]:
    line = evidence.line("chute", "initial_velocity", depth=depth, cell=CELLS[depth])
    reports: list[Check] = []
    for start, place in line.items():
        with suppress(Untestable):
            reports += report_states(f"start at {start:g} √(gσ), n = {depth:g}", [place])
    return reports


def _nearest_start(line: Mapping[float, Place]) -> float | None:
    """Return the start (√(gσ)) nearest to the velocity it led to, of settled flows if any."""

    def distance(start: float) -> tuple[bool, float]:
        place = line[start]
        reached = place.velocity.nominal_value / natural_speed(place)
        return bool(reason_unsettled(place)), abs(start / reached - 1)

    return min((start for start in line if is_flowing(line[start])), key=distance, default=None)
