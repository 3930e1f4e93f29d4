"""Judges of Walton's claims about regimes: which flows accelerate, are steady, come to rest."""

from collections.abc import Mapping
from itertools import chain
from math import inf, nan, radians, tan

from uncertainties import UFloat

from sim.base.statistics import MANY, student
from sim.claims.checks import above, below, beside, in_parts, reported, withheld, within
from sim.claims.chute import (
    CELLS,
    acceleration,
    base,
    driving,
    is_flowing,
    natural,
    of_settled,
    of_trend,
    repeated,
    unsettled,
)
from sim.claims.evidence import Evidence
from sim.claims.place import Place, joined, measured, quotient
from sim.claims.states import shares
from sim.claims.verdict import LONGER, NOT_REPRODUCED, REPRODUCED, Check, Unbounded, Untestable

#: Largest acceleration over g sin θ that counts as none, and the shortest time in √(σ/g).
STEADY, LONG = 0.01, 100

#: Depths that the paper calls slowest lie between these, and are compared with the first one from
#: this on.
SLOWEST, FASTER = (1, 2), 2.5

#: Frictions below tan θ, and depths that the flows at each of them must span.
SLIPPERY, DEPTHS = (0, 0.1, 0.2, 0.25, 0.3), {0.5, 40}

#: Frictions over tan θ that are somewhat above it, and from where on they greatly exceed it.
SOMEWHAT, GREATLY = 1.5, 2.0

#: Depths of the sweeps over friction, and of the windows of angles.
SWEPT, TILTED = (1.24, 2.5, 5, 10, 20), (5, 10, 20)

#: Starts in √(gσ) slightly faster than the expected speed of a flow that comes to rest.
SLOW_STARTS = (0.5, 1.0)

#: Depths at which starts are compared one by one, and those where states are.
STARTED, STATED = (2.5, 5), (10, 20)

#: Depths whose windows of angles must be known.
NEEDED = (5, 10)

#: How far starts must lie from the steady velocity, relative to it, and how near the usual one.
SLOW, FAST, NEAR = 2 / 3, 1.5, 0.25


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
            # So that the bound of one side, which is what decides, is at five errors.
            sure = measured(
                gained.nominal_value, 5 * error * student(MANY) / student(MANY, sides=1)
            )
            what = f"dV/dt over g sin θ within 5 errors, {at}"
            checks.append(of_trend(above(what, sure, 0, [place]), place))
    return checks


def w7(evidence: Evidence) -> list[Check]:
    """The flow of half a layer against a sphere that rolls alone, and how fast it has become."""
    place = evidence.at("chute", depth=0.5)
    if place.completed < 2:
        raise Untestable("no flow at n = 0.5 that has replicates")
    reached = place.velocity / natural(place)
    rolling = acceleration(place) / (5 / 7)
    checks = [
        within("dV/dt over (5/7) g sin θ, n = 0.5", rolling, 0.9, 1.1, [place]),
        above("V at which it still does so, n = 0.5", reached, 50, [place], "√(gσ)"),
    ]
    if place.regime in ("undetermined", "mixed"):
        return withheld(checks, f"the flow is {place.regime}")
    # The velocity is that of the window, whose trend is what counts. One that still grows at too
    # low a velocity has been watched for too short a time; a plateau has another trend.
    rolls, fast = (of_trend(check, place) for check in checks)
    short = rolls.verdict == REPRODUCED and fast.verdict == NOT_REPRODUCED
    return [rolls, *withheld([fast], LONGER if short else "")]


def w8(evidence: Evidence) -> list[Check]:
    """Flows between one and two layers: their drift, and V over that of the next deeper flow.

    The ends are reported, and so is the least depth of a steady flow.
    """
    flows = repeated(base(evidence))
    thin = {n: place for n, place in flows.items() if SLOWEST[0] <= n <= SLOWEST[1]}
    thin = {n: place for n, place in thin.items() if place["average"] >= LONG}
    between = [n for n in thin if SLOWEST[0] < n < SLOWEST[1]]
    deep = min((n for n in flows if n >= FASTER), default=None)
    if len(between) < 2 or deep is None:
        raise Untestable(
            "fewer than two flows with 1 < n < 2, replicates and 100 √(σ/g), or none with n ≥ 2.5"
        )
    checks = []
    for n, place in thin.items():
        drift = acceleration(place)
        steady = within(f"dV/dt over g sin θ, n = {n:g}", drift, -STEADY, STEADY, [place])
        ratio, pair = quotient(place.velocity, flows[deep].velocity), [place, flows[deep]]
        slower = below(f"V at n = {n:g} over that at n = {deep:g}", ratio, 1, pair)
        found = [of_trend(steady, place), slower]
        checks += found if n in between else beside(found)
    least = _boundary(evidence, "acceleration", "depth", any_protocol=True)
    if least is not None:
        checks.append(reported("least depth of a steady flow", least))
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


def w19(evidence: Evidence, steady: float) -> list[Check]:
    """Flows over a sweep of friction: steady a little above tan θ (a), at rest beyond twice (b).

    Steady is a flow whose velocity changes by less than a share ``steady`` of g sin θ. A flow at
    rest is one started slightly faster than that; fast starts are reported.
    """
    return in_parts(a=lambda: _steady_above(evidence, steady), b=lambda: _arrested_beyond(evidence))


