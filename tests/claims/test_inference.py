"""Tests without an interval: trends, ranks, shares of runs."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from sim.claims.inference import mann_whitney_p, outranks, share_above, share_interval, trend
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
