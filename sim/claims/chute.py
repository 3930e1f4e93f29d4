"""What judges of chute flows share: units, the flows of the base case, which of them are steady."""

from collections.abc import Mapping
from math import radians, sin

from uncertainties import UFloat

from sim.claims.evidence import Evidence, Place
from sim.claims.verdict import Untestable

#: Cells of the depths at which flows differ in another parameter.
CELLS = {1.24: 10, 2.5: 10, 5: 10, 10: 5, 20: 5, 40: 5}


def natural(place: Place) -> float:
    """Return √(gσ) of a place, m/s."""
    return (place["gravity"] * place["diameter"]) ** 0.5


def driving(place: Place) -> float:
    """Return g sin θ of a place, m/s²."""
    return place["gravity"] * sin(radians(place["angle"]))


def acceleration(place: Place) -> UFloat:
    """Return dV/dt over g sin θ."""
    return place.value("acceleration", "acceleration_error") / driving(place)


def base(evidence: Evidence, least: float = 0.0) -> dict[float, Place]:
    """Return the flows of the base case by depth, from the ``least`` depth on."""
    line = evidence.line("chute", "depth")
    return {depth: place for depth, place in line.items() if depth >= least}


def steady(evidence: Evidence) -> dict[float, Place]:
    """Return the steady flows of the base case by depth; raise `Untestable` without any."""
    found = {n: place for n, place in base(evidence).items() if place.regime == "steady"}
    if not found:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case")
    return found


def settled(place: Place) -> Place:
    """Return a place whose flow neither accelerates nor rests; raise `Untestable` for others."""
    if not is_settled(place):
        raise Untestable(f"{place.id}: {place.regime}, so that it has no steady velocity")
    return place


def is_settled(place: Place) -> bool:
    """Return whether the mean velocity of a flow may stand for a steady state."""
    return place.regime in ("steady", "undetermined")


def repeated(line: Mapping[float, Place], replicates: int = 2) -> dict[float, Place]:
    """Return the settled places of a line with at least so many completed replicates."""
    return {
        value: place
        for value, place in line.items()
        if place.completed >= replicates and is_settled(place)
    }
