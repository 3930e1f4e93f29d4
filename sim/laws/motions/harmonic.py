"""The harmonic motion, of a plane also at two frequencies: `sim.engine.boundary.motion`."""

from math import radians
from typing import Any, NamedTuple

from sim.parameters.laws import motion


def make(p: Any) -> NamedTuple:
    """Return the motion of a point; a belt has one frequency, and the phase is its own."""
    from sim.engine.boundary.motion import Harmonic

    if p.system == "belt":
        return Harmonic()
    return Harmonic(
        float(p.overtone),
        (radians(p.phase_along), 0.0),
        (p.overtone_along * p.diameter, p.overtone_amplitude * p.diameter),
        radians(p.overtone_phase),
    )


motion(
    "harmonic",
    description="sine and cosine of one frequency, of a plane also of a second one",
    make=make,
    state=None,
    owns=("phase_along", "overtone", "overtone_amplitude", "overtone_along", "overtone_phase"),
)
