"""Judges on made-up points: their checks and verdicts."""

from collections.abc import Callable, Iterable, Mapping, Sequence

from sim.claims.claim import claims
from sim.claims.evidence import Evidence
from sim.claims.place import Points
from sim.claims.verdict import NOT_REPRODUCED, Check, Untestable, combined_verdict
from sim.study.papers import papers
from tests.made.results import MadePoint, made_results


def headline_bounds(judge: Callable) -> dict[str, object]:
    """Return the bounds of a judge's claim, those of a partial function replaced."""
    function, others = getattr(judge, "func", judge), getattr(judge, "keywords", {})
    (bounds,) = (claim.bounds_at() for claim in claims() if claim.judge is function)
    return bounds | others


def checks_of(
    judge: Callable[..., list[Check]],
    points: Sequence[MadePoint],
    boundaries: Sequence[Mapping[str, object]] = (),
    protocol: str = "published",
) -> list[Check]:
    """Return the checks of a judge on made-up points."""
    results = made_results(*points, boundaries=boundaries)
    (paper,) = (claim.paper for claim in claims() if claim.judge is getattr(judge, "func", judge))
    evidence = Evidence(results, protocol, points=Points(results, papers()[paper]))
    return judge(evidence, **headline_bounds(judge))


def verdict_of(judge: Callable, points: Sequence[MadePoint], *args: object, **rest: object) -> str:
    """Return the verdict of a judge on made-up points; arguments are those of `checks_of`."""
    return combined_verdict(checks_of(judge, points, *args, **rest))


def by_part(checks: Sequence[Check]) -> dict[str, str]:
    """Return the verdict on each part of a claim that any check votes on."""
    votes = [check for check in checks if check.has_vote]
    names = dict.fromkeys(check.part for check in votes)
    return {
        name: combined_verdict(check for check in votes if check.part == name) for name in names
    }


def letters(judge: Callable, world: Sequence | tuple[Sequence, Sequence]) -> str:
    """Return the parts of a claim with R, N or I, as reproduced or not; "-" without a verdict.

    A world is made-up points, or points and boundaries.
    """
    points, boundaries = world if isinstance(world, tuple) else (world, ())
    try:
        verdicts = by_part(checks_of(judge, points, boundaries))
    except Untestable:
        return "-"
    return " ".join(f"{part}{verdict[0].upper()}" for part, verdict in verdicts.items())


def failed_quantities(checks: Iterable[Check]) -> list[str]:
    """Return the quantities that were not reproduced."""
    return [check.what for check in checks if check.verdict == NOT_REPRODUCED]
