"""Helpers of the judges of the belt: places along a parameter, velocities, the shape of a bed.

Profiles are arrays (H,) over slices of equal height, from the belt upwards; heights are the centres
of the slices in m. ``number`` is the number density; shares of the beads count from below.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from math import nan
from typing import Any

import numpy as np
from uncertainties import UFloat, ufloat, umath

from sim.claims.checks import Numbers
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_order, trend
from sim.claims.place import Place, select_replicated
from sim.claims.verdict import LONGER_RUNS, SIGMAS, Check, Untestable

#: Lowest frequency (Hz) at which the bed certainly flows.
MIN_FLOW_FREQUENCY = 20.0

#: Pairs of damping and shear damping (g) drawn as markers in Fig. 1b.
MARKERS = ((0, 50), (10, 10), (50, 100))

#: The system of half the size.
HALF_SYSTEM = {"beads": 100, "width": 10}


def bed(evidence: Evidence, frequency: float, **where: Any) -> Place:
    """Return the place at a frequency (Hz) whose beds start at rest."""
    return evidence.at("belt", initial_velocity=0, frequency=frequency, **where)


def pair_label(damping: float, shear_damping: float) -> str:
    """Return the name of a curve by its damping and shear damping (g): ``(50g, 100g)``."""
    return f"({damping:g}g, {shear_damping:g}g)"


def complete_line(
    evidence: Evidence, name: str, values: Numbers, **where: Any
) -> dict[float, Place]:
    """Return the places at some values of a parameter of the belt.

    Raises `Untestable` if one is missing.
    """
    return {
        value: evidence.at("belt", initial_velocity=0, **{name: value}, **where) for value in values
    }


def common_beds(places: Sequence[Place]) -> list[np.ndarray]:
    """Return per place the indices of the completed beds that all places share, in one order.

    Places that start from different seeds share no beds.
    """
    if len({place["seed"] for place in places}) > 1:
        return [np.arange(0) for _ in places]
    numbers = [place.values("replicate_seed") for place in places]
    shared = reduce(np.intersect1d, numbers)
    return [np.flatnonzero(np.isin(bed_seeds, shared)) for bed_seeds in numbers]


def velocity_trend(
    line: Mapping[float, Place],
    parameter: str,
    *,
    rising: bool = True,
    margin: float | None = None,
    unit: str = "",
) -> Check:
    """Return the check that V rises (or falls) along a line; see `sim.claims.inference.trend`.

    With a margin the claim is about any two points of the line, whose values have a ``unit``.
    """
    groups = [place.values("velocity") for place in line.values()]
    values = ", ".join(f"{value:g}" for value in line)
    return trend(
        f"V over {parameter} = {values}",
        [groups],
        line.values(),
        rising=rising,
        margin=margin,
        labels=[f"{value:g} {unit}" for value in line],
        unit="m/s",
    )


def velocity_order(
    evidence: Evidence, name: str, fastest_first: Numbers, lowest: float, where: str
) -> list[Check]:
    """Return the check that V falls along values of a parameter, and how likely single beds do so.

    It uses the frequencies from ``lowest`` (Hz) on at which all values have been run. Raises
    `Untestable` if there are no such frequencies; ``where`` then says at which values.
    """
    lines = [
        select_replicated(evidence.line("belt", "frequency", **{name: value}))
        for value in fastest_first
    ]
    shared = [f for f in sorted(set.intersection(*map(set, lines))) if f >= lowest]
    if not shared:
        raise Untestable(f"no frequency from {lowest:g} Hz on at {where}")
    strata = [[line[frequency].values("velocity") for line in lines] for frequency in shared]
    places = [line[frequency] for frequency in shared for line in lines]
    values = ", ".join(f"{value:g}" for value in fastest_first)
    text = f"V over {name} {values}, {len(shared)} frequencies from {shared[0]:g} Hz on"
    likely = reported_order(f"V falls over {name} {values} at each", strata, rising=False)
    return [trend(text, strata, places, rising=False), likely]


def reason_drifting(place: Place, max_drift: float, cycles: int) -> str:
    """Return why V may not have converged: it may drift, relative to V, in so many cycles.

    Empty if the drift is surely below ``max_drift``.
    """
    averaged = place.window * place["frequency"]
    drift = place.velocity_change / place.velocity.nominal_value * cycles / averaged
    largest = abs(drift.nominal_value) + SIGMAS * drift.std_dev
    if largest < max_drift:
        return ""
    return (
        f"V changes by {abs(drift.nominal_value):.1%}, or up to {largest:.1%}, in {cycles} "
        f"cycles at γ_s = {place['shear_damping']:g}g: {LONGER_RUNS} or more beds"
    )


def elasticity(line: Mapping[float, Place]) -> UFloat:
    """Return the slope of ln V against the logarithm of the parameter of a line."""
    velocities = [place.velocity for place in line.values()]
    if not all(velocity.nominal_value > 0 for velocity in velocities):
        return ufloat(nan, 0)
    centred = np.log(np.array([*line]))
    centred -= centred.mean()
    rise = sum(x * umath.log(v) for x, v in zip(centred, velocities, strict=True))
    return rise / (centred**2).sum()


#: Largest share of the beads of a mean that may be in slices without a value.
MAX_WITHOUT_VALUE = 0.01


def beads_between(number: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return per slice the share of all beads that lies between two cumulative shares."""
    below = np.concatenate([[0.0], np.cumsum(number)]) / number.sum()
    return np.clip(np.minimum(below[1:], high) - np.maximum(below[:-1], low), 0.0, None)


def mean_between(values: np.ndarray, number: np.ndarray, low: float, high: float) -> float:
    """Return the mean of a profile over the beads between two cumulative shares.

    A slice that few beads ever entered may have no value: one sample has no variance, for example.
    Such a slice is left out. The result is not-a-number where more than `MAX_WITHOUT_VALUE` of
    these beads are in such slices.
    """
    weight = beads_between(number, low, high)
    has_value = (weight > 0) & np.isfinite(values)
    if weight[has_value].sum() < (1 - MAX_WITHOUT_VALUE) * weight.sum():
        return nan
    return float(np.average(values[has_value], weights=weight[has_value]))


def peak_density(height: np.ndarray, number: np.ndarray) -> float:
    """Return the largest number density (m⁻²)."""
    return float(number.max())


def half_height(height: np.ndarray, number: np.ndarray) -> float:
    """Return the height (m) at which the density falls to half of its mean over the bed.

    The mean over the bed is taken between a fifth and four fifths of the beads.
    """
    half = 0.5 * mean_between(number, number, 0.2, 0.8)
    last = int(np.flatnonzero(number >= half)[-1])
    if last == height.size - 1:
        return float(height[-1])
    return float(np.interp(-half, -number[last : last + 2], height[last : last + 2]))
