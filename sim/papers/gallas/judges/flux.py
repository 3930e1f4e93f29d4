"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, stiffness."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import copysign

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import (
    Numbers,
    Pair,
    above,
    judge_parts,
    remove_votes,
    reported,
    withhold,
    within,
)
from sim.claims.claim import fill
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_likelihood, single_rise, trend
from sim.claims.place import Place, quotient, select_replicated
from sim.claims.verdict import NOT_REPRODUCED, Check, Untestable
from sim.papers.gallas.judges.lines import MARKERS, bed, pair_label, peak_density, velocity_order

#: Frequencies (Hz) that are needed at 45°, those just after the jump of V included.
NEEDED = (16, 18, 20, 25, 30, 40, 50, 60, 80, 100)

#: The curve with most frequencies.
USUAL_CURVE = "45°"

#: Curves of Figs. 1a (the first three) and 1b: label, parameters, and the frequencies (Hz) of beds
#: that flow.
_FLOWING = (20, 25, 30, 40, 50, 60, 80, 100)
CURVES: tuple[tuple[str, dict[str, float], tuple[int, ...]], ...] = (
    ("30°", {"vibration_angle": 30}, _FLOWING),
    (USUAL_CURVE, {}, _FLOWING),
    ("60°", {"vibration_angle": 60}, _FLOWING),
    ("A_z = 1.5⟨d⟩", {"amplitude": 1.5}, (20, 25, 30, 40, 60, 80, 100)),
    ("A_z = 0.5⟨d⟩", {"amplitude": 0.5}, (25, 30, 40, 60, 80, 100)),
)

#: The pairs of damping of Fig. 1b, by label.
DAMPED = {
    pair_label(*pair): dict(zip(("damping", "shear_damping"), pair, strict=True))
    for pair in MARKERS
}

#: Fewest points that tell a straight line from another.
FEWEST = 3

#: Frequencies (Hz) at which beds creep; in the paper no bed flows there.
CREEP = (10, 14)

#: Stiffness (g⟨m⟩/⟨d⟩) above which it hardly matters; the change there is reported.
LIMIT = 500


def g1(
    evidence: Evidence,
    *,
    lowest: float,
    lowest_small: float,
    straight: Pair,
    min_r2: float,
    margin: float,
) -> list[Check]:
    """V rises over f along every curve of Figs. 1a and 1b (a), in the end on a line at 45° (b).

    Frequencies are those from ``lowest`` (Hz) on, at the small amplitude from ``lowest_small`` on.
    Lines through other curves are reported, and the creep: V at 10 and 14 Hz over V(20 Hz).
    """
    usual = select_replicated(evidence.line("belt", "frequency"))
    if not set(usual) >= {*NEEDED}:
        frequencies = ", ".join(map(str, NEEDED))
        raise Untestable(f"no frequencies {frequencies} Hz with two beds")
    lines = {}
    for label, setting in ({label: setting for label, setting, _ in CURVES} | DAMPED).items():
        first = lowest_small if setting.get("amplitude", 1) < 1 else lowest
        line = select_replicated(evidence.line("belt", "frequency", **setting))
        lines[label] = {f: place for f, place in line.items() if f >= first}
    creep = [
        reported(
            f"creep, V({f:g} Hz)/V(20 Hz)",
            quotient(usual[f].velocity, usual[20].velocity),
            (usual[f], usual[20]),
        )
        for f in CREEP
        if f in usual
    ]
    parts = judge_parts(
        a=lambda: _rise(lines, margin), b=lambda: _straightness(lines, straight, min_r2)
    )
    return [*parts, *creep, *_single_rises(evidence)]


def _rise(lines: Mapping[str, Mapping[float, Place]], margin: float) -> list[Check]:
    """Return the check that V rises along all curves; frequencies of one curve are compared.

    One reversal refutes it, whatever other curves do. That there is none takes all of them.
    """
    curves = {label: line for label, line in lines.items() if len(line) > 1}
    check = trend(
        "V over f, along each curve",
        [[place.values("velocity") for place in line.values()] for line in curves.values()],
        [place for line in curves.values() for place in line.values()],
        margin=margin,
        labels=[f"{label}, {f:g} Hz" for label, line in curves.items() for f in line],
        unit="m/s",
    )
    missing = ", ".join(label for label in lines if label not in curves)
    is_open = missing and check.verdict != NOT_REPRODUCED
    return withhold([check], f"not run: {missing}" if is_open else "")


