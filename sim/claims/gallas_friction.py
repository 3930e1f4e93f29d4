"""Judges of Gallas' claims about the shear friction coefficient."""

from collections.abc import Sequence
from math import log, nan, sqrt

from uncertainties import ufloat

from sim.claims.checks import above, reported, withhold, within
from sim.claims.evidence import Evidence
from sim.claims.lines import complete_line, elasticity, reason_drifting
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable


def g9(evidence: Evidence, min_share: float) -> list[Check]:
    """More than ``min_share`` of the rise with γ_s is complete at 10g; beyond it V rises gently."""
    checks = []
    for frequency in (20, 50):
        line = complete_line(evidence, "shear_damping", (0, 10, 20, 50, 100), frequency=frequency)
        gentle = {value: place for value, place in line.items() if value >= 10}
        start = line[0].velocity
        share = (line[10].velocity - start) / (line[100].velocity - start)
        quantity = f"[V(10g) - V(0)]/[V(100g) - V(0)] at {frequency} Hz"
        rise = f"d ln V/d ln γ_s, 10g to 100g, at {frequency} Hz"
        pair = [
            above(quantity, share, min_share, (line[0], line[10], line[100])),
            within(rise, elasticity(gentle), 0, 0.2, gentle.values()),
        ]
        reasons = filter(None, (reason_drifting(place) for place in gentle.values()))
        checks += withhold(pair, "; ".join(reasons))
    return checks


def g10(evidence: Evidence, max_ratio: float) -> list[Check]:
    """Without shear friction |V| is below ``max_ratio`` times V at 50g."""
    checks = []
    for frequency in (20, 50):
        still = evidence.at("belt", frequency=frequency, shear_damping=0)
        usual = evidence.at("belt", frequency=frequency)
        ratio = quotient(still.velocity, usual.velocity)
        quantity = f"V(γ_s = 0)/V(50g) at {frequency} Hz"
        checks.append(within(quantity, ratio, -max_ratio, max_ratio, (still, usual)))
    return checks


def g11(evidence: Evidence, min_ratio: float) -> list[Check]:
    """The relative scatter over beds below γ_s = g is more than ``min_ratio`` times that at 50g.

    Variances of 20 and 50 Hz are pooled. Their ratio is judged by its logarithm, with the standard
    deviation of Fisher's z.
    """
    weakly_damped = [
        place
        for frequency in (20, 50)
        for shear, place in evidence.line("belt", "shear_damping", frequency=frequency).items()
        if 0 < shear < 1
    ]
    usual = [evidence.at("belt", frequency=frequency) for frequency in (20, 50)]
    (scatter, freedom), (usual_scatter, usual_freedom) = map(
        relative_scatter, (weakly_damped, usual)
    )
    if not (scatter > 0 and usual_scatter > 0):
        raise Untestable("no scatter over several beds at γ_s < g, or none at 50g")
    ratio = ufloat(log(scatter / usual_scatter), sqrt(0.5 / freedom + 0.5 / usual_freedom))
    quantity = "ln of the relative scatter of V at γ_s < g over that at 50g"
    return [above(quantity, ratio, log(min_ratio), (*weakly_damped, *usual))]


def relative_scatter(places: Sequence[Place]) -> tuple[float, float]:
    """Return the pooled relative standard deviation over beds, and its degrees of freedom."""
    freedom = sum(max(0, place.completed - 1) for place in places)
    squares = sum(
        (((values := place.values("velocity")) / values.mean() - 1) ** 2).sum() for place in places
    )
    return (sqrt(squares / freedom), freedom) if freedom else (nan, nan)


def g12(evidence: Evidence, max_change: float) -> list[Check]:
    """From γ_s = 50g to 100g the velocity at 80 Hz changes by less than ``max_change``."""
    places = evidence.at("belt", frequency=80, shear_damping=100), evidence.at("belt", frequency=80)
    change = quotient(places[0].velocity, places[1].velocity) - 1
    return [within("V(100g)/V(50g) - 1 at 80 Hz", change, -max_change, max_change, places)]


def g36(evidence: Evidence, min_ratio: float) -> list[Check]:
    """γ_s changes V at 20 Hz more than ``min_ratio`` times as much as at 80 Hz, from 20g to 100g.

    Both changes are relative and count by their absolute values: V may fall. Both elasticities with
    their signs, and the rise of V at small γ_s, are reported.
    """
    lines = {
        frequency: complete_line(evidence, "shear_damping", (20, 50, 100), frequency=frequency)
        for frequency in (20, 80)
    }
    slopes = {frequency: elasticity(line) for frequency, line in lines.items()}
    places = [place for line in lines.values() for place in line.values()]
    excess = abs(slopes[20]) - min_ratio * abs(slopes[80])
    quantity = f"|d ln V/d ln γ_s| at 20 Hz less {min_ratio:g} times that at 80 Hz"
    checks = [above(quantity, excess, 0, places)]
    for frequency, line in lines.items():
        quantity = f"d ln V/d ln γ_s, 20g to 100g, at {frequency} Hz"
        checks.append(reported(quantity, slopes[frequency], line.values()))
    slow = evidence.line("belt", "shear_damping", frequency=50)
    small = {shear: place for shear, place in slow.items() if 0.5 <= shear <= 10}
    if len(small) > 2:
        quantity = f"d ln V/d ln γ_s, {min(small):g}g to {max(small):g}g, at 50 Hz"
        checks.append(reported(quantity, elasticity(small), small.values()))
    reasons = dict.fromkeys(filter(None, map(reason_drifting, places)))
    return withhold(checks, "; ".join(reasons))
