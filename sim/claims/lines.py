"""What judges of the belt share: places along a parameter and how their velocities compare."""

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise
from math import nan
from typing import Any

import numpy as np
from uncertainties import UFloat, ufloat, umath

from sim.claims.checks import above
from sim.claims.evidence import Evidence
from sim.claims.place import Place
from sim.claims.verdict import Check

#: Lowest frequency (Hz) at which the bed certainly flows.
FLOWING = 20.0

#: A velocity below this share of that at 20 Hz is none.
NONE = 0.02

#: Pairs of damping and shear damping (g) drawn as markers in Fig. 1b.
MARKERS = ((0, 50), (10, 10), (50, 100))

#: The system of half the size.
HALVED = {"beads": 100, "width": 10}


def along(
    evidence: Evidence, name: str, values: Sequence[float], **where: Any
) -> dict[float, Place]:
    """Return the places at some values of a parameter of the belt; all of them must be there."""
    return {value: evidence.at("belt", **{name: value}, **where) for value in values}


def replicated(line: dict[float, Place]) -> dict[float, Place]:
    """Return the places of which at least two beds are known."""
    return {value: place for value, place in line.items() if place.completed > 1}


def common_beds(places: Sequence[Place]) -> list[np.ndarray]:
    """Return per place which of its completed beds are known at all places, in the same order.

    Beds of places that start from different seeds are different ones.
    """
    if len({place["seed"] for place in places}) > 1:
        return [np.arange(0) for _ in places]
    numbers = [place.values("replicate_seed") for place in places]
    shared = reduce(np.intersect1d, numbers)
    return [np.flatnonzero(np.isin(each, shared)) for each in numbers]


def increases(line: dict[float, Place], what: str, sign: int = 1) -> list[Check]:
    """Return checks that the velocity rises (``sign`` -1: falls) from place to place of a line."""
    checks = []
    for (low, first), (high, second) in pairwise(line.items()):
        change = sign * (second.velocity - first.velocity)
        text = f"V {'gained' if sign > 0 else 'lost'} from {what} = {low:g} to {high:g}"
        checks.append(above(text, change, 0, (first, second), "m/s"))
    return checks


def ordered(
    evidence: Evidence, name: str, fastest_first: Sequence[float], lowest: float
) -> list[Check]:
    """Return checks that the velocity falls along values of a parameter, at every frequency.

    Frequencies count from ``lowest`` (Hz) on where all values have been run.
    """
    lines = [
        replicated(evidence.line("belt", "frequency", **{name: value})) for value in fastest_first
    ]
    shared = sorted(set.intersection(*map(set, lines)))
    checks = []
    for frequency in shared:
        if frequency >= lowest:
            places = {
                value: line[frequency] for value, line in zip(fastest_first, lines, strict=True)
            }
            checks += increases(places, f"{frequency:g} Hz, {name}", -1)
    return checks


def elasticity(line: dict[float, Place]) -> UFloat:
    """Return the slope of ln V against the logarithm of what varies along a line."""
    velocities = [place.velocity for place in line.values()]
    if not all(velocity.nominal_value > 0 for velocity in velocities):
        return ufloat(nan, 0)
    centred = np.log(np.array([*line]))
    centred -= centred.mean()
    rise = sum(x * umath.log(v) for x, v in zip(centred, velocities, strict=True))
    return rise / (centred**2).sum()
