"""Judges of Gallas' claims about the shear friction coefficient."""

from collections.abc import Sequence
from math import log, nan, sqrt

import numpy as np
from scipy.special import ndtri, stdtr
from uncertainties import ufloat

from sim.claims.checks import above, below, within
from sim.claims.evidence import Evidence
from sim.claims.lines import along, elasticity
from sim.claims.place import Place, quotient
from sim.claims.verdict import Check, Untestable


def g9(evidence: Evidence) -> list[Check]:
    """Most of the rise with γ_s is over at 10g, and what follows is gentle, at 20 and 50 Hz."""
    checks = []
    for frequency in (20, 50):
        line = along(evidence, "shear_damping", (0, 10, 20, 50, 100), frequency=frequency)
        start = line[0].velocity
        share = (line[10].velocity - start) / (line[100].velocity - start)
        what = f"[V(10g) - V(0)]/[V(100g) - V(0)] at {frequency} Hz"
        checks.append(above(what, share, 0.7, (line[0], line[10], line[100])))
        gentle = {value: place for value, place in line.items() if value >= 20}
        what = f"d ln V/d ln γ_s, 20g to 100g, at {frequency} Hz"
        checks.append(within(what, elasticity(gentle), 0, 0.2, gentle.values()))
    return checks


def g10(evidence: Evidence) -> list[Check]:
    """Without shear friction the mean over the beds is zero within 3 of its standard errors.

    A scatter so large that anything is zero proves nothing, so the velocity must also be known to
    be below a tenth of that at 50g.
    """
    checks = []
    for frequency in (20, 50):
        still = evidence.at("belt", frequency=frequency, shear_damping=0)
        usual = evidence.at("belt", frequency=frequency)
        what = f"|V|/SE at γ_s = 0, {frequency} Hz"
        checks.append(below(what, _errors_from_zero(still.values("velocity")), 3, (still,)))
        ratio = quotient(still.velocity, usual.velocity)
        what = f"V(γ_s = 0)/V(50g) at {frequency} Hz"
        checks.append(within(what, ratio, -0.1, 0.1, (still, usual)))
    return checks


def _errors_from_zero(values: np.ndarray) -> float:
    """Return how many standard errors a mean is from zero.

    Errors of few values are uncertain themselves: given is the number of errors that is as rare
    among many values.
    """
    if values.size < 2:
        return nan
    errors = abs(values.mean()) / (values.std(ddof=1) / sqrt(values.size))
    return float(-ndtri(stdtr(values.size - 1, -errors)))


def g11(evidence: Evidence) -> list[Check]:
    """The relative scatter over beds below γ_s = g is five times that at 50g.

    Variances of 20 and 50 Hz are pooled, and their ratio is judged by its logarithm, whose standard
    deviation is that of Fisher's z.
    """
    few = [
        place
        for frequency in (20, 50)
        for shear, place in evidence.line("belt", "shear_damping", frequency=frequency).items()
        if 0 < shear < 1
    ]
    usual = [evidence.at("belt", frequency=frequency) for frequency in (20, 50)]
    (scatter, freedom), (usual_scatter, usual_freedom) = map(relative_scatter, (few, usual))
    if not (scatter > 0 and usual_scatter > 0):
        raise Untestable("no scatter over several beds at γ_s < g, or none at 50g")
    ratio = ufloat(log(scatter / usual_scatter), sqrt(0.5 / freedom + 0.5 / usual_freedom))
    what = "ln of the relative scatter of V at γ_s < g over that at 50g"
    return [above(what, ratio, log(5), (*few, *usual))]


def relative_scatter(places: Sequence[Place]) -> tuple[float, float]:
    """Return the pooled relative standard deviation over beds, and its degrees of freedom."""
    freedom = sum(max(0, place.completed - 1) for place in places)
    squares = sum(
        (((values := place.values("velocity")) / values.mean() - 1) ** 2).sum() for place in places
    )
    return (sqrt(squares / freedom), freedom) if freedom else (nan, nan)


def g12(evidence: Evidence) -> list[Check]:
    """From γ_s = 50g to 100g the velocity at 80 Hz changes by less than 10 %."""
    places = evidence.at("belt", frequency=80, shear_damping=100), evidence.at("belt", frequency=80)
    change = quotient(places[0].velocity, places[1].velocity) - 1
    return [within("V(100g)/V(50g) - 1 at 80 Hz", change, -0.1, 0.1, places)]


def g36(evidence: Evidence) -> list[Check]:
    """V gains relatively more from γ_s, between 20g and 100g, at 20 Hz than at 80 Hz."""
    lines = [
        along(evidence, "shear_damping", (20, 50, 100), frequency=frequency)
        for frequency in (20, 80)
    ]
    gain = elasticity(lines[0]) - elasticity(lines[1])
    places = [place for line in lines for place in line.values()]
    return [above("d ln V/d ln γ_s at 20 Hz less that at 80 Hz", gain, 0, places)]
