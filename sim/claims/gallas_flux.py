"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, damping."""

from sim.claims.evidence import Evidence
from sim.claims.verdict import Check, Untestable, above

#: Lowest frequency (Hz) at which the bed certainly flows.
FLOWING = 20.0


def g2(evidence: Evidence) -> list[Check]:
    """Smaller angle, faster: differences of velocities at the same frequency exceed zero."""
    lines = [evidence.line("belt", "frequency", vibration_angle=angle) for angle in (30, 45, 60)]
    checks = []
    for flat, steep, names in ((*lines[:2], "π/6 over π/4"), (*lines[1:], "π/4 over π/3")):
        for frequency in sorted(set(flat) & set(steep)):
            if frequency >= FLOWING:
                places = flat[frequency], steep[frequency]
                gain = places[0].velocity - places[1].velocity
                what = f"V of {names} at {frequency:g} Hz"
                checks.append(above(what, gain, 0, places, "m/s"))
    if not checks:
        raise Untestable("no frequency from 20 Hz on at all three angles")
    return checks
