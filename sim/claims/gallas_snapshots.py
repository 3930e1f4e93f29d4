"""Judges of Gallas' claims about snapshots: a block, a loose bed, a void at the belt, packing."""

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import level
from sim.claims.evidence import Evidence, Place
from sim.claims.lines import along
from sim.claims.verdict import Check, above, below

#: Share of the beads within A_z of the mean belt position below which there is a void.
EMPTY = 0.02


def g26(evidence: Evidence) -> list[Check]:
    """Fig. 5: a block with the belt at 10 Hz, loose at 40 Hz, a void at the belt at 100 Hz.

    Agitation is the rms velocity of the beads against the belt at the start of a cycle, relative to
    the amplitude of the belt's velocity: that of a block is small, that of beads in flight is not.
    """
    block = evidence.at("belt", frequency=10, vibration_angle=60)
    loose = evidence.at("belt", frequency=40, vibration_angle=30, damping=10, shear_damping=10)
    void = evidence.at("belt", frequency=100)
    lost = packing(block) - packing(loose)
    return [
        below("agitation against the belt, 10 Hz", agitation(block), 0.1, (block,)),
        above("agitation against the belt, 40 Hz", agitation(loose), 0.5, (loose,)),
        above("packing lost from 10 to 40 Hz", lost, 0, (block, loose)),
        below("occupancy at 100 Hz", void.value("base_occupancy"), EMPTY, (void,)),
    ]


def agitation(place: Place) -> UFloat:
    """Return the rms velocity of the beads against the belt over the belt's largest velocity."""
    climb = np.sin(np.radians(place["vibration_angle"]))
    amplitude = place["amplitude"] * place["diameter"] / climb
    return place.value("relative_agitation") / (2 * np.pi * place["frequency"] * amplitude)


def packing(place: Place) -> UFloat:
    """Return the mean packing between the levels of 5 and 95 % of the beads."""

    def measure(height: np.ndarray, number: np.ndarray, packing: np.ndarray) -> float:
        low, high = (level(height, number, share) for share in (0.05, 0.95))
        half = 0.5 * (height[1] - height[0])
        inside = np.clip(np.minimum(height + half, high) - np.maximum(height - half, low), 0, None)
        return float(np.average(packing, weights=inside))

    return place.measure(measure, "number_density", "packing_profile")


def g27(evidence: Evidence) -> list[Check]:
    """Hardly a bead is within A_z of the mean belt position at 80 and 100 Hz, unlike at 20 Hz."""
    usual, *fast = along(evidence, "frequency", (20, 80, 100)).values()
    checks = [
        below(
            f"occupancy at {place['frequency']:g} Hz",
            place.value("base_occupancy"),
            EMPTY,
            (place,),
        )
        for place in fast
    ]
    return [*checks, above("occupancy at 20 Hz", usual.value("base_occupancy"), 0.05, (usual,))]


def g28(evidence: Evidence) -> list[Check]:
    """At 100 Hz the bed is packed more densely with γ = 50g than with γ = g."""
    firm = evidence.at("belt", frequency=100)
    soft = evidence.at("belt", frequency=100, damping=1)
    gain = packing(firm) - packing(soft)
    return [above("packing at γ = 50g less that at γ = g", gain, 0, (firm, soft))]
