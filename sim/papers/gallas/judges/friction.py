"""Judges of Gallas' claims about the shear friction coefficient."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import copysign, log, nan, sqrt

from uncertainties import ufloat

from sim.claims.checks import Numbers, Pair, above, below, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable
from sim.papers.gallas.judges.lines import (
    bed,
    complete_line,
    elasticity,
    reason_drifting,
    velocity_trend,
)


def g9(
    evidence: Evidence,
    *,
    min_share: float,
    knee: float,
    most: float,
    max_slope: float,
    margin: float,
    frequencies: Numbers,
    max_drift: float,
    cycles: int,
) -> list[Check]:
    """More than ``min_share`` of the rise with γ_s up to ``most`` (g) is complete at the knee (a).

    Beyond the ``knee`` (g) V rises gently (b): its elasticity is below ``max_slope``.
    """
    checks = []
    for frequency in frequencies:
        steps = (0, knee, 20, 50, most)
        line = complete_line(evidence, "shear_damping", steps, frequency=frequency)
        gentle = {value: place for value, place in line.items() if value >= knee}
        start, places = line[0].velocity, tuple(gentle.values())
        share = (line[knee].velocity - start) / (line[most].velocity - start)
        quantity = f"[V({knee}g) - V(0)]/[V({most}g) - V(0)] at {frequency} Hz"
        slope = f"d ln V/d ln γ_s, {knee}g to {most}g, at {frequency} Hz"
        rise = velocity_trend(gentle, f"γ_s (g), {frequency} Hz,", margin=margin, unit="g")
        most_of_it = above(quantity, share, min_share, (line[0], line[knee], line[most]))
        is_gentle = below(slope, elasticity(gentle), max_slope, places)
        parts = ("a", most_of_it), ("b", rise), ("b", is_gentle)
        checks += withhold(
            [replace(check, part=part) for part, check in parts],
            _reason_unconverged(evidence, places, max_drift, cycles),
        )
    return checks


def g10(evidence: Evidence, *, max_ratio: float, usual: float, frequencies: Numbers) -> list[Check]:
    """Without shear friction |V| is below ``max_ratio`` times V at the usual one (g)."""
    checks = []
    for frequency in frequencies:
        places = [bed(evidence, frequency, shear_damping=shear) for shear in (0, usual)]
        ratio = quotient(*(place.velocity for place in places))
        quantity = f"V(γ_s = 0)/V({usual}g) at {frequency} Hz"
        checks.append(within(quantity, ratio, -max_ratio, max_ratio, places))
    return checks


def g11(evidence: Evidence, *, min_ratio: float, usual: float) -> list[Check]:
    """The relative scatter over beds below γ_s = g exceeds ``min_ratio`` times the usual one.

    Variances of 20 and 50 Hz are pooled. Their ratio is judged by its logarithm, with the standard
    deviation of Fisher's z.
    """
    weakly_damped = [
        place
        for frequency in (20, 50)
        for shear, place in evidence.line("belt", "shear_damping", frequency=frequency).items()
        if 0 < shear < 1
    ]
    firm = [bed(evidence, frequency, shear_damping=usual) for frequency in (20, 50)]
    scatter, freedom = relative_scatter(weakly_damped)
    usual_scatter, usual_freedom = relative_scatter(firm)
    if not (scatter > 0 and usual_scatter > 0):
        raise Untestable(f"no scatter over several beds at γ_s < g, or none at {usual}g")
    ratio = ufloat(log(scatter / usual_scatter), sqrt(0.5 / freedom + 0.5 / usual_freedom))
    quantity = f"ln of the relative scatter of V at γ_s < g over that at {usual}g"
    return [above(quantity, ratio, log(min_ratio), (*weakly_damped, *firm))]


def relative_scatter(places: Sequence[Place]) -> Pair:
    """Return the pooled relative standard deviation over beds, and its degrees of freedom."""
    freedom = sum(max(0, place.completed - 1) for place in places)
    velocities = [place.values("velocity") for place in places]
    squares = sum(((values / values.mean() - 1) ** 2).sum() for values in velocities)
    return (sqrt(squares / freedom), freedom) if freedom else (nan, nan)


def g12(
    evidence: Evidence, *, max_change: float, strong: float, usual: float, frequency: float
) -> list[Check]:
    """From the usual to a strong γ_s (g) the velocity changes by less than ``max_change``."""
    places = [bed(evidence, frequency, shear_damping=shear) for shear in (strong, usual)]
    change = quotient(*(place.velocity for place in places)) - 1
    quantity = f"V({strong}g)/V({usual}g) - 1 at {frequency} Hz"
    return [within(quantity, change, -max_change, max_change, places)]


def g36(
    evidence: Evidence,
    *,
    min_ratio: float,
    friction: Pair,
    slow: float,
    fast: float,
    max_drift: float,
    cycles: int,
) -> list[Check]:
    """γ_s changes V more than ``min_ratio`` times as much at a slow as at a fast frequency (Hz).

    ``friction`` are the ends (g) between which γ_s changes. Both elasticities with their signs, and
    the rise of V at small γ_s, are reported.
    """
    low, high = friction
    lines = {
        frequency: complete_line(evidence, "shear_damping", (low, 50, high), frequency=frequency)
        for frequency in (slow, fast)
    }
    slopes = {frequency: elasticity(line) for frequency, line in lines.items()}
    # `abs` of numbers with errors will leave the library.
    sizes = {frequency: copysign(1, one.nominal_value) * one for frequency, one in slopes.items()}
    places = [place for line in lines.values() for place in line.values()]
    excess = sizes[slow] - min_ratio * sizes[fast]
    quantity = f"|d ln V/d ln γ_s| at {slow} Hz less {min_ratio:g} times that at {fast} Hz"
    checks = [above(quantity, excess, 0, places)]
    for frequency, line in lines.items():
        quantity = f"d ln V/d ln γ_s, {low}g to {high}g, at {frequency} Hz"
        checks.append(reported(quantity, slopes[frequency], line.values()))
    weak = evidence.line("belt", "shear_damping", frequency=50)
    small = {shear: place for shear, place in weak.items() if 0.5 <= shear <= 10}
    if len(small) > 2:
        quantity = f"d ln V/d ln γ_s, {min(small):g}g to {max(small):g}g, at 50 Hz"
        checks.append(reported(quantity, elasticity(small), small.values()))
    return withhold(checks, _reason_unconverged(evidence, places, max_drift, cycles))


def _reason_unconverged(
    evidence: Evidence, places: Iterable[Place], max_drift: float, cycles: int
) -> str:
    """Return why converged flows may not have converged; empty for runs of the paper's length.

    These are judged as they are: what they show is what the paper could see.
    """
    if evidence.protocol != "converged":
        return ""
    reasons = dict.fromkeys(reason_drifting(place, max_drift, cycles) for place in places)
    return "; ".join(filter(None, reasons))
