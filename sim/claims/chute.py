"""What judges of chute flows share: units, the flows of the base case, which of them are steady."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf, radians, sin

from uncertainties import UFloat

from sim.claims.evidence import Evidence
from sim.claims.place import Place
from sim.claims.verdict import LONGER, Check, Untestable

#: Largest change of the velocity over the window, relative to it, of a flow that has settled.
DRIFT = 0.1

#: Widths of the cell in diameters: the paper has 5 or 10, the widest is a control.
WIDTHS = (5, 10, 20)

#: Ages of flows that are compared, the largest over the smallest, that count as equal. Averaging
#: begins with a sample, so that ages of 1,000 and 2,000 √(σ/g) are twice each other but for one.
EQUAL_AGE, ONE_SAMPLE = 2.0, 0.01

#: Cells of the depths at which flows differ in another parameter.
CELLS = {1.24: 10, 2.5: 10, 5: 10, 10: 5, 20: 5, 40: 5}

#: The deepest flows, and the stiffnesses (N/m) of the two base rows.
DEEPEST, SOFT, STIFF = 40, 100, 1000


def natural(place: Place) -> float:
    """Return √(gσ) of a place, m/s."""
    return (place["gravity"] * place["diameter"]) ** 0.5


def driving(place: Place) -> float:
    """Return g sin θ of a place, m/s²."""
    return place["gravity"] * sin(radians(place["angle"]))


def acceleration(place: Place) -> UFloat:
    """Return dV/dt over g sin θ, from the mean signed slope of all replicates."""
    return place.change / place.window / driving(place)


def base(evidence: Evidence, least: float = 0.0) -> dict[float, Place]:
    """Return the flows of the base case by depth, from the ``least`` depth on."""
    line = evidence.line("chute", "depth")
    return {depth: place for depth, place in line.items() if depth >= least}


def lasting(evidence: Evidence) -> Evidence:
    """Return the base row whose deepest flow lasts longest without change, the softest at a tie.

    Fast deep flows of the softest spheres overlap beyond the range of the contact law, so that
    none may last; then those of ten times the stiffness are judged, where they were run.
    """

    def lasts(row: Evidence) -> float:
        flows = repeated(row.line("chute", "transient", depth=DEEPEST, cell=CELLS[DEEPEST]))
        return max((age(flow) for flow in flows.values() if not still_changing(flow)), default=0.0)

    return max(evidence, evidence.under(stiffness=STIFF), key=lasts)


def stiffer(place: Place) -> str:
    """Return what tells a flow from those of the softest spheres, empty for one of these.

    >>> stiffer({"stiffness": 1000.0})
    ', K1 = 1000 N/m'
    """
    return f", K1 = {place['stiffness']:g} N/m" if place["stiffness"] > SOFT else ""


def at_depth(place: Place) -> str:
    """Return what tells a deep flow from others: its depth, and its stiffness if not the softest.

    >>> at_depth({"depth": 40.0, "stiffness": 1000.0})
    'n = 40, K1 = 1000 N/m'
    """
    return f"n = {place['depth']:g}{stiffer(place)}"


def steady(evidence: Evidence) -> dict[float, Place]:
    """Return the steady flows of the base case by depth; raise `Untestable` without any."""
    found = {n: place for n, place in base(evidence).items() if place.regime == "steady"}
    if not found:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case")
    return found


def is_flowing(place: Place) -> bool:
    """Return whether a flow moves."""
    return place.regime not in ("arrested", "failed")


def _changes(place: Place) -> bool:
    """Return whether the mean slope of its replicates changes V by 10 % over the window."""
    return not abs(place.change.nominal_value) < DRIFT * abs(place.velocity.nominal_value)


def unsettled(place: Place) -> str:
    """Return why a flow has not settled, empty for one that has.

    It moves, its replicates do not contradict each other, and the mean of their slopes changes V by
    less than 10 % over the window.
    """
    at = f"n = {place['depth']:g}"
    if not is_flowing(place):
        return f"the flow at {at} does not move"
    if place.regime in ("accelerating", "mixed"):
        says = "accelerates" if place.regime == "accelerating" else "is of several regimes"
        return f"the flow at {at} {says}"
    if _changes(place):
        return f"the flow at {at} has not settled: {LONGER}"
    return ""


def still_changing(place: Place) -> str:
    """Return why a flow cannot be ranked yet: it rests, or its mean slope changes V by 10 %.

    Ranks need no steady mean, so flows in several states count.
    """
    at = f"n = {place['depth']:g}"
    if not is_flowing(place):
        return f"the flow at {at} does not move"
    if place.regime == "accelerating":
        return f"the flow at {at} accelerates"
    if _changes(place):
        return f"the flow at {at} still changes: {LONGER}"
    return ""


def unlike(places: Sequence[Place], cells: bool = True) -> str:
    """Return how flows differ in what a comparison must not mix, age and cell; empty if not.

    Where the cell is what is compared, or none is, ``cells`` is false.
    """
    widths = sorted({place["cell"] for place in places}) if cells else []
    if len(widths) > 1:
        return f"cells of {' and '.join(f'{cell:g}' for cell in widths)} σ are compared"
    ages = sorted(age(place) for place in places)
    if ages[-1] > (1 + ONE_SAMPLE) * EQUAL_AGE * ages[0]:
        return f"flows of ages {ages[0]:.0f} and {ages[-1]:.0f} √(σ/g) are compared"
    return ""


def of_settled(checks: Iterable[Check], places: Iterable[Place]) -> list[Check]:
    """Return checks on means over the window; those on a flow that has not settled decide nothing.

    ``places`` are all that the checks are on.
    """
    reasons = {place.id: unsettled(place) for place in places}
    of_checks = []
    for check in checks:
        found = {point: reasons[point] for point in check.points if reasons.get(point)}
        short = tuple(point for point, reason in found.items() if LONGER in reason)
        told = check.withheld or "; ".join(dict.fromkeys(found.values()))
        of_checks.append(replace(check, withheld=told, short=check.short or short))
    return of_checks


def of_trend(check: Check, place: Place) -> Check:
    """Return a check on dV/dt of a flow: one that accelerates evidently needs no more samples."""
    return replace(check, samples=inf) if place.regime == "accelerating" else check


def age(place: Place) -> float:
    """Return the time in √(σ/g) after the start at which averaging began."""
    unit = natural(place) / place["gravity"]
    return float(place.values("average_start").mean()) / unit


def repeated(line: Mapping[float, Place], replicates: int = 2) -> dict[float, Place]:
    """Return the flows of a line with at least so many completed replicates."""
    return {value: place for value, place in line.items() if place.completed >= replicates}
