"""Judges of Walton's claims about regimes: which flows accelerate, are steady, come to rest."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import inf, nan, radians, tan

from uncertainties import UFloat

from sim.claims.checks import above, below, within
from sim.claims.chute import (
    CELLS,
    acceleration,
    base,
    driving,
    is_flowing,
    is_settled,
    natural,
    of_trend,
    repeated,
    speed,
)
from sim.claims.evidence import Evidence
from sim.claims.place import Place, measured, quotient
from sim.claims.verdict import NOT_REPRODUCED, REPRODUCED, Check, Unbounded, Untestable

#: Largest acceleration over g sin θ that counts as none, and the shortest time in √(σ/g).
STEADY, LONG = 0.01, 100

#: Depths that the paper calls slowest, and the least of those that it compares them with.
SLOWEST, FASTER = (1, 2), 2.5

#: Frictions below tan θ, and depths that the flows at each of them must span.
SLIPPERY, DEPTHS = (0, 0.1, 0.2, 0.25, 0.3), {0.5, 40}

#: Frictions over tan θ that are somewhat above it, and from where on they greatly exceed it.
SOMEWHAT, GREATLY = 1.5, 2.0

#: Depths of the sweeps over friction, of starts, and of the windows of angles.
SWEPT, STARTED, TILTED = (1.24, 2.5, 5, 10, 20), (2.5, 5, 10), (5, 10, 20)

#: Depths whose windows of angles must be known.
NEEDED = (5, 10)

#: How far starts must lie from the steady velocity, relative to it, how near the usual one, and
#: what they may change.
SLOW, FAST, NEAR, FORGOTTEN = 2 / 3, 1.5, 0.25, 0.03

#: Least width in degrees of a window of angles: four times what its bounds are known to.
WINDOW = 1.0


def w6(evidence: Evidence) -> list[Check]:
    """Accelerations below tan θ against those of a sliding block, and five errors above zero."""
    lines = {mu: evidence.line("chute", "depth", friction=mu) for mu in SLIPPERY}
    missing = [f"{mu:g}" for mu, line in lines.items() if not line.keys() >= DEPTHS]
    if missing:
        raise Untestable(f"no flows at n = 0.5 and 40 at friction {', '.join(missing)}")
    checks = []
    for mu, line in lines.items():
        for depth, place in line.items():
            gained, slope = acceleration(place), radians(place["angle"])
            block, at = 1 - mu / tan(slope), f"μ = {mu:g}, n = {depth:g}"
            what = f"dV/dt over that of a block, {at}"
            checks.append(of_trend(above(what, gained / block, 0.9, [place]), place))
            error = place.value("acceleration", "acceleration_error").std_dev / driving(place)
            sure = measured(gained.nominal_value, 5 * error)
            what = f"dV/dt over g sin θ within 5 errors, {at}"
            checks.append(of_trend(above(what, sure, 0, [place]), place))
    return checks


def w7(evidence: Evidence) -> list[Check]:
    """The flow of half a layer against a sphere that rolls alone, and how fast it has become."""
    place = evidence.at("chute", depth=0.5)
    reached = place.velocity / natural(place)
    rolling = acceleration(place) / (5 / 7)
    checks = [
        within("dV/dt over (5/7) g sin θ, n = 0.5", rolling, 0.9, 1.1, [place]),
        above("V at which it still does so, n = 0.5", reached, 50, [place], "√(gσ)"),
    ]
    if place.regime in ("undetermined", "mixed"):
        return [replace(check, samples=0.0) for check in checks]
    # The velocity is that of the window, whose trend is what counts. One that still grows at too
    # low a velocity has been watched for too short a time; a plateau has another trend.
    rolls, fast = (of_trend(check, place) for check in checks)
    short = rolls.verdict == REPRODUCED and fast.verdict == NOT_REPRODUCED
    return [rolls, replace(fast, samples=0.0) if short else fast]


def w8(evidence: Evidence) -> list[Check]:
    """Drift of the flows of one to two layers, and their velocities over those of deeper flows."""
    flows = repeated(base(evidence))
    thin = {n: place for n, place in flows.items() if SLOWEST[0] <= n <= SLOWEST[1]}
    thin = {n: place for n, place in thin.items() if place["average"] >= LONG}
    deep = [place for n, place in flows.items() if n >= FASTER]
    if len(thin) < 3 or len(deep) < 3:
        raise Untestable(
            "fewer than three flows that have replicates, with 1 ≤ n ≤ 2 for 100 √(σ/g) or n ≥ 2.5"
        )
    checks = []
    for n, place in thin.items():
        drift = acceleration(place)
        check = within(f"dV/dt over g sin θ, n = {n:g}", drift, -STEADY, STEADY, [place])
        checks.append(of_trend(check, place))
        for other in deep:
            what = f"V at n = {n:g} over that at n = {other['depth']:g}"
            checks.append(below(what, quotient(speed(place), speed(other)), 1, [place, other]))
    least = _boundary(evidence, "acceleration", "depth", any_protocol=True)
    if least is not None:
        checks.append(within("least depth of a steady flow", least, 0.5, 1))
    return checks


def _boundary(
    evidence: Evidence, of: str, along: str, any_protocol: bool = False, **where: float
) -> UFloat | None:
    """Return a boundary, nothing where none was looked for, and an endless interval where a start
    has none in the range.
    """
    try:
        return evidence.boundary("chute", of, along, seeds=True, any_protocol=any_protocol, **where)
    except Unbounded:
        return measured(nan, inf)
    except Untestable:
        return None


def w19(evidence: Evidence) -> list[Check]:
    """Flows over a sweep of friction: steady a little above tan θ, at rest beyond twice that.

    The base case, whose friction is somewhat above tan θ, is to be steady at all depths.
    """
    checks = []
    for n in SWEPT:
        line = evidence.line("chute", "friction", depth=n, cell=CELLS[n])
        line = {mu / tan(radians(place["angle"])): place for mu, place in line.items()}
        somewhat = [place for mu, place in line.items() if 1 < mu <= SOMEWHAT]
        greatly = [place for mu, place in line.items() if mu > GREATLY]
        if len(somewhat) >= 2 and len(greatly) >= 2:
            checks += [check for place in somewhat for check in _steady(place)]
            checks += [_arrested(place) for place in greatly]
    if not checks:
        raise Untestable("no depth with two frictions from 1 to 1.5 tan θ and two beyond 2 tan θ")
    seen = {point for check in checks for point in check.points}
    others = repeated(base(evidence, SWEPT[0])).values()
    return checks + [check for one in others if one.id not in seen for check in _steady(one)]


def _steady(place: Place) -> Iterator[Check]:
    """Yield the checks that a flow moves, without acceleration."""
    at, moving = _named(place), place.velocity / natural(place)
    yield above(f"V/√(gσ), {at}", moving, 1e-3, [place])
    check = within(f"dV/dt over g sin θ, {at}", acceleration(place), -STEADY, STEADY, [place])
    yield of_trend(check, place)


def _arrested(place: Place) -> Check:
    """Return the check that a flow has come to rest.

    By the definition of that regime V/√(gσ) then stays below 1e-3 over half of the window, which is
    50 √(σ/g) at least. One that flows without much change will not; one that slows is undecided,
    and so is one whose replicates do not all do the same.
    """
    rests, regimes = nan, set(place.values("regime"))
    if place["average"] >= LONG and regimes == {"arrested"}:
        rests = 1.0
    elif "arrested" not in regimes and (regimes == {"accelerating"} or is_settled(place)):
        rests = 0.0
    return above(f"at rest (1) or not (0), {_named(place)}", rests, 0.5, [place])


def _named(place: Place) -> str:
    return f"μ = {place['friction']:g}, n = {place['depth']:g}"


def w23(evidence: Evidence) -> list[Check]:
    """Velocities after slower and faster starts over that after the start nearest to it.

    What a start has not forgotten yet counts: flows that still drift do so with their drift.
    """
    checks, missing = [], []
    for n in STARTED:
        line = evidence.line("chute", "initial_velocity", depth=n, cell=CELLS[n])
        near = _nearest(line)
        if near is None:
            missing.append(f"{n:g}")
            continue
        steady = line.pop(near)
        reached = steady.velocity.nominal_value / natural(steady)
        relative = {start: start / reached for start in line}
        ends = min(relative.values(), default=inf), max(relative.values(), default=0)
        if abs(near / reached - 1) > NEAR or ends[0] > SLOW or ends[1] < FAST:
            missing.append(f"{n:g}")
            continue
        for start, place in line.items():
            ratio = quotient(speed(place), speed(steady))
            what = f"V after a start at {relative[start]:.2g} V, n = {n:g}, over the usual V"
            bounds = 1 - FORGOTTEN, 1 + FORGOTTEN
            checks.append(within(what, ratio, *bounds, [place, steady]))
    if missing:
        raise Untestable(f"no starts at V, half and twice of it at n = {', '.join(missing)}")
    return checks


def _nearest(line: Mapping[float, Place]) -> float | None:
    """Return the start (√(gσ)) nearest to the velocity it led to, of settled flows if any."""

    def off(start: float) -> tuple[bool, float]:
        place = line[start]
        reached = place.velocity.nominal_value / natural(place)
        return not is_settled(place), abs(start / reached - 1)

    return min((start for start in line if is_flowing(line[start])), key=off, default=None)


def w25(evidence: Evidence) -> list[Check]:
    """Width of the window between the angles at which flows come to rest and run away."""
    checks, missing = [], []
    for n in TILTED:
        runaway = _boundary(evidence, "acceleration", "angle", depth=n)
        rest = _boundary(evidence, "flow", "angle", depth=n)
        if runaway is not None and rest is not None:
            what = f"window from {rest.nominal_value:.3g}° on, n = {n:g}"
            checks.append(above(what, runaway - rest, WINDOW, unit="°"))
        elif n in NEEDED:
            missing.append(f"{n:g}")
    if missing:
        raise Untestable(f"no bounds of the angle of steady flow at n = {', '.join(missing)}")
    return checks
