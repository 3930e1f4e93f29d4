"""Judges of Walton's claims about regimes: flows that accelerate, are steady, come to rest."""

from collections.abc import Mapping
from itertools import chain
from math import inf, nan, radians, tan

from uncertainties import UFloat

from sim.base.statistics import MANY, student
from sim.claims.checks import above, below, judge_parts, remove_votes, reported, withhold, within
from sim.claims.chute import (
    CELLS,
    acceleration,
    base_flows,
    driving_acceleration,
    is_flowing,
    natural_speed,
    reason_unsettled,
    select_replicated,
    waive_samples,
    withhold_unsettled,
)
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient, replicate_mean, with_interval
from sim.claims.states import report_states
from sim.claims.verdict import LONGER_RUNS, NOT_REPRODUCED, REPRODUCED, Check, Unbounded, Untestable

#: Largest negligible acceleration over g sin θ, and the shortest averaging time in √(σ/g).
MAX_ACCELERATION, MIN_AVERAGE = 0.01, 100

#: Range of the depths that the paper calls slowest, and the least depth of the flow that they are
#: compared with.
SLOWEST_DEPTHS, MIN_FASTER_DEPTH = (1, 2), 2.5

#: Frictions below tan θ, and depths required at each of them.
SLIPPERY, REQUIRED_SLIPPERY_DEPTHS = (0, 0.1, 0.2, 0.25, 0.3), {0.5, 40}

#: Friction over tan θ: up to the first "somewhat above", from the second on "greatly above".
SOMEWHAT_ABOVE, GREATLY_ABOVE = 1.5, 2.0

#: Depths of the sweeps over friction, and of the windows of angles.
SWEEP_DEPTHS, ANGLE_DEPTHS = (1.24, 2.5, 5, 10, 20), (5, 10, 20)

#: Initial velocities in √(gσ), slightly above the expected speed of a flow that comes to rest.
SLOW_STARTS = (0.5, 1.0)

#: Depths at which velocities are compared by start, and those at which states are reported.
START_DEPTHS, STATE_DEPTHS = (2.5, 5), (10, 20)

#: Depths whose windows of angles are required.
REQUIRED_DEPTHS = (5, 10)

#: Starts over the steady velocity: largest slow, smallest fast, and tolerance of the nearest one.
MAX_SLOW, MIN_FAST, NEAR_TOLERANCE = 2 / 3, 1.5, 0.25


def w6(evidence: Evidence) -> list[Check]:
    """Accelerations below tan θ: against those of a sliding block, and five errors above zero."""
    lines = {mu: evidence.line("chute", "depth", friction=mu) for mu in SLIPPERY}
    missing = [
        f"{mu:g}" for mu, line in lines.items() if not line.keys() >= REQUIRED_SLIPPERY_DEPTHS
    ]
    if missing:
        raise Untestable(f"no flows at n = 0.5 and 40 at friction {', '.join(missing)}")
    checks = []
    for mu, line in lines.items():
        for depth, place in line.items():
            gain, slope = acceleration(place), radians(place["angle"])
            block, label = 1 - mu / tan(slope), f"μ = {mu:g}, n = {depth:g}"
            quantity = f"dV/dt over that of a block, {label}"
            checks.append(waive_samples(above(quantity, gain / block, 0.9, [place]), place))
            error = place.value(
                "acceleration", "acceleration_error"
            ).std_dev / driving_acceleration(place)
            # The one-sided bound, which decides, then lies at five errors.
            five_errors = with_interval(
                gain.nominal_value, 5 * error * student(MANY) / student(MANY, sides=1)
            )
            quantity = f"dV/dt over g sin θ within 5 errors, {label}"
            checks.append(waive_samples(above(quantity, five_errors, 0, [place]), place))
    return checks


def w7(evidence: Evidence) -> list[Check]:
    """The flow of half a layer: dV/dt against a sphere that rolls alone, and its velocity."""
    place = evidence.at("chute", depth=0.5)
    if place.completed < 2:
        raise Untestable("no flow at n = 0.5 that has replicates")
    speed = place.velocity / natural_speed(place)
    rolling = acceleration(place) / (5 / 7)
    checks = [
        within("dV/dt over (5/7) g sin θ, n = 0.5", rolling, 0.9, 1.1, [place]),
        above("V at which it still does so, n = 0.5", speed, 50, [place], "√(gσ)"),
    ]
    if place.regime in ("undetermined", "mixed"):
        return withhold(checks, f"the flow is {place.regime}")
    # The velocity is the mean over the window, and the trend of the window decides. A flow that
    # still grows at too low a velocity needs a longer run; a plateau has another trend.
    rolls, fast = (waive_samples(check, place) for check in checks)
    short = rolls.verdict == REPRODUCED and fast.verdict == NOT_REPRODUCED
    return [rolls, *withhold([fast], LONGER_RUNS if short else "")]


