"""Judges of Gallas' claims about the mean velocity: frequency, angle, amplitude, stiffness."""

from collections.abc import Sequence

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import Numbers, Pair, above, remove_votes, reported, withhold, within
from sim.claims.claim import fill
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_likelihood, single_rise
from sim.claims.place import Place, quotient, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.papers.gallas.judges.lines import (
    MARKERS,
    MIN_FLOW_FREQUENCY,
    bed,
    pair_label,
    peak_density,
    velocity_order,
    velocity_trend,
)

#: Frequencies (Hz) that are needed: those of the coarse grid, and those just after the jump of V.
COARSE, FINE = (20, 30, 40, 50, 60, 80, 100), (16, 18, 20, 25, 30)

#: Step (Hz) of the coarse grid.
COARSE_STEP = 10

#: Curves of Figs. 1a (the first three) and 1b: label, parameters, and the frequencies (Hz) of beds
#: that flow.
_FLOWING = (20, 25, 30, 40, 50, 60, 80, 100)
CURVES: tuple[tuple[str, dict[str, float], tuple[int, ...]], ...] = (
    ("30°", {"vibration_angle": 30}, _FLOWING),
    ("45°", {}, _FLOWING),
    ("60°", {"vibration_angle": 60}, _FLOWING),
    ("A_z = 1.5⟨d⟩", {"amplitude": 1.5}, (20, 25, 30, 40, 60, 80, 100)),
    ("A_z = 0.5⟨d⟩", {"amplitude": 0.5}, (25, 30, 40, 60, 80, 100)),
)

#: Frequencies (Hz) at which beds creep; in the paper no bed flows there.
CREEP = (10, 14)

#: Stiffness (g⟨m⟩/⟨d⟩) above which it hardly matters; the change there is reported.
LIMIT = 500


def g1(
    evidence: Evidence,
    *,
    step: float,
    lowest: float,
    fine_step: float,
    fine_end: float,
    straight: Pair,
    min_r2: float,
    margin: float,
) -> list[Check]:
    """V rises over frequencies at most ``step`` (Hz) apart: a coarse grid, or all of them.

    All vote where the step is ``fine_step`` or less; the other grid is shown. The creep, that is
    V at 10 and 14 Hz over V(20 Hz), is reported.
    """
    line = select_replicated(evidence.line("belt", "frequency"))
    if not set(line) >= {*COARSE, *FINE}:
        raise Untestable("no frequencies 16, 18, 20, 25, 30, 40, 50, 60, 80, 100 Hz with two beds")
    flowing = {f: place for f, place in line.items() if f in FINE or f >= MIN_FLOW_FREQUENCY}
    fine = {f: place for f, place in flowing.items() if f >= lowest}
    coarse = {f: place for f, place in fine.items() if f % COARSE_STEP == 0}
    fast = {f: place for f, place in coarse.items() if straight[0] <= f <= straight[1]}
    widest = np.diff([f for f in fine if f <= fine_end]).max()
    too_coarse = f"frequencies up to {fine_step:g} Hz apart" if widest > fine_step else ""
    fit = determination(np.array([*fast]), [place.velocity for place in fast.values()])
    quantity = "R² of a line through V(f), {} to {} Hz".format(*straight)
    creep = [
        reported(
            f"creep, V({f:g} Hz)/V(20 Hz)",
            quotient(line[f].velocity, line[20].velocity),
            (line[f], line[20]),
        )
        for f in CREEP
        if f in line
    ]
    by_grid = [
        velocity_trend(coarse, "f (Hz)", margin=margin, unit="Hz"),
        *withhold([velocity_trend(fine, "f (Hz)", margin=margin, unit="Hz")], too_coarse),
    ]
    if step <= fine_step:
        by_grid.reverse()
    return [
        by_grid[0],
        *remove_votes(by_grid[1:]),
        above(quantity, fit, min_r2, fast.values()),
        *creep,
        *_single_rises(evidence),
    ]


def _single_rises(evidence: Evidence) -> list[Check]:
    """Report how likely one bed per frequency rises throughout, for the curves of Figs. 1a and 1b.

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
            checks.append(reported_likelihood(f"{quantity}, all of Figs. 1a and 1b", everything))
    return checks


def determination(abscissa: np.ndarray, values: Sequence[UFloat]) -> UFloat:
    """Return R² of the straight line through some values."""
    centred = abscissa - abscissa.mean()
    mean = sum(values) / len(values)
    deviations = [value - mean for value in values]
    product = sum(x * y for x, y in zip(centred, deviations, strict=True))
    return product**2 / ((centred**2).sum() * sum(y**2 for y in deviations))


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
