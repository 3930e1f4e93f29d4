"""Judges of Gallas' claims about snapshots: a block, a loose bed, a void at the belt, packing."""

from collections.abc import Callable
from functools import cache
from math import nan, pi, radians, sin, sqrt

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import (
    Numbers,
    Pair,
    above,
    below,
    judge_parts,
    remove_votes,
    reported,
    withhold,
    within,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_share, trend
from sim.claims.place import Place, quotient, replicate_mean
from sim.claims.verdict import Check, Untestable
from sim.measures.layers import level
from sim.papers.gallas.judges.lines import bed, complete_line, mean_between

#: Occupancy of the belt's reach: in the mean over the cycle, and at its beginning as in Fig. 5.
TIME_MEAN, PHASE_0 = "base_occupancy", "base_occupancy_at_phase_0"
_OCCUPANCIES = {TIME_MEAN: "time mean", PHASE_0: "phase 0"}

#: Cumulative shares of the beads between which a bed is packed, where a claim gives none.
PACKED = (0.05, 0.95)

#: Profiles that give a packing between two levels.
PACKING = ("number_density", "packing_profile")


def g26(
    evidence: Evidence,
    *,
    max_occupancy: float,
    block: float,
    loose: float,
    void: float,
    max_agitation: float,
    max_lift: float,
    at_phase_0: bool,
) -> list[Check]:
    """Fig. 5: a block with the belt (a), a loose bed (b), a void (c), each at a frequency (Hz).

    Along the belt the block lags behind, as shear friction is viscous. The void is one at the
    beginning of the cycle, or in the time mean.
    """
    return judge_parts(
        a=lambda: _block(evidence, block, max_agitation, max_lift),
        b=lambda: _loose(evidence, block, loose, max_agitation),
        c=lambda: check_void(bed(evidence, void), at_phase_0, max_occupancy),
    )


def _block(
    evidence: Evidence, frequency: float, max_agitation: float, max_lift: float
) -> list[Check]:
    block = bed(evidence, frequency, vibration_angle=60)
    lift = block.value("path_vertical") / (block["amplitude"] * block["diameter"] / sqrt(2))
    together = f"rms velocity about the mean, {frequency} Hz"
    lifted = f"vertical rms of the paths over the belt's, {frequency} Hz"
    return [
        below(together, agitation(block), max_agitation, (block,)),
        within(lifted, lift, 1 - max_lift, 1 + max_lift, (block,)),
    ]


def _loose(
    evidence: Evidence, frequency: float, faster: float, max_agitation: float
) -> list[Check]:
    block = bed(evidence, frequency, vibration_angle=60)
    loose = bed(evidence, faster, vibration_angle=30, damping=10, shear_damping=10)
    packing_loss = packing(block) - packing(loose)
    apart = f"rms velocity about the mean, {faster} Hz"
    return [
        above(apart, agitation(loose), max_agitation, (loose,)),
        above(f"packing lost from {frequency} to {faster} Hz", packing_loss, 0, (block, loose)),
    ]


def check_void(place: Place, at_phase_0: bool, max_occupancy: float) -> list[Check]:
    """Return the check that few beads are within reach of the belt, at phase 0 or on average."""
    name = PHASE_0 if at_phase_0 else TIME_MEAN
    quantity = f"occupancy at {place['frequency']:g} Hz, {_OCCUPANCIES[name]}"
    try:
        return [below(quantity, place.value(name), max_occupancy, (place,))]
    except Untestable as error:
        return withhold([below(quantity, nan, max_occupancy, (place,))], str(error))


def agitation(place: Place) -> UFloat:
    """Return the rms velocity of the beads about their mean over the belt's largest velocity."""
    climb = sin(radians(place["vibration_angle"]))
    largest = 2 * pi * place["frequency"] * place["amplitude"] * place["diameter"] / climb

    def measure(_: np.ndarray, temperature: np.ndarray, number: np.ndarray) -> float:
        # The granular temperature is the mean of two directions.
        return sqrt(2 * mean_between(temperature, number, 0, 1)) / largest

    return place.measure(measure, "granular_temperature_profile", "number_density")


def packing(place: Place, levels: Pair = PACKED) -> UFloat:
    """Return the mean packing between the levels of two cumulative shares of the beads."""
    return place.measure(packing_between(*levels), *PACKING)


@cache
def packing_between(*levels: float) -> Callable[[np.ndarray, np.ndarray, np.ndarray], float]:
    """Return a function of height, number density and packing: the mean between two levels."""

    def measure(height: np.ndarray, number: np.ndarray, packing: np.ndarray) -> float:
        low, high = (level(height, number, share) for share in levels)
        half = 0.5 * (height[1] - height[0])
        inside = np.clip(np.minimum(height + half, high) - np.maximum(height - half, low), 0, None)
        return float(np.average(packing, weights=inside))

    return measure


def g27(
    evidence: Evidence, *, max_occupancy: float, frequencies: Numbers, at_phase_0: bool
) -> list[Check]:
    """Hardly a bead is within A_z of the mean belt position at high frequencies (Hz).

    That is at the beginning of the cycle, or in the time mean; the other one, and the share at
    20 Hz, are shown.
    """
    usual, *fast = complete_line(evidence, "frequency", (20, *frequencies)).values()
    voting, shown = (
        [check for place in fast for check in check_void(place, phase_0, max_occupancy)]
        for phase_0 in (at_phase_0, not at_phase_0)
    )
    share = usual.value(TIME_MEAN)
    quantity = "occupancy at 20 Hz, time mean"
    return [*voting, *remove_votes(shown), reported(quantity, share, (usual,))]


def g28(
    evidence: Evidence, *, levels: Pair, frequency: float, firm: float, margin: float
) -> list[Check]:
    """The bed is packed more densely between two levels with a firm γ (g) than with γ = g."""
    places = [bed(evidence, frequency, damping=damping) for damping in (1, firm)]
    light, dense = (
        place.measure_replicates(packing_between(*levels), *PACKING) for place in places
    )
    quantity = f"packing at γ = {firm}g over that at γ = g"
    check = trend(quantity, [[light, dense]], places, margin=margin, labels=["g", f"{firm}g"])
    ratio = quotient(replicate_mean(dense), replicate_mean(light))
    lost = [
        reported_share(
            f"beds lost, γ = {place['damping']:g}g",
            place.replicates - place.completed,
            place.replicates,
            [place],
        )
        for place in places
    ]
    return [check, reported(quantity, ratio, places), *lost]


def g40(evidence: Evidence, *, levels: Pair, frequencies: Numbers, margin: float) -> list[Check]:
    """The mean packing between two levels falls over the frequencies (Hz).

    A rise between any two that is surely larger than the share ``margin`` refutes it.
    """
    line = complete_line(evidence, "frequency", frequencies)
    groups = [
        place.measure_replicates(packing_between(*levels), *PACKING) for place in line.values()
    ]
    values = ", ".join(f"{f:g}" for f in line)
    check = trend(
        f"packing over f (Hz) = {values}",
        [groups],
        line.values(),
        rising=False,
        margin=margin,
        labels=[f"{f:g} Hz" for f in line],
    )
    each = [
        reported(f"packing, {f:g} Hz", packing(place, levels), [place]) for f, place in line.items()
    ]
    return [check, *each]
