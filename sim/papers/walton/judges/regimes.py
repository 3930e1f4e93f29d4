"""Judges of Walton's claims about regimes: flows that accelerate, are steady, come to rest."""

from contextlib import suppress
from dataclasses import replace
from math import inf, nan, radians, tan

from sim.base.statistics import MANY, student
from sim.claims.checks import (
    Numbers,
    Pair,
    above,
    at_least,
    below,
    judge_parts,
    remove_votes,
    reported,
    withhold,
    within,
)
from sim.claims.claim import fill
from sim.claims.evidence import ANY, Evidence
from sim.claims.inference import reported_share, share_above
from sim.claims.place import Place, quotient, replicate_mean, select_replicated, with_interval
from sim.claims.verdict import LONGER_RUNS, NOT_REPRODUCED, REPRODUCED, Check, Unbounded, Untestable
from sim.papers.walton.judges.chute import (
    CELLS,
    acceleration,
    base_flows,
    driving_acceleration,
    is_flowing,
    natural_speed,
    reason_unsettled,
    waive_samples,
)

#: Depths of the sweeps over friction.
SWEEP_DEPTHS = (1.24, 2.5, 5, 10, 20)


def w6(
    evidence: Evidence, *, min_ratio: float, errors: float, frictions: Numbers, depths: Numbers
) -> list[Check]:
    """Accelerations below tan θ: against those of a sliding block, and some errors above zero.

    Flows at ``depths`` are needed at each of the frictions.
    """
    lines = {mu: evidence.line("chute", "depth", friction=mu, cell=ANY) for mu in frictions}
    missing = [f"{mu:g}" for mu, line in lines.items() if not line.keys() >= set(depths)]
    if missing:
        where = fill("n = {depths:and}", {"depths": depths})
        raise Untestable(f"no flows at {where} at friction {', '.join(missing)}")
    checks = []
    for mu, line in lines.items():
        for depth, place in line.items():
            gain, slope = acceleration(place), radians(place["angle"])
            block, label = 1 - mu / tan(slope), f"μ = {mu:g}, n = {depth:g}"
            quantity = f"dV/dt over that of a block, {label}"
            checks.append(waive_samples(above(quantity, gain / block, min_ratio, [place]), place))
            error = place.value(
                "acceleration", "acceleration_error"
            ).std_dev / driving_acceleration(place)
            # The one-sided bound, which decides, then lies at so many errors.
            wide = with_interval(
                gain.nominal_value, errors * error * student(MANY) / student(MANY, sides=1)
            )
            quantity = f"dV/dt over g sin θ within {errors} errors, {label}"
            checks.append(waive_samples(above(quantity, wide, 0, [place]), place))
    return checks


def w7(evidence: Evidence, *, max_deviation: float, min_speed: float) -> list[Check]:
    """The flow of half a layer: dV/dt against a sphere that rolls alone, and its velocity."""
    place = evidence.at("chute", depth=0.5)
    if place.completed < 2:
        raise Untestable("no flow at n = 0.5 that has replicates")
    speed = place.velocity / natural_speed(place)
    rolling, bounds = acceleration(place) / (5 / 7), (1 - max_deviation, 1 + max_deviation)
    checks = [
        within("dV/dt over (5/7) g sin θ, n = 0.5", rolling, *bounds, [place]),
        above("V at which it still does so, n = 0.5", speed, min_speed, [place], "√(gσ)"),
    ]
    if place.regime in ("undetermined", "mixed"):
        return withhold(checks, f"the flow is {place.regime}")
    # The velocity is the mean over the window, and the trend of the window decides. A flow that
    # still grows at too low a velocity needs a longer run; a plateau has another trend.
    rolls, fast = (waive_samples(check, place) for check in checks)
    short = rolls.verdict == REPRODUCED and fast.verdict == NOT_REPRODUCED
    return [rolls, *withhold([fast], LONGER_RUNS if short else "")]


def w8(
    evidence: Evidence,
    *,
    depths: Pair,
    max_acceleration: float,
    min_average: float,
    min_faster_depth: float,
) -> list[Check]:
    """Flows between two depths: their drift, and V over that of the next deeper flow.

    The ends of the range are reported, and so is the least depth of a steady flow.
    """
    flows = select_replicated(base_flows(evidence))
    low, high = depths
    thin = {n: place for n, place in flows.items() if low <= n <= high}
    thin = {n: place for n, place in thin.items() if place["average"] >= min_average}
    between = [n for n in thin if low < n < high]
    deep = min((n for n in flows if n >= min_faster_depth), default=None)
    if len(between) < 2 or deep is None:
        raise Untestable(
            f"fewer than two flows with {low} < n < {high}, replicates and {min_average} √(σ/g), "
            f"or none with n ≥ {min_faster_depth}"
        )
    checks = []
    for n, place in thin.items():
        drift = acceleration(place)
        steady = within(
            f"dV/dt over g sin θ, n = {n:g}", drift, -max_acceleration, max_acceleration, [place]
        )
        ratio, pair = quotient(place.velocity, flows[deep].velocity), [place, flows[deep]]
        slower = below(f"V at n = {n:g} over that at n = {deep:g}", ratio, 1, pair)
        pair_checks = [waive_samples(steady, place), slower]
        checks += pair_checks if n in between else remove_votes(pair_checks)
    # The interval is infinite where a start has no boundary in the range.
    least = with_interval(nan, inf)
    try:
        with suppress(Unbounded):
            least = evidence.boundary("chute", "acceleration", "depth", any_protocol=True)
    except Untestable:
        return checks
    return [*checks, reported("least depth of a steady flow", least)]