def _steady_above(evidence: Evidence, steady: float) -> list[Check]:
    """Mean slope of all replicates at a depth, whatever the friction just above tan θ."""
    checks, swept = [], False
    for n in SWEPT:
        somewhat = [
            place
            for mu, place in _sweep(evidence, n).items()
            if 1 < mu <= SOMEWHAT and place.completed > 1
        ]
        if not somewhat:
            continue
        swept |= len(somewhat) > 1
        pooled = sum(map(acceleration, somewhat)) / len(somewhat)
        what = f"dV/dt over g sin θ, {len(somewhat)} frictions, n = {n:g}"
        stopped = [place for place in somewhat if not is_flowing(place)]
        check = within(what, pooled, -steady, steady, somewhat)
        checks += withheld([check], f"{len(stopped)} of them do not move" if stopped else "")
    if not swept:
        raise Untestable("no depth with replicates at two frictions from 1 to 1.5 tan θ")
    return checks


def _arrested_beyond(evidence: Evidence) -> list[Check]:
    """Whether flows much rougher than the slope come to rest, by the velocity they start with."""
    slow: list[Check] = []
    usual: list[Check] = []
    for n in SWEPT:
        for start in SLOW_STARTS:
            sweep = _sweep(evidence, n, initial_velocity=start)
            rough = [place for mu, place in sweep.items() if mu > GREATLY]
            slow += [_arrested(place) for place in rough]
            usual += chain.from_iterable(map(_waited, rough))
        sweep = _sweep(evidence, n)
        usual += [_arrested(place) for mu, place in sweep.items() if mu > GREATLY]
    if not slow and not usual:
        raise Untestable("no flow beyond twice tan θ")
    return [*slow, *beside(usual)]


def _sweep(evidence: Evidence, depth: float, **where: float) -> dict[float, Place]:
    """Return the flows of a depth by their friction over tan θ."""
    line = evidence.line("chute", "friction", depth=depth, cell=CELLS[depth], **where)
    return {mu / tan(radians(place["angle"])): place for mu, place in line.items()}


def _arrested(place: Place) -> Check:
    """Return the check that a flow has come to rest.

    By the definition of that regime V/√(gσ) then stays below 1e-3 over half of the window, which is
    50 √(σ/g) at least. One that flows without much change will not; one that slows is undecided,
    and so is one whose replicates do not all do the same.
    """
    rests, regimes = nan, set(place.values("regime"))
    if place["average"] >= LONG and regimes == {"arrested"}:
        rests = 1.0
    elif "arrested" not in regimes and (regimes == {"accelerating"} or not unsettled(place)):
        rests = 0.0
    return above(f"at rest (1) or not (0), {_rough(place)}", rests, 0.5, [place])


def _rough(place: Place) -> str:
    """Return what tells a flow of the sweeps over friction from others."""
    return f"μ = {place['friction']:g}, n = {place['depth']:g}, V0 = {place['initial_velocity']:g}"


def _waited(place: Place) -> list[Check]:
    """Return what is reported of the time, in √(σ/g), after which a flow was at rest, if it is."""
    if place.regime != "arrested":
        return []
    try:
        waited = joined(place.values("transient_end")) / (natural(place) / place["gravity"])
    except Untestable:
        return []
    return [reported(f"time until at rest, {_rough(place)}", waited, [place], "√(σ/g)")]


def w23(evidence: Evidence, forgotten: float) -> list[Check]:
    """Velocities after slower and faster starts over that after the start nearest to it: the same
    but for a share ``forgotten``.

    Of deep flows the states are reported by their start.
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
            ratio = quotient(place.velocity, steady.velocity)
            what = f"V after a start at {relative[start]:.2g} V, n = {n:g}, over the usual V"
            bounds = 1 - forgotten, 1 + forgotten
            pair = [place, steady]
            # A flow that has come to rest has not forgotten its start.
            moving = [one for one in pair if is_flowing(one)]
            checks += of_settled([within(what, ratio, *bounds, pair)], moving)
    if missing:
        raise Untestable(f"no starts at V, half and twice of it at n = {', '.join(missing)}")
    return [*checks, *chain.from_iterable(_states(evidence, n) for n in STATED)]


def _states(evidence: Evidence, depth: float) -> list[Check]:
    """Return what is reported of the states of a deep flow by its start."""
    line = evidence.line("chute", "initial_velocity", depth=depth, cell=CELLS[depth])
    found = []
    for start, place in line.items():
        try:
            found += shares(f"start at {start:g} √(gσ), n = {depth:g}", [place])
        except Untestable:
            continue
    return found


def _nearest(line: Mapping[float, Place]) -> float | None:
    """Return the start (√(gσ)) nearest to the velocity it led to, of settled flows if any."""

    def off(start: float) -> tuple[bool, float]:
        place = line[start]
        reached = place.velocity.nominal_value / natural(place)
        return bool(unsettled(place)), abs(start / reached - 1)

    return min((start for start in line if is_flowing(line[start])), key=off, default=None)


def w25(evidence: Evidence, least_width: float) -> list[Check]:
    """The narrowest window, of any seed, between angles at which flows rest and run away, is wider
    than ``least_width`` (degrees).

    Its ends are the inner ones of the brackets: flows are seen to move at the lower one, and seen
    not to accelerate at the upper one.
    """
    checks, missing = [], []
    for n in TILTED:
        try:
            runaway, rest = (
                evidence.brackets("chute", of, "angle", depth=n) for of in ("acceleration", "flow")
            )
        except Untestable:
            if n in NEEDED:
                missing.append(f"{n:g}")
            continue
        width = (runaway["low"] - rest["high"]).dropna()
        what = f"narrowest window of {len(width)} seeds, n = {n:g}"
        check = above(what, float(width.min()), least_width, unit="°")
        known = len(width) == len(runaway) > 1
        checks += withheld([check], "" if known else "limits from two seeds or more")
    if missing:
        raise Untestable(f"no bounds of the angle of steady flow at n = {', '.join(missing)}")
    return checks
