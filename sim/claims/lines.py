"""What judges of the belt share: places along a parameter and how their velocities compare."""

from collections.abc import Mapping, Sequence
from functools import reduce
from math import nan
from typing import Any

import numpy as np
from uncertainties import UFloat, ufloat, umath

from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.place import Place
from sim.claims.verdict import LONGER, SIGMAS, Check

#: Lowest frequency (Hz) at which the bed certainly flows.
FLOWING = 20.0

#: A velocity below this share of that at 20 Hz is none.
NONE = 0.02

#: Pairs of damping and shear damping (g) drawn as markers in Fig. 1b.
MARKERS = ((0, 50), (10, 10), (50, 100))

#: The system of half the size.
HALVED = {"beads": 100, "width": 10}

#: Cycles over which a drift is told, and the largest one, relative to V, of a converged flow.
CYCLES, DRIFTING = 100, 0.02


def along(
    evidence: Evidence, name: str, values: Sequence[float], **where: Any
) -> dict[float, Place]:
    """Return the places at some values of a parameter of the belt; all of them must be there."""
    return {value: evidence.at("belt", **{name: value}, **where) for value in values}


def replicated(line: Mapping[float, Place]) -> dict[float, Place]:
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


def rising(
    line: Mapping[float, Place], what: str, *, rising: bool = True, monotone: bool = False
) -> Check:
    """Return the check that V rises (or falls) along a line; see `sim.claims.inference.trend`."""
    groups = [place.values("velocity") for place in line.values()]
    over = ", ".join(f"{value:g}" for value in line)
    text = f"V over {what} = {over}"
    return trend(text, [groups], line.values(), rising=rising, monotone=monotone)


def ordered(
    evidence: Evidence, name: str, fastest_first: Sequence[float], lowest: float
) -> Check | None:
    """Return the check that V falls along values of a parameter.

    Frequencies count from ``lowest`` (Hz) on where all values have been run; none if there are
    none.
    """
    lines = [
        replicated(evidence.line("belt", "frequency", **{name: value})) for value in fastest_first
    ]
    shared = [each for each in sorted(set.intersection(*map(set, lines))) if each >= lowest]
    if not shared:
        return None
    strata = [[line[frequency].values("velocity") for line in lines] for frequency in shared]
    places = [line[frequency] for frequency in shared for line in lines]
    values = ", ".join(f"{value:g}" for value in fastest_first)
    text = f"V over {name} {values}, {len(shared)} frequencies from {shared[0]:g} Hz on"
    return trend(text, strata, places, rising=False)


def drifting(place: Place) -> str:
    """Return why a velocity is not known to have converged: it may drift by 2 % in 100 cycles."""
    cycles = place.window * place["frequency"]
    drift = place.change / place.velocity.nominal_value * CYCLES / cycles
    most = abs(drift.nominal_value) + SIGMAS * drift.std_dev
    if most < DRIFTING:
        return ""
    return (
        f"V changes by {abs(drift.nominal_value):.1%}, or up to {most:.1%}, in {CYCLES} cycles at "
        f"γ_s = {place['shear_damping']:g}g: {LONGER} or more beds"
    )


def elasticity(line: Mapping[float, Place]) -> UFloat:
    """Return the slope of ln V against the logarithm of what varies along a line."""
    velocities = [place.velocity for place in line.values()]
    if not all(velocity.nominal_value > 0 for velocity in velocities):
        return ufloat(nan, 0)
    centred = np.log(np.array([*line]))
    centred -= centred.mean()
    rise = sum(x * umath.log(v) for x, v in zip(centred, velocities, strict=True))
    return rise / (centred**2).sum()
