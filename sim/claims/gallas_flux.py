"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, system."""

from collections.abc import Sequence

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import peak
from sim.claims.checks import above, reported, within
from sim.claims.evidence import Evidence
from sim.claims.gallas_onset import onset
from sim.claims.lines import FLOWING, HALVED, MARKERS, NONE, along, increases, ordered, replicated
from sim.claims.place import quotient
from sim.claims.verdict import Check, Untestable


def g1(evidence: Evidence) -> list[Check]:
    """No flow up to 15 Hz, then ever faster, and a straight line from 50 Hz on.

    No flow is within ±2 % of the velocity at 20 Hz, as no flow backwards is meant either.
    """
    rising = along(evidence, "frequency", (16, 18, 20, 25, 30, 40, 50, 60, 80, 100))
    slow = along(evidence, "frequency", (10, 15))
    reference = rising[20]
    checks = [
        within(
            f"V({frequency:g} Hz)/V(20 Hz)",
            quotient(place.velocity, reference.velocity),
            -NONE,
            NONE,
            (place, reference),
        )
        for frequency, place in slow.items()
    ]
    checks += increases(rising, "f (Hz)")
    straight = {frequency: place for frequency, place in rising.items() if frequency >= 50}
    velocities = [place.velocity for place in straight.values()]
    fit = determination(np.array([*straight]), velocities)
    return [*checks, above("R² of a line through V(f), 50 to 100 Hz", fit, 0.95, straight.values())]


def determination(abscissa: np.ndarray, values: Sequence[UFloat]) -> UFloat:
    """Return R² of the straight line through some values."""
    centred = abscissa - abscissa.mean()
    mean = sum(values) / len(values)
    deviations = [value - mean for value in values]
    product = sum(x * y for x, y in zip(centred, deviations, strict=True))
    return product**2 / ((centred**2).sum() * sum(y**2 for y in deviations))


def g2(evidence: Evidence) -> list[Check]:
    """Smaller angle, faster: differences of velocities at the same frequency exceed zero."""
    checks = ordered(evidence, "vibration_angle", (30, 45, 60), FLOWING)
    if not checks:
        raise Untestable("no frequency from 20 Hz on at 30, 45 and 60 degrees")
    return checks


def g8(evidence: Evidence) -> list[Check]:
    """Larger amplitude, faster from 25 Hz on; ratios at other damping are only reported."""
    checks = ordered(evidence, "amplitude", (1.5, 1, 0.5), 25)
    if not checks:
        raise Untestable("no frequency from 25 Hz on at amplitudes 0.5, 1 and 1.5")
    usual = replicated(evidence.line("belt", "frequency"))
    for damping, shear in MARKERS:
        line = evidence.line("belt", "frequency", damping=damping, shear_damping=shear)
        for frequency, place in replicated(line).items():
            if frequency >= 25 and frequency in usual:
                ratio = quotient(place.velocity, usual[frequency].velocity)
                what = f"V at (γ, γ_s) = ({damping}g, {shear}g) over (50g, 50g)"
                places = place, usual[frequency]
                checks.append(reported(f"{what}, {frequency:g} Hz", ratio, places))
    return checks


def g13(evidence: Evidence) -> list[Check]:
    """Velocity and largest density change by less than 10 % with the stiffness."""
    checks = []
    for frequency in (20, 50, 80):
        usual = evidence.at("belt", frequency=frequency)
        for stiffness in (500, 2000, 5000):
            place = evidence.at("belt", frequency=frequency, stiffness=stiffness)
            at = f"Y = {stiffness} against 1000, {frequency} Hz"
            change = quotient(place.velocity, usual.velocity) - 1
            checks.append(within(f"change of V, {at}", change, -0.1, 0.1, (place, usual)))
            densities = [each.measure(peak, "number_density") for each in (place, usual)]
            change = densities[0] / densities[1] - 1
            checks.append(within(f"change of ρ_max, {at}", change, -0.1, 0.1, (place, usual)))
    return checks


def g14(evidence: Evidence) -> list[Check]:
    """Half the beads on half the belt: same velocity within 10 %, same onset within 1 Hz."""
    halved = replicated(evidence.line("belt", "frequency", **HALVED))
    whole = replicated(evidence.line("belt", "frequency"))
    shared = [each for each in sorted(set(halved) & set(whole)) if each >= FLOWING]
    if not shared:
        raise Untestable("no frequency from 20 Hz on with 100 beads on a width of 10")
    checks = []
    for frequency in shared:
        places = halved[frequency], whole[frequency]
        change = quotient(places[0].velocity, places[1].velocity) - 1
        what = f"V of the halved system over the whole, less 1, {frequency:g} Hz"
        checks.append(within(what, change, -0.1, 0.1, places))
    small, usual = onset(evidence, **HALVED), onset(evidence)
    shift = small.frequency - usual.frequency
    both = (*small.places, *usual.places)
    checks.append(within("onset of the halved system less the whole", shift, -1, 1, both, "Hz"))
    return checks
