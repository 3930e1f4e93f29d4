"""How often the judge is right on synthetic flows; `python -m benchmarks.judging` has the table."""

import numpy as np
import pytest

from benchmarks.judging import (
    KINDS,
    STATEMENTS,
    half_width,
    often,
    rates,
    several,
    steadiness,
    tightening,
)

#: What is wrong by more than chance of so many trials is wrong.
FEW, MANY = 25, 400


def at_most(share: float, trials: int) -> float:
    """Return the rate that one of a thousand sets of trials exceeds by chance."""
    return share + 3.1 * np.sqrt(share * (1 - share) / trials)


@pytest.mark.parametrize("statement", ["bound", "trend"])
def test_what_is_true_by_two_half_widths_holds_and_what_is_false_does_not(statement):
    held, failed = rates(statement, "correlated", 3, 2, FEW)
    assert held >= 0.8 and failed <= at_most(0.05, FEW)
    held, _ = rates(statement, "correlated", 3, 0, FEW)
    assert held <= at_most(0.05, FEW)


def test_more_replicates_tighten_an_interval_as_one_over_their_root():
    rng = np.random.default_rng(1)
    wide, narrow = (half_width(rng, KINDS["stationary"], number) for number in (4, 16))
    # Four times as many, and Student's factors of 3 and 15 degrees of freedom.
    assert narrow / wide == pytest.approx(0.5 * 2.13 / 3.18, abs=0.12)


def test_a_claim_of_many_votes_needs_all_and_fails_with_one():
    assert several(3, 3, 3, 4, 10)[0] >= 0.8
    assert several(3, 3, -3, 4, 10) == (0.0, pytest.approx(1.0, abs=0.2))


def test_steady_flows_are_steady_and_others_not():
    assert steadiness(0.0, 8, FEW)[0] >= 0.8
    assert steadiness(0.01, 8, FEW)[0] <= at_most(0.05, FEW)
    assert steadiness(0.03, 8, FEW)[1] >= 0.8


def test_a_share_of_half_is_not_often():
    held, failed = often(0.5, 20, 400)
    assert max(held, failed) <= at_most(0.05, 400)
    assert often(0.9, 20, 200)[0] >= 0.8


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
@pytest.mark.parametrize("replicates", [3, 8])
def test_rates_of_all_statements_on_all_flows(statement, kind, replicates):
    held, failed = rates(statement, kind, replicates, 2, MANY)
    # An equality of flows in several states is nowhere so far from its margin.
    assert np.isnan(held) or (held >= 0.8 and failed <= at_most(0.05, MANY))
    for distance in (0, -1):
        held, _ = rates(statement, kind, replicates, distance, MANY)
        assert held <= at_most(0.05, MANY)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
def test_more_replicates_never_make_a_verdict_worse(statement, kind):
    held = np.array(tightening(statement, kind, (3, 6, 12, 24, 48), 100))
    if np.isnan(held).all():
        assert (statement, kind) == ("equality", "two states")
        return
    # What hundred trials may scatter.
    assert (np.diff(held) > -0.1).all() and held[-1] > 0.9