def w8(evidence: Evidence) -> list[Check]:
    """Flows between one and two layers: their drift, and V over that of the next deeper flow.

    The ends of the range are reported, and so is the least depth of a steady flow.
    """
    flows = select_replicated(base_flows(evidence))
    thin = {n: place for n, place in flows.items() if SLOWEST_DEPTHS[0] <= n <= SLOWEST_DEPTHS[1]}
    thin = {n: place for n, place in thin.items() if place["average"] >= MIN_AVERAGE}
    between = [n for n in thin if SLOWEST_DEPTHS[0] < n < SLOWEST_DEPTHS[1]]
    deep = min((n for n in flows if n >= MIN_FASTER_DEPTH), default=None)
    if len(between) < 2 or deep is None:
        raise Untestable(
            "fewer than two flows with 1 < n < 2, replicates and 100 √(σ/g), or none with n ≥ 2.5"
        )
    checks = []
    for n, place in thin.items():
        drift = acceleration(place)
        steady = within(
            f"dV/dt over g sin θ, n = {n:g}", drift, -MAX_ACCELERATION, MAX_ACCELERATION, [place]
        )
        ratio, pair = quotient(place.velocity, flows[deep].velocity), [place, flows[deep]]
        slower = below(f"V at n = {n:g} over that at n = {deep:g}", ratio, 1, pair)
        pair_checks = [waive_samples(steady, place), slower]
        checks += pair_checks if n in between else remove_votes(pair_checks)
    least = _boundary(evidence, "acceleration", "depth", any_protocol=True)
    if least is not None:
        checks.append(reported("least depth of a steady flow", least))
    return checks


def _boundary(
    evidence: Evidence, of: str, along: str, any_protocol: bool = False, **where: float
) -> UFloat | None:
    """Return a boundary; none if it was never searched.

    The interval is infinite where a start has no boundary in the range.
    """
    try:
        return evidence.boundary("chute", of, along, seeds=True, any_protocol=any_protocol, **where)
    except Unbounded:
        return with_interval(nan, inf)
    except Untestable:
        return None


def w19(evidence: Evidence, max_slope: float) -> list[Check]:
    """Flows over a sweep of friction: steady a little above tan θ (a), at rest beyond twice (b).

    The velocity of a steady flow changes by less than ``max_slope`` times g sin θ. Whether flows
    come to rest is judged after slow starts (`SLOW_STARTS`); fast starts are reported.
    """
    return judge_parts(
        a=lambda: _check_steady_above(evidence, max_slope),
        b=lambda: _check_arrested_beyond(evidence),
    )


def _check_steady_above(evidence: Evidence, max_slope: float) -> list[Check]:
    """Check the mean slope of all replicates per depth, pooled over frictions just above tan θ."""
    checks, has_sweep = [], False
    for n in SWEEP_DEPTHS:
        flows = [
            place
            for mu, place in _sweep(evidence, n).items()
            if 1 < mu <= SOMEWHAT_ABOVE and place.completed > 1
        ]
        if not flows:
            continue
        has_sweep |= len(flows) > 1
        pooled = sum(map(acceleration, flows)) / len(flows)
        quantity = f"dV/dt over g sin θ, {len(flows)} frictions, n = {n:g}"
        stopped = [place for place in flows if not is_flowing(place)]
        check = within(quantity, pooled, -max_slope, max_slope, flows)
        checks += withhold([check], f"{len(stopped)} of them do not move" if stopped else "")
    if not has_sweep:
        raise Untestable("no depth with replicates at two frictions from 1 to 1.5 tan θ")
    return checks


def _check_arrested_beyond(evidence: Evidence) -> list[Check]:
    """Check, by initial velocity, that flows much rougher than the slope come to rest."""
    slow: list[Check] = []
    usual: list[Check] = []
    for n in SWEEP_DEPTHS:
        for start in SLOW_STARTS:
            sweep = _sweep(evidence, n, initial_velocity=start)
            rough = [place for mu, place in sweep.items() if mu > GREATLY_ABOVE]
            slow += [_check_arrested(place) for place in rough]
            usual += chain.from_iterable(map(_report_rest_time, rough))
        sweep = _sweep(evidence, n)
        usual += [_check_arrested(place) for mu, place in sweep.items() if mu > GREATLY_ABOVE]
    if not slow and not usual:
        raise Untestable("no flow beyond twice tan θ")
    return [*slow, *remove_votes(usual)]


def _sweep(evidence: Evidence, depth: float, **where: float) -> dict[float, Place]:
    """Return the flows of a depth by their friction over tan θ."""
    line = evidence.line("chute", "friction", depth=depth, cell=CELLS[depth], **where)
    return {mu / tan(radians(place["angle"])): place for mu, place in line.items()}


