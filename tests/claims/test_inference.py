"""Statements without an interval and about many quantities: trends, ranks, shares, error rates."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from benchmarks.judging import (
    KINDS,
    STATEMENTS,
    half_width,
    joint_rates,
    look_rates,
    majority_rates,
    rates,
    rates_by_replicates,
    steadiness,
)
from sim.claims.inference import mann_whitney_p, outranks, share_above, share_interval, trend
from sim.claims.trends import mean_of_others, smallest_mean
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, RISK, holm_p
from tests.made.results import spread


def groups(*means, replicates=5, scatter=0.1):
    """Return replicates about several means."""
    return [mean + scatter * spread(replicates) for mean in means]


def test_the_trend_is_jonckheeres():
    """Jonckheere's statistic counts pairs in order; its normal p-value is that of Kendall's τ."""
    rng = np.random.default_rng(4)
    samples = [rng.normal(size=n) + 0.3 * k for k, n in enumerate((4, 6, 5, 3))]
    pairs = [
        (a, b)
        for i, first in enumerate(samples)
        for second in samples[i + 1 :]
        for a in first
        for b in second
    ]
    rising = sum(b > a for a, b in pairs)
    sizes, total = np.array([len(first) for first in samples]), sum(map(len, samples))
    variance = (total**2 * (2 * total + 3) - (sizes**2 * (2 * sizes + 3)).sum()) / 72
    z = (rising - len(pairs) / 2) / np.sqrt(variance)
    assert trend("x", [samples]).p_holds == pytest.approx(stats.norm.sf(z), rel=1e-6)


@pytest.mark.parametrize(
    ("means", "verdict"),
    [
        ((1, 2, 3), REPRODUCED),
        ((3, 2, 1), NOT_REPRODUCED),
        ((1, 1, 1), INCONCLUSIVE),
        # A dip in a trend.
        ((1, 2, 1.9, 3, 4), REPRODUCED),
    ],
)
def test_a_trend_is_one_of_all_groups(means, verdict):
    assert trend("x", [groups(*means)]).verdict == verdict
    falling = trend("x", [groups(*(-m for m in means))], rising=False)
    assert falling.verdict == verdict


def test_a_monotone_trend_has_no_step_the_other_way():
    dip = [groups(1, 2, 1.5, 3, replicates=8)]
    assert trend("x", dip).verdict == REPRODUCED
    assert trend("x", dip, monotone=True).verdict == NOT_REPRODUCED
    slight = [groups(1, 2, 1.98, 3, replicates=8)]
    assert trend("x", slight, monotone=True).verdict == REPRODUCED


def test_a_dip_shows_however_fine_the_steps():
    rise, steps = [0.5, 1.0, 1.5, 2.0], np.linspace(2.0, 1.75, 6)[1:]
    fine = groups(*rise, *steps, 2.5, 3.0, replicates=8)
    neighbours = [mann_whitney_p(low, high) for low, high in pairwise(fine)]
    assert holm_p(neighbours) > RISK
    check = trend("x", [fine], monotone=True)
    assert check.verdict == NOT_REPRODUCED
    assert check.p_holds == 1


def test_strata_are_compared_within():
    """The quantity falls within each stratum and rises from one to the other."""
    strata = [groups(3, 2, 1), groups(13, 12, 11)]
    assert trend("x", strata).verdict == NOT_REPRODUCED
    mixed = [groups(1, 2, 3), groups(1, 2, 3), groups(1, 2, 3), groups(3, 2, 1)]
    assert trend("x", mixed).verdict == REPRODUCED
    assert trend("x", mixed, monotone=True).verdict == NOT_REPRODUCED


def test_ranks_need_no_distribution():
    """One sample mixes two states, and its mean equals that of the other sample."""
    first, second = np.array([2.0, 2.1, 2.2, 2.3, 2.4]), np.array([1.0, 1.1, 1.2, 1.3, 6.4])
    assert first.mean() == second.mean()
    assert outranks("x", first, second[:4], ()).verdict == REPRODUCED
    assert outranks("x", second[:4], first, ()).verdict == NOT_REPRODUCED
    assert outranks("x", first, second, ()).value == 0.8
    # Exact: all of 3 above all of 4 is one of 35 orders.
    assert mann_whitney_p(np.array([5.0, 6, 7]), np.array([1.0, 2, 3, 4])) == pytest.approx(1 / 35)


@pytest.mark.parametrize(
    ("count", "number", "verdict"),
    [(5, 5, REPRODUCED), (4, 4, INCONCLUSIVE), (30, 40, REPRODUCED), (0, 6, NOT_REPRODUCED)],
)
def test_shares_of_runs_are_exact(count, number, verdict):
    assert share_above("x", count, number, 0.5).verdict == verdict


def test_the_interval_of_a_share_is_wilsons():
    assert share_interval(18, 23) == pytest.approx((0.581, 0.903), abs=1e-3)


def interval(rows) -> tuple[float, float]:
    value = smallest_mean(np.asarray(rows, float))
    half_width = 1.96 * value.std_dev
    return value.nominal_value - half_width, value.nominal_value + half_width


def rows_of(means, errors, replicates=8) -> np.ndarray:
    return np.asarray(means) + np.outer(spread(replicates), errors)


def test_least_of_many_is_positive_only_if_all_are():
    assert interval(rows_of([1, 2, 0.5], [0.01, 0.01, 0.01]))[0] > 0
    low, high = interval(rows_of([1, 2, 0.5], [0.01, 5, 0.01]))
    assert low < 0 < high


def test_least_of_many_is_negative_if_one_clearly_is():
    assert interval(rows_of([1, -0.1, -2.0], [0.01, 0.01, 50]))[1] < 0


def test_chance_alone_makes_none_of_many_negative():
    """Each of 2000 sets of 20 positive means that noise hides: 2.5 % of them may fail."""
    rng = np.random.default_rng(1)
    negative = [interval(rng.normal(0, 1, (8, 20)))[1] < 0 for _ in range(2000)]
    assert np.mean(negative) == pytest.approx(0.025, abs=0.01)


def test_one_replicate_says_nothing():
    assert interval([[1.0, 2.0]]) == (-np.inf, np.inf)


def test_the_mean_of_others_knows_nothing_of_the_replicate_itself():
    rows = np.array([[3.0, 0.0], [0.0, 6.0], [0.0, 0.0]])
    assert np.array_equal(mean_of_others(rows), [[0, 3], [1.5, 0], [1.5, 3]])
    assert np.array_equal(mean_of_others(rows.T, axis=1), mean_of_others(rows).T)
    assert np.array_equal(mean_of_others(rows[:1]), rows[:1])


#: Trials per rate; a rate must lie within the scatter of so many trials.
FEW, MANY = 25, 400


def at_most(share: float, trials: int) -> float:
    """Return the rate that one of a thousand sets of trials exceeds by chance."""
    return share + 3.1 * np.sqrt(share * (1 - share) / trials)


@pytest.mark.parametrize("statement", ["bound", "trend"])
def test_what_is_true_by_two_half_widths_holds_and_what_is_false_does_not(statement):
    reproduced, not_reproduced = rates(statement, "correlated", 3, 2, FEW)
    assert reproduced >= 0.8 and not_reproduced <= at_most(0.05, FEW)
    reproduced, _ = rates(statement, "correlated", 3, 0, FEW)
    assert reproduced <= at_most(0.05, FEW)


def test_more_replicates_tighten_an_interval_as_one_over_their_root():
    rng = np.random.default_rng(1)
    wide, narrow = (half_width(rng, KINDS["stationary"], number) for number in (4, 16))
    # Four times as many, and Student's factors of 3 and 15 degrees of freedom.
    assert narrow / wide == pytest.approx(0.5 * 2.13 / 3.18, abs=0.12)


@pytest.mark.parametrize("looks", [2, 4, 9])
def test_looking_again_until_chance_decides_has_its_price(looks):
    """On its threshold a value is open: whatever the judge says of it is wrong."""
    assert sum(look_rates(looks, 0, False, MANY)) > 0.1
    assert sum(look_rates(looks, 0, True, MANY)) <= at_most(0.05, MANY)
    held, failed = look_rates(looks, 2, True, MANY)
    assert held > 0.95 and failed == 0


def test_a_claim_of_many_votes_needs_all_and_fails_with_one():
    assert joint_rates(3, 3, 3, 4, 10)[0] >= 0.8
    assert joint_rates(3, 3, -3, 4, 10) == (0.0, pytest.approx(1.0, abs=0.2))


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
