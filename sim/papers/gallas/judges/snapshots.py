"""Judges of Gallas' claims about snapshots: a block, a loose bed, a void at the belt, packing."""

from dataclasses import replace
from math import nan, pi, radians, sin, sqrt

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import Numbers, Pair, above, below, judge_parts, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_share
from sim.claims.place import Place
from sim.claims.verdict import Check, Untestable
from sim.measures.layers import level
from sim.papers.gallas.judges.lines import bed, complete_line, mean_between

#: Occupancy of the belt's reach: in the mean over the cycle, and at its beginning as in Fig. 5.
TIME_MEAN, PHASE_0 = "base_occupancy", "base_occupancy_at_phase_0"
_OCCUPANCIES = {TIME_MEAN: "time mean", PHASE_0: "phase 0"}

#: Cumulative shares of the beads between which a bed is packed, where a claim gives none.
PACKED = (0.05, 0.95)


def g26(
    evidence: Evidence,
    *,
    max_occupancy: float,
    block: float,
    loose: float,
    void: float,
    max_agitation: float,
    max_lift: float,
) -> list[Check]:
    """Fig. 5: a block with the belt (a), a loose bed (b), a void (c), each at a frequency (Hz).

    Along the belt the block lags behind, as shear friction is viscous.
    """
    return judge_parts(
        a=lambda: _block(evidence, block, max_agitation, max_lift),
        b=lambda: _loose(evidence, block, loose, max_agitation),
        c=lambda: check_void(bed(evidence, void), PHASE_0, max_occupancy),
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


def check_void(place: Place, name: str, max_occupancy: float) -> list[Check]:
    """Return the check that few beads are within the reach of the belt, at a phase of the cycle."""
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

    def measure(height: np.ndarray, number: np.ndarray, packing: np.ndarray) -> float:
        low, high = (level(height, number, share) for share in levels)
        half = 0.5 * (height[1] - height[0])
        inside = np.clip(np.minimum(height + half, high) - np.maximum(height - half, low), 0, None)
        return float(np.average(packing, weights=inside))

    return place.measure(measure, "number_density", "packing_profile")


def g27(evidence: Evidence, *, max_occupancy: float, frequencies: Numbers) -> list[Check]:
    """Hardly a bead is within A_z of the mean belt position at high frequencies (Hz).

    Parts are the time mean (a) and the beginning of the cycle (b). The share at 20 Hz is reported.
    """
    usual, *fast = complete_line(evidence, "frequency", (20, *frequencies)).values()
    checks = [
        replace(check, part=part)
        for part, name in (("a", TIME_MEAN), ("b", PHASE_0))
        for place in fast
        for check in check_void(place, name, max_occupancy)
    ]
    share = usual.value(TIME_MEAN)
    return [*checks, reported("occupancy at 20 Hz, time mean", share, (usual,))]


def g28(evidence: Evidence, *, levels: Pair, frequency: float, firm: float) -> list[Check]:
    """The bed is packed more densely between two levels with a firm γ (g) than with γ = g."""
    places = [bed(evidence, frequency, damping=damping) for damping in (firm, 1)]
    dense, light = (packing(place, levels) for place in places)
    check = above(f"packing at γ = {firm}g less that at γ = g", dense - light, 0, places)
    lost = [
        reported_share(
            f"beds lost, γ = {place['damping']:g}g",
            place.replicates - place.completed,
            place.replicates,
            [place],
        )
        for place in places
    ]
    return [check, *lost]
