"""Helpers of the judges of chute flows: units, flows of the base case, steadiness, states.

A deep flow may ride as a plug on its shear layer. Replicates of one point may stay in different
states for the whole run. Then the mean over all of them is meaningless; shares of runs and means
within a state are not.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import inf, isfinite, nan, radians, sin
from typing import Any

import numpy as np
from scipy.stats import chi2
from uncertainties import UFloat

from sim.claims.checks import reported
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import reported_share, share_above
from sim.claims.place import Place, replicate_mean, select_replicated
from sim.claims.verdict import LONGER_RUNS, Check, Untestable
from sim.measures import layers

#: Largest change of V over the window, relative to V, of a settled flow.
DRIFT = 0.1

#: Widths of the cell in diameters. The paper has 5 or 10; the widest is a control.
WIDTHS = (5, 10, 20)

#: Ages of compared flows count as equal up to this relative difference: averaging begins with a
#: sample.
ONE_SAMPLE = 0.01

#: Cell by depth, for flows that differ in another parameter.
CELLS = {1.24: 10, 2.5: 10, 5: 10, 10: 5, 20: 5, 40: 5}

#: Stiffness (N/m) of the softest spheres, which are those of the base case.
SOFT = 100


def natural_speed(place: Place) -> float:
    """Return √(gσ) of a place, m/s."""
    return (place["gravity"] * place["diameter"]) ** 0.5


def driving_acceleration(place: Place) -> float:
    """Return g sin θ of a place, m/s²."""
    return place["gravity"] * sin(radians(place["angle"]))


def lost_power(place: Place) -> np.ndarray:
    """Return the power (W) that collisions and friction dissipate, (R,)."""
    return place.values("normal_power") + place.values("frictional_power")


def lost_share(place: Place) -> np.ndarray:
    """Return the power lost over that of gravity, N m g V sin θ, (R,)."""
    weight = place["particles"] * place["mass"] * driving_acceleration(place)
    return lost_power(place) / (weight * place.values("velocity"))


def acceleration(place: Place) -> UFloat:
    """Return dV/dt over g sin θ, from the mean signed slope of all replicates."""
    return place.velocity_change / place.window / driving_acceleration(place)


def base_flows(evidence: Evidence, min_depth: float = 0.0) -> dict[float, Place]:
    """Return the flows of the base case by depth, from ``min_depth`` on."""
    line = evidence.line("chute", "depth", cell=ANY)
    return {depth: place for depth, place in line.items() if depth >= min_depth}


def flows_of_one_age(evidence: Evidence, wheres: Sequence[Mapping[str, Any]]) -> list[Place]:
    """Return flows whose averages begin at one age, in the order of their parameters.

    Deep flows order and change with time, so that flows of different ages differ by that alone. Of
    the ages that all have with replicates, that with the most of them is chosen, then the oldest.
    Without a common age, each flow is the one that has most replicates. Raises `Untestable` where
    there is none.
    """
    lines = [select_replicated(evidence.line("chute", "transient", **where)) for where in wheres]
    common = set.intersection(*map(set, lines))
    if not common:
        return [evidence.at("chute", **where, transient=ANY) for where in wheres]
    start = max(common, key=lambda start: (min(line[start].completed for line in lines), start))
    return [line[start] for line in lines]


def stiffness_suffix(place: Place) -> str:
    """Return the part of a label that names the stiffness; empty for the softest spheres.

    >>> stiffness_suffix({"stiffness": 1000.0})
    ', K1 = 1000 N/m'
    """
    return f", K1 = {place['stiffness']:g} N/m" if place["stiffness"] > SOFT else ""


def depth_label(place: Place) -> str:
    """Return the label of a deep flow: its depth, and its stiffness if not the softest.

    >>> depth_label({"depth": 40.0, "stiffness": 1000.0})
    'n = 40, K1 = 1000 N/m'
    """
    return f"n = {place['depth']:g}{stiffness_suffix(place)}"


def steady_flows(evidence: Evidence) -> dict[float, Place]:
    """Return the steady flows of the base case by depth; raise `Untestable` without any."""
    flows = {n: place for n, place in base_flows(evidence).items() if place.regime == "steady"}
    if not flows:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case")
    return flows


def is_flowing(place: Place) -> bool:
    """True where a flow moves."""
    return place.regime not in ("arrested", "failed")


def reason_unsettled(place: Place) -> str:
    """Return why a flow has not settled; empty for a settled flow.

    A settled flow moves, and its replicates do not contradict each other. The mean of their slopes
    changes V by less than 10 % over the window.
    """
    if place.regime == "mixed":
        return f"the flow at n = {place['depth']:g} is of several regimes"
    return _reason_moving(place, "has not settled")


def reason_unrankable(place: Place) -> str:
    """Return why a flow cannot be ranked yet; empty if it can.

    A flow at rest cannot be ranked, and neither can one whose mean slope changes V by 10 %. Ranks
    need no steady mean, so flows in several states count.
    """
    return _reason_moving(place, "still changes")


def _reason_moving(place: Place, changing: str) -> str:
    problem = ""
    if not is_flowing(place):
        problem = "does not move"
    elif place.regime == "accelerating":
        problem = "accelerates"
    elif not abs(place.velocity_change.nominal_value) < DRIFT * abs(place.velocity.nominal_value):
        problem = f"{changing}: {LONGER_RUNS}"
    return problem and f"the flow at n = {place['depth']:g} {problem}"


def reasons_unrankable(places: Sequence[Place], compare_cells: bool = True) -> str:
    """Return all reasons why flows cannot be ranked, or not against each other; empty if none."""
    reasons = [*map(reason_unrankable, places), reason_incomparable(places, compare_cells)]
    return "; ".join(dict.fromkeys(filter(None, reasons)))


def reason_incomparable(places: Sequence[Place], compare_cells: bool = True) -> str:
    """Return how flows differ in age or cell, which a comparison must not mix; empty if not.

    ``compare_cells`` is false where the cell itself is compared, or where no cells are.
    """
    widths = sorted({place["cell"] for place in places}) if compare_cells else []
    if len(widths) > 1:
        return f"cells of {' and '.join(f'{cell:g}' for cell in widths)} σ are compared"
    ages = sorted(age(place) for place in places)
    if ages[-1] > (1 + ONE_SAMPLE) * ages[0]:
        return f"flows of ages {ages[0]:.0f} and {ages[-1]:.0f} √(σ/g) are compared"
    return ""


def withhold_unsettled(checks: Iterable[Check], places: Iterable[Place]) -> list[Check]:
    """Return checks on means over the window; those on unsettled flows decide nothing.

    ``places`` are all flows behind the checks.
    """
    reasons = {place.id: reason_unsettled(place) for place in places}
    withheld_checks = []
    for check in checks:
        causes = {point: reasons[point] for point in check.points if reasons.get(point)}
        short = tuple(point for point, reason in causes.items() if LONGER_RUNS in reason)
        text = check.withheld or "; ".join(dict.fromkeys(causes.values()))
        withheld_checks.append(replace(check, withheld=text, short=check.short or short))
    return withheld_checks


def waive_samples(check: Check, place: Place) -> Check:
    """Return a check on dV/dt of a flow, without a need for samples if the flow accelerates.

    Evident acceleration needs no further independent samples.
    """
    return replace(check, samples=inf) if place.regime == "accelerating" else check


def age(place: Place) -> float:
    """Return the time in √(σ/g) from the start of the run to the start of averaging."""
    unit = natural_speed(place) / place["gravity"]
    return float(place.values("average_start").mean()) / unit


PROFILES = ("velocity_profile", "packing_profile")


def plug_shares(place: Place) -> np.ndarray:
    """Return the share of the depth taken by the plug, (R,)."""
    return place.measure_replicates(
        partial(layers.plug_share, diameter=place["diameter"]), *PROFILES
    )


def has_plug(place: Place) -> np.ndarray:
    """True per replicate (R,) that rides as a plug of more than 30 % of its depth."""
    return plug_shares(place) > layers.MIN_PLUG_SHARE


def majority_if_mixed(check: Check, place: Place, values: np.ndarray) -> Check:
    """Return the check of a mean, or of a majority of runs where these are in different states.

    The mean of a mixture belongs to no state, and its interval is not Student's. The test is then
    whether more than half of the runs, with ``values`` (R,), lie between the thresholds.
    """
    plugs = has_plug(place)
    if plugs.all() or not plugs.any():
        return check
    inside = int(((values > check.low) & (values < check.high)).sum())
    quantity = f"share of runs, {plugs.sum()} of {plugs.size} with a plug, that hold: {check.what}"
    return share_above(quantity, inside, plugs.size, 0.5, [place])


def report_states(quantity: str, places: Sequence[Place]) -> list[Check]:
    """Report the states of flows: the share of runs with a plug, and the mean V of each state."""
    plugs = np.concatenate([has_plug(place) for place in places])
    speeds = np.concatenate([place.values("velocity") for place in places])
    checks = [reported_share(f"{quantity}: runs with a plug", int(plugs.sum()), plugs.size, places)]
    for name, state in (("with", plugs), ("without", ~plugs)):
        if state.any():
            mean = f"{quantity}: V of the runs {name} a plug"
            check = reported(mean, replicate_mean(speeds[state]), places, "m/s")
            if state.sum() == 1:
                check = replace(check, half_width=nan, text=f"{check.value:.3g} (one run)")
            checks.append(check)
    return [*checks, *_report_lifetimes(quantity, places)]


def _report_lifetimes(quantity: str, places: Sequence[Place]) -> list[Check]:
    """Report share of the time and lifetime of each state of a flow.

    Runs from before states were recorded have no such checks.
    """
    try:
        times, endings = (
            {
                state: np.concatenate([place.values(f"{state}_{name}") for place in places])
                for state in layers.STATES
            }
            for name in ("time", "endings")
        )
    except Untestable:
        return []
    window, checks = sum(times.values()), []
    for state, time in times.items():
        if np.nansum(time) > 0:
            share = (time / window)[np.isfinite(time)]
            checks.append(
                reported(f"{quantity}: share of the time {state}", replicate_mean(share), places)
            )
            label = f"{quantity}: lifetime of the state {state}"
            lifetime = state_lifetime(float(np.nansum(time)), int(np.nansum(endings[state])))
            checks.append(_report_lifetime(label, lifetime, places))
    return checks


def _report_lifetime(
    label: str, lifetime: tuple[float, float, float], places: Sequence[Place]
) -> Check:
    value, low, _ = lifetime
    ended = isfinite(value)
    value_text, low_text, high_text = (f"{float(f'{time:.3g}'):,g}" for time in lifetime)
    text = f"{value_text} ({low_text} to {high_text})" if ended else f"never ended, > {low_text}"
    check = reported(label, value if ended else low, places, "s")
    return replace(check, half_width=nan, text=text)


def state_lifetime(time: float, endings: int) -> tuple[float, float, float]:
    """Return the lifetime of a state that ends at random and its 95 % interval.

    ``time`` is that in the state over all runs. The interval is that of a rate of ``endings``
    events. A state that never ended has a lower bound alone, at 95 % confidence.
    """
    if not endings:
        return inf, 2.0 * time / float(chi2.ppf(0.95, 2)), inf
    low = 2.0 * time / float(chi2.ppf(0.975, 2 * endings + 2))
    return time / endings, low, 2.0 * time / float(chi2.ppf(0.025, 2 * endings))
