"""The damping that gives a restitution, and the reverse, of laws with a spring and a dashpot.

Relative to the critical one it is ζ, for a linear spring K α with a dashpot 2 ζ √(K m) dα/dt and
for Hertz's spring with Tsuji's dashpot alike: with y = α^(5/4) the latter has the equation of the
former in the plane of y and dα/dt (Antypov and Elliott, EPL 94 (2011) 50004). Where the force may
pull, the contact ends as the overlap does, and -ln e = π ζ/√(1 - ζ²). Where it is clipped at zero,
it ends as the force does, at the time 2 f(ζ)/ω₀, and -ln e = 2 ζ f(ζ) with f(ζ) = arccos ζ/√(1 -
ζ²), beyond ζ = 1 arcosh ζ/√(ζ² - 1) (Schwager and Pöschel, Granular Matter 9 (2007) 465).
"""

from functools import cache
from math import acos, acosh, exp, hypot, inf, log, pi, sqrt
from typing import Any

#: Halvings after which an interval of doubles has no middle.
_HALVINGS = 100


@cache
def damping_fraction(restitution: float, attraction: str) -> tuple[float, float]:
    """Return numerator and denominator of the damping ratio ζ that gives a restitution."""
    decay = -log(restitution)
    if attraction == "kept":
        return decay, sqrt(pi**2 + decay**2)
    low, high = 0.0, 1.0 + exp(0.5 * decay)
    for _ in range(_HALVINGS):
        ratio = 0.5 * (low + high)
        low, high = (ratio, high) if 2.0 * ratio * _half_time(ratio) < decay else (low, ratio)
    return high if decay > 0.0 else 0.0, 1.0


def contact_time(restitution: float, attraction: str) -> float:
    """Return how long a linear spring and dashpot push, over π/ω₀, the time of the spring alone."""
    if attraction == "kept":
        return hypot(1, log(restitution) / pi)
    return time_of(damping_fraction(restitution, attraction)[0], attraction)


def damping_ratio(rate: float, stiffness: float, mass: float) -> float:
    """Return ζ of a dashpot γ m at the rate γ (1/s), for K (N/m) and the reduced mass (kg)."""
    return 0.5 * rate * sqrt(mass / stiffness)


def time_of(ratio: float, attraction: str) -> float:
    """Return how long a damping ratio ζ lets a linear spring push, over the time without it."""
    if attraction == "kept":
        return 1.0 / sqrt((1.0 - ratio) * (1.0 + ratio)) if ratio < 1.0 else inf
    return 2.0 / pi * _half_time(ratio)


def restitution_of(ratio: float, attraction: str) -> float:
    """Return the restitution that a damping ratio ζ gives."""
    return exp(-pi * ratio * time_of(ratio, attraction)) if ratio else 1.0


def _half_time(ratio: float) -> float:
    """Return f(ζ), half the time in 1/ω₀ until the force of a damped spring is zero again."""
    if ratio < 1.0:
        return acos(ratio) / sqrt((1.0 - ratio) * (1.0 + ratio))
    return acosh(ratio) / sqrt((ratio - 1.0) * (ratio + 1.0)) if ratio > 1.0 else 1.0


def by_restitution(p: Any) -> bool:
    """Return whether LAMMPS is told the restitution of a point, not a rate of damping.

    Under a linear spring that is so where each pair has its own rate.
    """
    has_several = p.law == "spring_dashpot" and not p.has_one_mass
    return p.law == "hertz" or (has_several and not p.normal_damping)
