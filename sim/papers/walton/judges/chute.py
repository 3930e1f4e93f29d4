"""Helpers of the judges of chute flows: units, flows of the base case, tests for steadiness."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf, radians, sin
from typing import Any

from uncertainties import UFloat

from sim.claims.evidence import ANY, Evidence
from sim.claims.place import Place
from sim.claims.verdict import LONGER_RUNS, Check, Untestable

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


def _is_changing(place: Place) -> bool:
    """True where the mean slope of the replicates changes V by 10 % over the window."""
    return not abs(place.velocity_change.nominal_value) < DRIFT * abs(place.velocity.nominal_value)


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
    elif _is_changing(place):
        problem = f"{changing}: {LONGER_RUNS}"
    return problem and f"the flow at n = {place['depth']:g} {problem}"


def reasons_unrankable(places: Sequence[Place]) -> str:
    """Return all reasons why flows cannot be ranked, or not against each other."""
    reasons = [*map(reason_unrankable, places), reason_incomparable(places)]
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


def reason_unranked(places: Sequence[Place], compare_cells: bool = True) -> str:
    """Return why flows cannot be ranked, or not against each other; empty if they can."""
    reasons = [*map(reason_unrankable, places), reason_incomparable(places, compare_cells)]
    return next(filter(None, reasons), "")


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


def select_replicated(line: Mapping[float, Place], replicates: int = 2) -> dict[float, Place]:
    """Return the flows of a line that have at least ``replicates`` completed replicates."""
    return {value: place for value, place in line.items() if place.completed >= replicates}
