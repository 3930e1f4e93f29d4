"""Judges of Gallas' claims about snapshots: a block, a loose bed, a void at the belt, packing."""

from math import nan, pi, radians, sin, sqrt

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import mean_between
from sim.claims.checks import above, below, judge_parts, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.lines import complete_line
from sim.claims.place import Place
from sim.claims.verdict import Check, Untestable
from sim.measures.layers import level

#: Largest rms velocity about the mean of all beads, over the belt's, of a block.
MAX_BLOCK_AGITATION = 0.1


def g26(evidence: Evidence, max_occupancy: float) -> list[Check]:
    """Fig. 5: a block with the belt at 10 Hz (a), loose at 40 Hz (b), a void at 100 Hz (c).

    The beads of a block move together, and up and down as the belt does. Along the belt the block
    lags behind, as shear friction is viscous. The beads of a loose bed do not move together, which
    tells it from a block in flight. Velocities are relative to the amplitude of the belt's.
    """
    return judge_parts(
        a=lambda: _block(evidence),
        b=lambda: _loose(evidence),
        c=lambda: check_void(evidence.at("belt", frequency=100), max_occupancy),
    )


def _block(evidence: Evidence) -> list[Check]:
    block = evidence.at("belt", frequency=10, vibration_angle=60)
    lift = block.value("path_vertical") / (block["amplitude"] * block["diameter"] / sqrt(2))
    return [
        below(
            "rms velocity about the mean, 10 Hz", agitation(block), MAX_BLOCK_AGITATION, (block,)
        ),
        within("vertical rms of the paths over the belt's, 10 Hz", lift, 0.9, 1.1, (block,)),
    ]


def _loose(evidence: Evidence) -> list[Check]:
    block = evidence.at("belt", frequency=10, vibration_angle=60)
    loose = evidence.at("belt", frequency=40, vibration_angle=30, damping=10, shear_damping=10)
    packing_loss = packing(block) - packing(loose)
    return [
        above(
            "rms velocity about the mean, 40 Hz", agitation(loose), MAX_BLOCK_AGITATION, (loose,)
        ),
        above("packing lost from 10 to 40 Hz", packing_loss, 0, (block, loose)),
    ]


def check_void(place: Place, max_occupancy: float) -> list[Check]:
    """Return the checks that few beads are within the reach of the belt: a void.

    It is tested at the beginning of the cycle, as in the paper's pictures, and in the time mean.
    """
    checks = []
    for name, phase_label in (
        ("base_occupancy_at_phase_0", "phase 0"),
        ("base_occupancy", "time mean"),
    ):
        quantity = f"occupancy at {place['frequency']:g} Hz, {phase_label}"
        try:
            checks.append(below(quantity, place.value(name), max_occupancy, (place,)))
        except Untestable as error:
            checks += withhold([below(quantity, nan, max_occupancy, (place,))], str(error))
    return checks


def belt_speed(place: Place) -> float:
    """Return the amplitude of the belt's velocity along its line (m/s)."""
    climb = sin(radians(place["vibration_angle"]))
    return 2 * pi * place["frequency"] * place["amplitude"] * place["diameter"] / climb


def agitation(place: Place) -> UFloat:
    """Return the rms velocity of the beads about their mean over the belt's largest velocity."""
    names = "granular_temperature_profile", "number_density"

    def measure(_: np.ndarray, temperature: np.ndarray, number: np.ndarray) -> float:
        # The granular temperature is the mean of two directions.
        return sqrt(2 * mean_between(temperature, number, 0, 1)) / belt_speed(place)

    return place.measure(measure, *names)


def packing(place: Place) -> UFloat:
    """Return the mean packing between the levels of 5 and 95 % of the beads."""

    def measure(height: np.ndarray, number: np.ndarray, packing: np.ndarray) -> float:
        low, high = (level(height, number, share) for share in (0.05, 0.95))
        half = 0.5 * (height[1] - height[0])
        inside = np.clip(np.minimum(height + half, high) - np.maximum(height - half, low), 0, None)
        return float(np.average(packing, weights=inside))

    return place.measure(measure, "number_density", "packing_profile")


def g27(evidence: Evidence, max_occupancy: float) -> list[Check]:
    """Hardly a bead is within A_z of the mean belt position at 80 and 100 Hz.

    The share at 20 Hz is reported.
    """
    usual, *fast = complete_line(evidence, "frequency", (20, 80, 100)).values()
    checks = [check for place in fast for check in check_void(place, max_occupancy)]
    share = usual.value("base_occupancy")
    return [*checks, reported("occupancy at 20 Hz, time mean", share, (usual,))]


def g28(evidence: Evidence) -> list[Check]:
    """At 100 Hz the bed is packed more densely with γ = 50g than with γ = g."""
    firm = evidence.at("belt", frequency=100)
    soft = evidence.at("belt", frequency=100, damping=1)
    gain = packing(firm) - packing(soft)
    return [above("packing at γ = 50g less that at γ = g", gain, 0, (firm, soft))]