def w19(
    evidence: Evidence,
    *,
    max_slope: float,
    somewhat: float,
    greatly: Pair,
    starts: Numbers,
    min_rest: float,
    majority: float,
    variety: int,
) -> list[Check]:
    """Flows over a sweep of friction: steady a little above tan θ (a), at rest beyond twice (b).

    Frictions are multiples of tan θ, ``starts`` in √(gσ), ``min_rest`` in √(σ/g). Larger frictions
    and fast starts are reported.
    """
    return judge_parts(
        a=lambda: _check_steady_above(evidence, somewhat, max_slope, variety),
        b=lambda: _check_arrested_beyond(evidence, greatly, starts, min_rest, majority),
    )


def _check_steady_above(
    evidence: Evidence, somewhat: float, max_slope: float, variety: int
) -> list[Check]:
    """Check at how many depths flows are steady, all frictions just above tan θ of one together.

    The mean slope of their replicates tells it per depth, without a vote.
    """
    checks, has_sweep = [], False
    for n in SWEEP_DEPTHS:
        flows = [
            place
            for mu, place in _sweep(evidence, n).items()
            if 1 < mu <= somewhat and place.completed > 1
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
        raise Untestable(f"no depth with replicates at two frictions from 1 to {somewhat} tan θ")
    return [at_least("depths of steady flows", variety, checks), *remove_votes(checks)]


def _check_arrested_beyond(
    evidence: Evidence, greatly: Pair, starts: Numbers, min_rest: float, majority: float
) -> list[Check]:
    """Check that beds much rougher than the slope come to rest: one count over all slow starts."""
    least, most = greatly
    slow: list[Place] = []
    reports: list[Check] = []
    for n in SWEEP_DEPTHS:
        by_start = [(start, _sweep(evidence, n, initial_velocity=start)) for start in starts]
        for start, sweep in [*by_start, (None, _sweep(evidence, n))]:
            for place in (place for mu, place in sweep.items() if mu > least):
                reports += _report_rest(place, min_rest, start is not None)
                is_rough = place["friction"] > most * tan(radians(place["angle"]))
                slow += [place] if start is not None and not is_rough else []
    if not reports:
        raise Untestable(f"no flow beyond {least:g} tan θ")
    if not slow:
        return reports
    resting = sum(_resting_beds(place, min_rest) for place in slow)
    # A bed of a flow that still slows down may come to rest later.
    slowing = sum(
        place.completed - _resting_beds(place, min_rest) for place in slow if _may_stop(place)
    )
    number = sum(place.completed for place in slow)
    quantity = f"share of beds at rest, {least:g} to {most:g} tan θ, slow starts"
    check = share_above(quantity, resting, number, majority, slow)
    later = share_above(quantity, resting + slowing, number, majority, slow)
    return [replace(check, tested=(check.p_holds, later.p_fails), looks=0), *reports]


def _may_stop(place: Place) -> bool:
    """True where a flow that moves has not settled, unless it accelerates."""
    return place.regime != "accelerating" and LONGER_RUNS in reason_unsettled(place)


def _resting_beds(place: Place, min_rest: float) -> int:
    """Return how many beds have come to rest for ``min_rest`` (√(σ/g)) at least.

    In that regime V/√(gσ) stays below 1e-3 over half of the window.
    """
    is_long = place["average"] >= 2 * min_rest
    return int((place.values("regime") == "arrested").sum()) if is_long else 0


def _sweep(evidence: Evidence, depth: float, **where: float) -> dict[float, Place]:
    line = evidence.line("chute", "friction", depth=depth, cell=CELLS[depth], **where)
    return {mu / tan(radians(place["angle"])): place for mu, place in line.items()}


def _report_rest(place: Place, min_rest: float, with_time: bool) -> list[Check]:
    """Report how many beds are at rest, and the time, in √(σ/g), until a whole flow was."""
    settings = (place[name] for name in ("friction", "depth", "initial_velocity"))
    label = "μ = {:g}, n = {:g}, V0 = {:g}".format(*settings)
    resting = _resting_beds(place, min_rest)
    checks = [reported_share(f"beds at rest, {label}", resting, place.completed, [place])]
    if with_time and place.regime == "arrested":
        with suppress(Untestable):
            unit = natural_speed(place) / place["gravity"]
            time = replicate_mean(place.values("transient_end")) / unit
            checks.append(reported(f"time until at rest, {label}", time, [place], "√(σ/g)"))
    return checks


def w25(evidence: Evidence, *, min_width: float, required: Numbers, depth: float) -> list[Check]:
    """The window between angles at which flows rest and run away exceeds ``min_width`` (degrees).

    It is needed at the ``required`` depths, and judged at one more where it was searched.
    """
    checks, missing = [], []
    for n in (*required, depth):
        try:
            runaway, rest = (
                evidence.brackets("chute", of, "angle", depth=n) for of in ("acceleration", "flow")
            )
        except Untestable:
            if n in required:
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
