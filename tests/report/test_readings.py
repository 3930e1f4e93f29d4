"""The table of readings: claims that hold under each, and whether it bears the published step."""

import pytest

from sim.report.claims import reading_tables
from tests.made.results import made_point, made_results


def flow(missing: float, **parameters):
    return made_point("belt", {"velocity": 0.05, "missing_energy": missing}, **parameters)


def claim(name: str, default: str, reduced: str) -> dict:
    by_reading = {"default": default, "damping_mass reduced": reduced}
    shared = {"title": "A claim", "paper": "gallas", "kind": "flow"}
    return shared | {"id": name, "by_reading": by_reading}


CLAIMS = [
    claim("G1", "not reproduced", "reproduced"),
    claim("G2", "reproduced in part", "untestable"),
]


@pytest.fixture
def table():
    results = made_results(
        flow(2e3, frequency=10),
        flow(1e-5, frequency=80),
        flow(0.5, frequency=10, protocol="converged"),
        flow(5e-5, frequency=10, damping_mass="reduced"),
    )
    (found,) = reading_tables(CLAIMS, results)
    return found


def test_claims_that_hold_are_counted_under_each_reading(table):
    counts = {one["words"]: (one["hold"], one["tested"]) for one in table["readings"]}
    assert counts == {"default": (1, 2), "damping_mass reduced": (1, 1)}
    assert [row["id"] for row in table["rows"]] == ["G1"]


def test_a_reading_is_compared_with_the_headline_over_the_claims_that_both_test(table):
    _, reduced = table["readings"]
    assert (reduced["common"], reduced["common_hold"], reduced["headline_hold"]) == (1, 1, 0)


def test_no_step_is_called_stable_where_no_bound_of_it_is_known():
    by_reading = {"default": "reproduced", "friction_cap after": "reproduced"}
    shared = {"id": "W1", "title": "A claim", "paper": "walton", "kind": "flow"}
    quantities = {"velocity": 0.1, "missing_energy": 1e-5}
    results = made_results(
        made_point("chute", quantities), made_point("chute", quantities, friction_cap="after")
    )
    (found,) = reading_tables([shared | {"by_reading": by_reading}], results)
    assert [(one["points"], one["stable"]) for one in found["readings"]] == [(1, None), (1, None)]


def test_the_published_step_is_looked_at_by_theory_and_by_energy(table):
    default, reduced = table["readings"]
    assert (default["points"], default["stable"], default["sound"]) == (2, 1, 1)
    assert default["missing"] == pytest.approx(2e3, rel=0.01)
    assert (reduced["points"], reduced["stable"], reduced["sound"]) == (1, 1, 1)


def test_a_reading_says_which_words_leave_it_open(table):
    assert [bool(one["sentences"]) for one in table["readings"]] == [False, True]
    assert [one["is_headline"] for one in table["readings"]] == [True, False]