def _straightness(
    lines: Mapping[str, Mapping[float, Place]], straight: Pair, min_r2: float
) -> list[Check]:
    """Return the checks that V lies on a rising line; that at 45° votes."""
    checks = []
    for label, line in lines.items():
        fast = {f: place for f, place in line.items() if straight[0] <= f <= straight[1]}
        if len(fast) >= FEWEST:
            fit = determination(np.array([*fast]), [place.velocity for place in fast.values()])
            quantity = "R² of a line through V(f), {} to {} Hz, {}".format(*straight, label)
            check = above(quantity, fit, min_r2, fast.values())
            checks.append(replace(check, votes=label == USUAL_CURVE))
    return checks


def _single_rises(evidence: Evidence) -> list[Check]:
    """Report how likely one bed per frequency rises throughout, for each angle and amplitude.

    The paper tells of no second bed, so this is how likely it sees what it says under a reading.
    The fall is at 25 Hz, where the paper may have no point.
    """
    lines = {}
    for label, setting, frequencies in CURVES:
        line = select_replicated(evidence.line("belt", "frequency", **setting))
        if set(line) >= set(frequencies):
            lines[label] = {f: line[f].values("velocity") for f in frequencies}
    checks = []
    for which, left_out in (("", None), (" but 25 Hz", 25)):
        rises = {
            label: single_rise([values for f, values in line.items() if f != left_out])
            for label, line in lines.items()
        }
        quantity = f"V rises over f{which}"
        checks += [
            reported_likelihood(f"{quantity}, {label}", [rise]) for label, rise in rises.items()
        ]
        angles = [rises[label] for label, setting, _ in CURVES[:3] if label in rises]
        if len(angles) == 3:
            checks.append(reported_likelihood(f"{quantity}, all of Fig. 1a", angles))
        if len(rises) == len(CURVES):
            everything = rises.values()
            checks.append(reported_likelihood(f"{quantity}, all angles and amplitudes", everything))
    return checks


def determination(abscissa: np.ndarray, values: Sequence[UFloat]) -> UFloat:
    """Return R² of the straight line through some values, negative where it falls."""
    centred = abscissa - abscissa.mean()
    mean = sum(values) / len(values)
    deviations = [value - mean for value in values]
    product = sum(x * y for x, y in zip(centred, deviations, strict=True))
    share = product**2 / ((centred**2).sum() * sum(y**2 for y in deviations))
    return copysign(1, product.nominal_value) * share


def g2(evidence: Evidence, *, angles: Numbers, lowest: float) -> list[Check]:
    """V falls over the angles, at all frequencies from ``lowest`` (Hz) on."""
    where = fill("{angles:and} degrees", {"angles": angles})
    return velocity_order(evidence, "vibration_angle", angles, lowest, where)


def g8(evidence: Evidence, *, amplitudes: Numbers, lowest: float) -> list[Check]:
    """V falls over the amplitudes from ``lowest`` (Hz) on; ratios at other damping are reported."""
    where = fill("amplitudes {sizes:and}", {"sizes": sorted(amplitudes)})
    checks = velocity_order(evidence, "amplitude", amplitudes, lowest, where)
    usual = select_replicated(evidence.line("belt", "frequency"))
    for damping, shear in MARKERS:
        line = evidence.line("belt", "frequency", damping=damping, shear_damping=shear)
        for frequency, place in select_replicated(line).items():
            if frequency >= lowest and frequency in usual:
                ratio = quotient(place.velocity, usual[frequency].velocity)
                quantity = f"V at (γ, γ_s) = {pair_label(damping, shear)} over (50g, 50g)"
                places = place, usual[frequency]
                checks.append(reported(f"{quantity}, {frequency:g} Hz", ratio, places))
    return checks


def g13(
    evidence: Evidence,
    *,
    max_change: float,
    stiffnesses: Numbers,
    usual: float,
    frequencies: Numbers,
) -> list[Check]:
    """Velocity and largest density change by less than ``max_change`` from the usual stiffness.

    The change at 500, which is no larger than 500, is reported.
    """
    checks = []
    for frequency in frequencies:
        # At the usual stiffness this parameter has no effect.
        alike = evidence.with_default("stiffness_keeps")
        place = bed(alike, frequency, stiffness=usual)
        for stiffness in (*stiffnesses, LIMIT):
            line = evidence.line("belt", "stiffness", frequency=frequency)
            label = f"Y = {stiffness} against {usual}, {frequency} Hz"
            if stiffness in line:
                changes = _changes(line[stiffness], place, label, max_change)
                checks += remove_votes(changes) if stiffness == LIMIT else changes
            elif stiffness != LIMIT:
                missing = within(
                    f"change of V, {label}", float("nan"), -max_change, max_change, [place]
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
