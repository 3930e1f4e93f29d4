"""What judges of chute flows share: units, the flows of the base case, which of them are steady."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import hypot, inf, radians, sin

import numpy as np
from uncertainties import UFloat

from sim.claims.evidence import Evidence
from sim.claims.place import Place, measured
from sim.claims.verdict import SIGMAS, Check, Untestable

#: Largest change of the velocity over the window, relative to it, of a flow that has settled.
DRIFT = 0.1

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
    return place.value("acceleration", half_width="acceleration_half_width") / driving(place)


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


def speed(place: Place) -> UFloat:
    """Return the mean velocity (m/s), of flows that are not steady ± its change over the window.

    All replicates share that change, so it does not average out over them.
    """
    velocity = place.velocity
    if place.regime == "steady":
        return velocity
    half_width = hypot(SIGMAS * velocity.std_dev, _change(place))
    return measured(velocity.nominal_value, half_width)


def is_flowing(place: Place) -> bool:
    """Return whether a flow moves."""
    return place.regime not in ("arrested", "failed")


def is_settled(place: Place) -> bool:
    """Return whether a flow moves, does not accelerate, and changes V by < 10 % over the window.

    All of its replicates do: regimes that contradict each other are none.
    """
    if not is_flowing(place) or place.regime in ("accelerating", "mixed"):
        return False
    return _change(place) < DRIFT * abs(place.velocity.nominal_value)


def of_settled(checks: Iterable[Check], places: Iterable[Place]) -> list[Check]:
    """Return checks on means over the window; those on a flow that has not settled decide nothing.

    ``places`` are all that the checks are on.
    """
    unsettled = {place.id for place in places if not is_settled(place)}
    return [
        replace(check, samples=0.0) if unsettled & set(check.points) else check for check in checks
    ]


def of_trend(check: Check, place: Place) -> Check:
    """Return a check on dV/dt of a flow: one that accelerates evidently needs no more samples."""
    return replace(check, samples=inf) if place.regime == "accelerating" else check


def _change(place: Place) -> float:
    """Return by how much the velocity (m/s) changes over the window, root mean square over runs."""
    end = place.values("steps") * place.values("time_step_used")
    change = place.values("acceleration") * (end - place.values("average_start"))
    return float(np.sqrt(np.mean(change**2)))


def repeated(line: Mapping[float, Place], replicates: int = 2) -> dict[float, Place]:
    """Return the flows of a line with at least so many completed replicates."""
    return {value: place for value, place in line.items() if place.completed >= replicates}
