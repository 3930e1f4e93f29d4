"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, stiffness."""

from collections.abc import Sequence

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import peak
from sim.claims.checks import above, beside, reported, withheld, within
from sim.claims.evidence import Evidence
from sim.claims.lines import FLOWING, MARKERS, ordered, replicated, rising
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable

#: Frequencies (Hz) that the two grids need: 10 Hz apart, and after the jump.
COARSE, FINE = (20, 30, 40, 50, 60, 80, 100), (16, 18, 20, 25, 30)

#: Frequencies (Hz) at which beds creep, where the paper has none flow.
CREEP = (10, 14)

#: Stiffnesses (g⟨m⟩/⟨d⟩) larger than 500 that are compared with the usual one, and 500 itself.
STIFFNESSES, LIMIT = (700, 2000, 5000), 500


def g1(evidence: Evidence) -> list[Check]:
    """V rises over frequencies 10 Hz apart, and over all of them; it is a line from 50 Hz on.

    What is slower than 2 % of V(20 Hz) up to 14 Hz is reported: creep.
    """
    line = replicated(evidence.line("belt", "frequency"))
    if not set(line) >= {*COARSE, *FINE}:
        raise Untestable("no frequencies 16, 18, 20, 25, 30, 40, 50, 60, 80, 100 Hz with two beds")
    fine = {f: place for f, place in line.items() if f in (16, 18) or f >= FLOWING}
    coarse = {f: place for f, place in fine.items() if f % 10 == 0}
    straight = {f: place for f, place in coarse.items() if f >= 50}
    fit = determination(np.array([*straight]), [place.velocity for place in straight.values()])
    creep = [
        reported(
            f"creep, V({f:g} Hz)/V(20 Hz)",
            quotient(line[f].velocity, line[20].velocity),
            (line[f], line[20]),
        )
        for f in CREEP
        if f in line
    ]
    return [
        rising(coarse, "f (Hz)", monotone=True),
        rising(fine, "f (Hz)", monotone=True),
        above("R² of a line through V(f), 50 to 100 Hz", fit, 0.95, straight.values()),
        *creep,
    ]


def determination(abscissa: np.ndarray, values: Sequence[UFloat]) -> UFloat:
    """Return R² of the straight line through some values."""
    centred = abscissa - abscissa.mean()
    mean = sum(values) / len(values)
    deviations = [value - mean for value in values]
    product = sum(x * y for x, y in zip(centred, deviations, strict=True))
    return product**2 / ((centred**2).sum() * sum(y**2 for y in deviations))


def g2(evidence: Evidence) -> list[Check]:
    """Smaller angle, faster, at all frequencies from 20 Hz on."""
    check = ordered(evidence, "vibration_angle", (30, 45, 60), FLOWING)
    if check is None:
        raise Untestable("no frequency from 20 Hz on at 30, 45 and 60 degrees")
    return [check]


def g8(evidence: Evidence) -> list[Check]:
    """Larger amplitude, faster from 25 Hz on; ratios at other damping are only reported."""
    check = ordered(evidence, "amplitude", (1.5, 1, 0.5), 25)
    if check is None:
        raise Untestable("no frequency from 25 Hz on at amplitudes 0.5, 1 and 1.5")
    checks = [check]
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


def g13(evidence: Evidence, weak: float) -> list[Check]:
    """Velocity and largest density change by less than a share with the stiffness above 500.

    At 500 itself the change is reported.
    """
    checks = []
    for frequency in (20, 50, 80):
        # At the usual stiffness itself there is nothing to be kept.
        usual = evidence.without("stiffness_keeps").at("belt", frequency=frequency)
        for stiffness in (*STIFFNESSES, LIMIT):
            line = evidence.line("belt", "stiffness", frequency=frequency)
            at = f"Y = {stiffness} against 1000, {frequency} Hz"
            if stiffness in line:
                found = _changes(line[stiffness], usual, at, weak)
                checks += beside(found) if stiffness == LIMIT else found
            elif stiffness != LIMIT:
                lacking = within(f"change of V, {at}", float("nan"), -weak, weak, [usual])
                checks += withheld([lacking], f"Y = {stiffness} was not run")
    if not any(check.known and check.deciding for check in checks):
        raise Untestable("no stiffness above 500 but the usual one")
    return checks


def _changes(place: Place, usual: Place, at: str, weak: float) -> list[Check]:
    """Return the checks that velocity and largest density change by less than a share."""
    speed = quotient(place.velocity, usual.velocity) - 1
    densities = [each.measure(peak, "number_density") for each in (place, usual)]
    denser, pair = densities[0] / densities[1] - 1, (place, usual)
    return [
        within(f"change of V, {at}", speed, -weak, weak, pair),
        within(f"change of ρ_max, {at}", denser, -weak, weak, pair),
    ]
