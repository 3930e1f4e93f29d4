"""Helpers for tests of judges: the verdict on synthetic points."""

from sim.claims.evidence import Evidence
from sim.claims.verdict import NOT_REPRODUCED, combined_verdict
from tests.made.results import headline_bounds, made_results


def checks_on(judge, points, boundaries=()) -> list:
    """Return the checks of a judge on points of the published protocol."""
    results = made_results(*points, boundaries=boundaries)
    return judge(Evidence(results, "published"), **headline_bounds(judge))


def verdict_on(judge, points, boundaries=()) -> str:
    """Return the verdict of a judge on points of the published protocol."""
    return combined_verdict(checks_on(judge, points, boundaries))


def by_part(checks) -> dict[str, str]:
    """Return the verdict on each part of a claim."""
    names = dict.fromkeys(check.part for check in checks)
    return {
        name: combined_verdict(check for check in checks if check.part == name) for name in names
    }


def failed_quantities(checks) -> list[str]:
    """Return the quantities that were not reproduced."""
    return [check.what for check in checks if check.verdict == NOT_REPRODUCED]
