"""Checks: verdicts from a value, its interval, its thresholds and its samples."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from scipy.special import stdtrit
from uncertainties import ufloat

from benchmarks.judging import (
    KINDS,
    STATEMENTS,
    dependence_rate,
    look_rates,
    majority_rates,
    order_rates,
    rates,
    rates_by_replicates,
    steadiness,
)
from sim.claims.checks import above, below, within
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPORTED,
    REPRODUCED,
    REPRODUCED_IN_PART,
    Check,
    combined_verdict,
    plan,
    verdict_of_parts,
)


@pytest.mark.parametrize(
    ("value", "half_width", "verdict"),
    [
        (2.0, 0.5, REPRODUCED),
        (1.8, 1.0, INCONCLUSIVE),
        (1.2, 0.3, INCONCLUSIVE),
        # A bound of one side is nearer than the end of an interval of two.
        (1.9, 1.0, REPRODUCED),
        (0.1, 1.0, NOT_REPRODUCED),
        (0.5, 0.4, NOT_REPRODUCED),
        (0.5, 0.5, NOT_REPRODUCED),
        (1.0, 0.0, NOT_REPRODUCED),
        (nan, 0.1, INCONCLUSIVE),
        (2.0, inf, INCONCLUSIVE),
    ],
)
def test_an_interval_clear_of_the_threshold_decides(value, half_width, verdict):
    assert Check("x", value, half_width, 1.0, inf).verdict == verdict
    assert Check("x", -value, half_width, -inf, -1.0).verdict == verdict


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(0.0, REPRODUCED), (0.95, INCONCLUSIVE), (0.91, REPRODUCED), (-1.2, NOT_REPRODUCED)],
)
def test_two_thresholds(value, verdict):
    assert Check("x", value, 0.1, -1.0, 1.0).verdict == verdict


@pytest.mark.parametrize("samples", [0, 7, nan])
def test_too_few_samples_decide_nothing(samples):
    assert Check("x", 2.0, 0.1, 1.0, inf, samples=samples).verdict == INCONCLUSIVE


def test_helpers_turn_standard_deviations_into_intervals():
    measured = ufloat(2.0, 0.25)
    assert above("x", measured, 1.0).half_width == pytest.approx(0.49)
    assert above("x", measured, 1.0).verdict == below("x", measured, 3.0).verdict == REPRODUCED
    assert within("x", measured, 1.0, 2.2).verdict == INCONCLUSIVE
    assert within("x", measured, 1.0, 2.45).verdict == REPRODUCED
    assert below("x", 2, 1.5).verdict == NOT_REPRODUCED


HOLDS, FAILS, OPEN = (Check("x", value, 0.1, 0.0, 1.0) for value in (0.5, 2.0, 1.0))
BARELY = Check("x", 1.09, 0.1, 0.0, 1.0)
CLEARLY = Check("x", 1.3, 0.1, 0.0, 1.0)
REPORT = Check("x", 1.0, inf, -inf, inf)


@pytest.mark.parametrize(
    ("checks", "verdict"),
    [
        ([HOLDS, HOLDS], REPRODUCED),
        ([HOLDS, OPEN], INCONCLUSIVE),
        ([HOLDS, OPEN, FAILS], NOT_REPRODUCED),
        ([HOLDS, REPORT], REPRODUCED),
        ([BARELY], NOT_REPRODUCED),
        ([BARELY, *[HOLDS] * 9], INCONCLUSIVE),
        ([CLEARLY, *[HOLDS] * 9], NOT_REPRODUCED),
        ([replace(CLEARLY, freedom=1), *[HOLDS] * 9], INCONCLUSIVE),
        ([REPORT], INCONCLUSIVE),
        ([], INCONCLUSIVE),
    ],
)
def test_all_checks_must_hold_and_one_must_fail_as_one_of_so_many(checks, verdict):
    assert combined_verdict(checks) == verdict


@pytest.mark.parametrize(
    "silent", [replace(CLEARLY, votes=False), replace(CLEARLY, withheld="too young")]
)
def test_what_has_no_vote_fails_nothing(silent):
    assert combined_verdict([HOLDS, silent]) == (INCONCLUSIVE if silent.withheld else REPRODUCED)
    assert silent.verdict == (INCONCLUSIVE if silent.withheld else REPORTED)


def test_a_failure_is_clear_among_all_votes_the_withheld_ones_included():
    fails = Check("x", 1, nan, 0, inf, tested=(0.96, 0.04))
    assert combined_verdict([fails]) == NOT_REPRODUCED
    assert combined_verdict([fails, replace(HOLDS, votes=False)]) == NOT_REPRODUCED
    assert combined_verdict([fails, replace(HOLDS, withheld="too young")]) == INCONCLUSIVE


@pytest.mark.parametrize("looks", [0, 1, 2, 5])
def test_bound_and_replicates_are_those_that_decide_at_a_look(looks):
    check = Check("x", 1.0, 0.2, 0, inf, looks=looks)
    for factor, verdict in ((1.02, REPRODUCED), (0.98, INCONCLUSIVE)):
        assert replace(check, low=1 - factor * check.bound).verdict == verdict
    undecided = replace(check, low=1 - 0.5 * check.bound)
    replicates = undecided.replicate_factor
    for factor, verdict in ((1.04, REPRODUCED), (0.96, INCONCLUSIVE)):
        half_width = 0.2 / np.sqrt(factor * replicates)
        later = replace(undecided, half_width=half_width, looks=looks and looks + 1)
        assert later.verdict == verdict


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(
    ("p_values", "verdict"),
    [
        ([0.03, 0.5], INCONCLUSIVE),
        ([0.02, 0.5], REPRODUCED_IN_PART),
        ([0.02, 0.5, 0.6], INCONCLUSIVE),
        ([0.01, 0.5, 0.6], REPRODUCED_IN_PART),
        ([0.03, 0.04], REPRODUCED),
        ([0.5, 0.6], INCONCLUSIVE),
    ],
)
def test_that_one_part_holds_is_clear_among_all_parts(p_values, verdict, order):
    parts = [[Check("x", 1, nan, 0, inf, tested=(p, 1 - p))] for p in p_values[::order]]
    assert verdict_of_parts(parts) == verdict


def test_p_values_are_those_of_one_sided_tests():
    """Two standard errors from the threshold, 1 - Φ(2) = 0.02275."""
    check = Check("x", 1.0, 0.5 * 1.959964, 0.0, inf)
    assert check.p_holds == pytest.approx(0.02275, abs=1e-5)
    assert check.p_fails == pytest.approx(1 - 0.02275, abs=1e-5)
    assert check.bound == pytest.approx(0.5 * 1.644854)


@pytest.mark.parametrize(
    ("check", "text"),
    [
        (HOLDS, ""),
        (replace(OPEN, withheld="longer runs"), "longer runs"),
        (replace(OPEN, samples=1), "more independent samples: longer runs or more replicates"),
        (OPEN, "no number of replicates: the value lies on the threshold"),
        # The bound is 0.0839 wide; at a distance of 0.04 it must be half as wide.
        (replace(OPEN, value=0.96), "about 5 times the replicates"),
        (Check("τ", 0.3, nan, 0.0, inf, tested=(0.2, 0.8)), "about 4 times the replicates"),
    ],
)
def test_what_would_decide_an_open_check_is_told(check, text):
    assert plan(check) == text


def test_few_replicates_seldom_fail_by_chance_however_many_checks_there_are():
    """Of twenty quantities that are all at the edge, one in twenty claims fails at most."""
    rng, claims = np.random.default_rng(5), 400
    values = rng.normal(size=(claims, 20, 3))
    means, errors = values.mean(axis=2), values.std(axis=2, ddof=1) / np.sqrt(3)
    widths = stdtrit(2, 0.975) * errors
    failures = 0
    for mean, width in zip(means, widths, strict=True):
        pairs = zip(mean, width, strict=True)
        checks = [
            Check("x", value, half_width, 0.0, inf, freedom=2.0) for value, half_width in pairs
        ]
        failures += combined_verdict(checks) == NOT_REPRODUCED
    # One in twenty, and what 400 claims may scatter.
    assert failures / claims < 0.05 + 2 * np.sqrt(0.05 * 0.95 / claims)


#: Trials per rate; a rate must lie within the scatter of so many trials.
FEW, MANY = 25, 400


def at_most(share: float, trials: int) -> float:
    """Return the rate that one of a thousand sets of trials exceeds by chance."""
    return share + 3.1 * np.sqrt(share * (1 - share) / trials)


def test_what_is_true_by_two_half_widths_holds_and_what_is_false_does_not():
    reproduced, not_reproduced = rates("bound", "correlated", 3, 2, FEW)
    assert reproduced >= 0.8 and not_reproduced <= at_most(0.05, FEW)
    reproduced, _ = rates("bound", "correlated", 3, 0, FEW)
    assert reproduced <= at_most(0.05, FEW)


def test_a_claim_depends_on_readings_that_differ_and_hardly_on_others():
    """Two readings three half widths apart are noticed, and ten on one threshold are not."""
    assert dependence_rate(10, 0, 0, MANY) <= at_most(0.05, MANY)
    assert 1 - dependence_rate(2, 1.5, -1.5, MANY) <= at_most(0.2, MANY)


def test_a_transient_of_a_reading_makes_nothing_depend_on_it():
    """Unless its converged runs leave open what they say."""
    assert dependence_rate(2, 1.5, 1.5, MANY, transient=-1.5) <= at_most(0.1, MANY)
    assert dependence_rate(2, 1.5, 0, MANY, transient=-1.5) > 0.7


def test_an_order_forgives_a_margin_and_no_more():
    """A reversal by the margin itself is open, however often it is looked at."""
    assert order_rates(0, 1, FEW)[0] >= 0.8 and order_rates(0.1, 4, FEW)[1] >= 0.8
    assert sum(order_rates(0.05, 4, 2 * FEW)) <= at_most(0.05, 2 * FEW)


def test_looking_again_until_chance_decides_has_its_price():
    """On its threshold a value is open: whatever the judge says of it is wrong."""
    assert sum(look_rates(9, 0, False, MANY)) > 0.1
    assert sum(look_rates(9, 0, True, MANY)) <= at_most(0.05, MANY)
    held, failed = look_rates(9, 2, True, MANY)
    assert held > 0.95 and failed == 0


def test_steady_flows_are_steady_and_others_not():
    assert steadiness(0.0, 8, FEW)[0] >= 0.8
    assert steadiness(0.01, 8, FEW)[0] <= at_most(0.05, FEW)
    assert steadiness(0.03, 8, FEW)[1] >= 0.8


def test_a_share_of_half_is_not_often():
    reproduced, not_reproduced = majority_rates(0.5, 20, 400)
    assert max(reproduced, not_reproduced) <= at_most(0.05, 400)
    assert majority_rates(0.9, 20, 200)[0] >= 0.8


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
@pytest.mark.parametrize("replicates", [3, 8])
def test_rates_of_all_statements_on_all_flows(statement, kind, replicates):
    reproduced, not_reproduced = rates(statement, kind, replicates, 2, MANY)
    # An equality of flows in several states is nowhere so far from its margin.
    assert np.isnan(reproduced) or (reproduced >= 0.8 and not_reproduced <= at_most(0.05, MANY))
    for distance in (0, -1):
        reproduced, _ = rates(statement, kind, replicates, distance, MANY)
        assert reproduced <= at_most(0.05, MANY)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
def test_more_replicates_never_make_a_verdict_worse(statement, kind):
    reproduced = np.array(rates_by_replicates(statement, kind, (3, 6, 12, 24, 48), 100))
    if np.isnan(reproduced).all():
        assert (statement, kind) == ("equality", "two states")
        return
    # What hundred trials may scatter.
    assert (np.diff(reproduced) > -0.1).all() and reproduced[-1] > 0.9
