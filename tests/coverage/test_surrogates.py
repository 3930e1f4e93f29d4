"""Intervals of surrogates hold the truth in 90 % of places or more, or there is no answer."""

import pytest

from tests.coverage.surrogates import CASES, row_of


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.name}, {case.points} points")
def test_intervals_hold_the_truth(case):
    row = row_of(case)
    assert not row.held.size or row.held.mean() > 0.9
    assert not row.noisy.size or not callable(case.noise) or row.noisy.mean() > 0.9


def test_too_few_points_of_many_give_no_answer():
    (case,) = (one for one in CASES if one.name.startswith("4 of 48"))
    assert not row_of(case, 2).held.size
