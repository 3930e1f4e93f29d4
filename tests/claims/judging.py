"""Helpers for tests of judges: the verdict on synthetic points."""

from unittest import mock

from sim.claims.claim import claims
from sim.claims.evidence import Evidence
from sim.claims.judge import judge as judge_claims
from sim.claims.judgement import Judgement
from sim.claims.verdict import NOT_REPRODUCED, combined_verdict
from tests.made.results import headline_bounds, made_results


def checks_on(judge, points, boundaries=()) -> list:
    """Return the checks of a judge on points of the published protocol."""
    results = made_results(*points, boundaries=boundaries)
    return judge(Evidence(results, "published"), **headline_bounds(judge))


def verdict_on(judge, points, boundaries=()) -> str:
    """Return the verdict of a judge on points of the published protocol."""
    return combined_verdict(checks_on(judge, points, boundaries))


def judgement_of(name: str, points) -> Judgement:
    """Return the judgement on a claim under all protocols and readings of points."""
    (claim,) = (claim for claim in claims() if claim.id == name)
    with mock.patch("sim.claims.judge.claims", return_value=[claim]):
        (judgement,) = judge_claims(made_results(*points))
    return judgement


def by_part(checks) -> dict[str, str]:
    """Return the verdict on each part of a claim that any check votes on."""
    votes = [check for check in checks if check.has_vote]
    names = dict.fromkeys(check.part for check in votes)
    return {
        name: combined_verdict(check for check in votes if check.part == name) for name in names
    }


def failed_quantities(checks) -> list[str]:
    """Return the quantities that were not reproduced."""
    return [check.what for check in checks if check.verdict == NOT_REPRODUCED]
