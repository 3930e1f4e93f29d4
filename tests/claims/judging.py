"""What tests of judges share: the verdict on made-up points."""

from sim.claims.evidence import Evidence
from sim.claims.verdict import NOT_REPRODUCED, together
from tests.made.results import headline_number, made_results


def checks_on(judge, points, boundaries=()) -> list:
    """What a judge checks on points of the published protocol."""
    return judge(
        Evidence(made_results(*points, boundaries=boundaries), "published"), *headline_number(judge)
    )


def verdict_on(judge, points, boundaries=()) -> str:
    """The verdict of a judge on points of the published protocol."""
    return together(checks_on(judge, points, boundaries))


def by_part(checks) -> dict[str, str]:
    """The verdict on each part of a claim."""
    names = dict.fromkeys(check.part for check in checks)
    return {name: together(check for check in checks if check.part == name) for name in names}


def failed(checks) -> list[str]:
    """What was not reproduced."""
    return [check.what for check in checks if check.verdict == NOT_REPRODUCED]