def _check_arrested(place: Place) -> Check:
    """Return the check that a flow has come to rest.

    In that regime V/√(gσ) stays below 1e-3 over half of the window, which is 50 √(σ/g) at least. A
    flow that moves without much change fails. One that slows is undecided, and so is one whose
    replicates disagree.
    """
    rests, regimes = nan, set(place.values("regime"))
    if place["average"] >= MIN_AVERAGE and regimes == {"arrested"}:
        rests = 1.0
    elif "arrested" not in regimes and (regimes == {"accelerating"} or not reason_unsettled(place)):
        rests = 0.0
    return above(f"at rest (1) or not (0), {_rough_label(place)}", rests, 0.5, [place])


def _rough_label(place: Place) -> str:
    """Return the label of a flow of the sweeps over friction."""
    return f"μ = {place['friction']:g}, n = {place['depth']:g}, V0 = {place['initial_velocity']:g}"


def _report_rest_time(place: Place) -> list[Check]:
    """Report the time, in √(σ/g), until a flow was at rest; no check for one that moves."""
    if place.regime != "arrested":
        return []
    try:
        rest_time = replicate_mean(place.values("transient_end")) / (
            natural_speed(place) / place["gravity"]
        )
    except Untestable:
        return []
    return [reported(f"time until at rest, {_rough_label(place)}", rest_time, [place], "√(σ/g)")]


def w23(evidence: Evidence, margin: float) -> list[Check]:
    """Velocities after slower and faster starts equal that after the nearest one within ``margin``.

    The nearest start is the one closest to the velocity it led to. The states of deep flows are
    reported by their start.
    """
    checks, missing = [], []
    for n in START_DEPTHS:
        line = evidence.line("chute", "initial_velocity", depth=n, cell=CELLS[n])
        near = _nearest_start(line)
        if near is None:
            missing.append(f"{n:g}")
            continue
        steady = line.pop(near)
        reached = steady.velocity.nominal_value / natural_speed(steady)
        relative = {start: start / reached for start in line}
        ends = min(relative.values(), default=inf), max(relative.values(), default=0)
        if abs(near / reached - 1) > NEAR_TOLERANCE or ends[0] > MAX_SLOW or ends[1] < MIN_FAST:
            missing.append(f"{n:g}")
            continue
        for start, place in line.items():
            ratio = quotient(place.velocity, steady.velocity)
            quantity = f"V after a start at {relative[start]:.2g} V, n = {n:g}, over the usual V"
            bounds = 1 - margin, 1 + margin
            pair = [place, steady]
            # A flow that has come to rest has not forgotten its start.
            moving = [flow for flow in pair if is_flowing(flow)]
            checks += withhold_unsettled([within(quantity, ratio, *bounds, pair)], moving)
    if missing:
        raise Untestable(f"no starts at V, half and twice of it at n = {', '.join(missing)}")
    return [*checks, *chain.from_iterable(_report_start_states(evidence, n) for n in STATE_DEPTHS)]


def _report_start_states(evidence: Evidence, depth: float) -> list[Check]:
    """Report the states of a deep flow by its start."""
    line = evidence.line("chute", "initial_velocity", depth=depth, cell=CELLS[depth])
    reports = []
    for start, place in line.items():
        try:
            reports += report_states(f"start at {start:g} √(gσ), n = {depth:g}", [place])
        except Untestable:
            continue
    return reports


def _nearest_start(line: Mapping[float, Place]) -> float | None:
    """Return the start (√(gσ)) nearest to the velocity it led to, of settled flows if any."""

    def distance(start: float) -> tuple[bool, float]:
        place = line[start]
        reached = place.velocity.nominal_value / natural_speed(place)
        return bool(reason_unsettled(place)), abs(start / reached - 1)

    return min((start for start in line if is_flowing(line[start])), key=distance, default=None)


def w25(evidence: Evidence, min_width: float) -> list[Check]:
    """The window between angles at which flows rest and run away exceeds ``min_width`` (degrees).

    The narrowest window of any seed decides. Its ends are the inner ones of the brackets: flows
    move at the lower end, and do not accelerate at the upper one.
    """
    checks, missing = [], []
    for n in ANGLE_DEPTHS:
        try:
            runaway, rest = (
                evidence.brackets("chute", of, "angle", depth=n) for of in ("acceleration", "flow")
            )
        except Untestable:
            if n in REQUIRED_DEPTHS:
                missing.append(f"{n:g}")
            continue
        width = (runaway["low"] - rest["high"]).dropna()
        quantity = f"narrowest window of {len(width)} seeds, n = {n:g}"
        check = above(quantity, float(width.min()), min_width, unit="°")
        has_seeds = len(width) == len(runaway) > 1
        checks += withhold([check], "" if has_seeds else "limits from two seeds or more")
    if missing:
        raise Untestable(f"no bounds of the angle of steady flow at n = {', '.join(missing)}")
    return checks
