"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, stiffness."""

from collections.abc import Sequence

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import peak_density
from sim.claims.checks import above, remove_votes, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.lines import (
    MARKERS,
    MIN_FLOW_FREQUENCY,
    select_replicated,
    velocity_order,
    velocity_trend,
)
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable

#: Frequencies (Hz) of the two grids: 10 Hz apart, and just after the jump of V.
COARSE, FINE = (20, 30, 40, 50, 60, 80, 100), (16, 18, 20, 25, 30)

#: Frequencies (Hz) at which beds creep; in the paper no bed flows there.
CREEP = (10, 14)

#: Stiffnesses (g⟨m⟩/⟨d⟩) larger than 500 that are compared with the usual one, and 500 itself.
STIFFNESSES, LIMIT = (700, 2000, 5000), 500


def g1(evidence: Evidence) -> list[Check]:
    """V rises over frequencies 10 Hz apart and over all of them; V(f) is a line from 50 Hz on.

    V at 10 and 14 Hz over V(20 Hz), the creep, is reported.
    """
    line = select_replicated(evidence.line("belt", "frequency"))
    if not set(line) >= {*COARSE, *FINE}:
        raise Untestable("no frequencies 16, 18, 20, 25, 30, 40, 50, 60, 80, 100 Hz with two beds")
    fine = {f: place for f, place in line.items() if f in (16, 18) or f >= MIN_FLOW_FREQUENCY}
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
        velocity_trend(coarse, "f (Hz)", monotone=True),
        velocity_trend(fine, "f (Hz)", monotone=True),
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
    """V is larger at smaller angles, at all frequencies from 20 Hz on."""
    check = velocity_order(evidence, "vibration_angle", (30, 45, 60), MIN_FLOW_FREQUENCY)
    if check is None:
        raise Untestable("no frequency from 20 Hz on at 30, 45 and 60 degrees")
    return [check]


def g8(evidence: Evidence) -> list[Check]:
    """V is larger at larger amplitudes from 25 Hz on; ratios at other damping are reported."""
    check = velocity_order(evidence, "amplitude", (1.5, 1, 0.5), 25)
    if check is None:
        raise Untestable("no frequency from 25 Hz on at amplitudes 0.5, 1 and 1.5")
    checks = [check]
    usual = select_replicated(evidence.line("belt", "frequency"))
    for damping, shear in MARKERS:
        line = evidence.line("belt", "frequency", damping=damping, shear_damping=shear)
        for frequency, place in select_replicated(line).items():
            if frequency >= 25 and frequency in usual:
                ratio = quotient(place.velocity, usual[frequency].velocity)
                quantity = f"V at (γ, γ_s) = ({damping}g, {shear}g) over (50g, 50g)"
                places = place, usual[frequency]
                checks.append(reported(f"{quantity}, {frequency:g} Hz", ratio, places))
    return checks


def g13(evidence: Evidence, max_change: float) -> list[Check]:
    """Velocity and largest density change by less than ``max_change`` with the stiffness above 500.

    The change at 500 itself is reported.
    """
    checks = []
    for frequency in (20, 50, 80):
        # At the usual stiffness this parameter has no effect.
        usual = evidence.with_default("stiffness_keeps").at("belt", frequency=frequency)
        for stiffness in (*STIFFNESSES, LIMIT):
            line = evidence.line("belt", "stiffness", frequency=frequency)
            label = f"Y = {stiffness} against 1000, {frequency} Hz"
            if stiffness in line:
                changes = _changes(line[stiffness], usual, label, max_change)
                checks += remove_votes(changes) if stiffness == LIMIT else changes
            elif stiffness != LIMIT:
                missing = within(
                    f"change of V, {label}", float("nan"), -max_change, max_change, [usual]
                )
                checks += withhold([missing], f"Y = {stiffness} was not run")
    if not any(check.can_decide and check.has_vote for check in checks):
        raise Untestable("no stiffness above 500 but the usual one")
    return checks


def _changes(place: Place, usual: Place, label: str, max_change: float) -> list[Check]:
    """Return the checks that velocity and largest density change by less than ``max_change``."""
    speed = quotient(place.velocity, usual.velocity) - 1
    densities = [flow.measure(peak_density, "number_density") for flow in (place, usual)]
    density_change, pair = densities[0] / densities[1] - 1, (place, usual)
    return [
        within(f"change of V, {label}", speed, -max_change, max_change, pair),
        within(f"change of ρ_max, {label}", density_change, -max_change, max_change, pair),
    ]
