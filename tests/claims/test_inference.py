"""Tests without an interval: trends, ranks, shares of runs."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from sim.claims.inference import outranks, share_above, share_of, superior, trend
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, RISK, least
from tests.made.results import spread


def groups(*means, replicates=5, scatter=0.1):
    """Replicates about some means."""
    return [mean + scatter * spread(replicates) for mean in means]


def test_the_trend_is_jonckheeres():
    """Jonckheere's statistic counts pairs in order; its normal p-value is that of Kendall's τ."""
    rng = np.random.default_rng(4)
    found = [rng.normal(size=n) + 0.3 * k for k, n in enumerate((4, 6, 5, 3))]
    pairs = [
        (a, b) for i, one in enumerate(found) for two in found[i + 1 :] for a in one for b in two
    ]
    counted = sum(b > a for a, b in pairs)
    sizes, total = np.array([len(one) for one in found]), sum(map(len, found))
    variance = (total**2 * (2 * total + 3) - (sizes**2 * (2 * sizes + 3)).sum()) / 72
    z = (counted - len(pairs) / 2) / np.sqrt(variance)
    assert trend("x", [found]).holding == pytest.approx(stats.norm.sf(z), rel=1e-6)


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
    neighbours = [superior(low, high) for low, high in pairwise(fine)]
    assert least(neighbours) > RISK
    held = trend("x", [fine], monotone=True)
    assert held.verdict == NOT_REPRODUCED
    assert held.holding == 1


def test_strata_are_compared_within():
    """Within each the quantity falls, over both it rises."""
    strata = [groups(3, 2, 1), groups(13, 12, 11)]
    assert trend("x", strata).verdict == NOT_REPRODUCED
    mixed = [groups(1, 2, 3), groups(1, 2, 3), groups(1, 2, 3), groups(3, 2, 1)]
    assert trend("x", mixed).verdict == REPRODUCED
    assert trend("x", mixed, monotone=True).verdict == NOT_REPRODUCED


def test_ranks_need_no_distribution():
    """Two states of one sample, whose mean is that of the other."""
    ours, theirs = np.array([2.0, 2.1, 2.2, 2.3, 2.4]), np.array([1.0, 1.1, 1.2, 1.3, 6.4])
    assert ours.mean() == theirs.mean()
    assert outranks("x", ours, theirs[:4], ()).verdict == REPRODUCED
    assert outranks("x", theirs[:4], ours, ()).verdict == NOT_REPRODUCED
    assert outranks("x", ours, theirs, ()).value == 0.8
    # Exact: all of 3 above all of 4 is one of 35 orders.
    assert superior(np.array([5.0, 6, 7]), np.array([1.0, 2, 3, 4])) == pytest.approx(1 / 35)


@pytest.mark.parametrize(
    ("count", "number", "verdict"),
    [(5, 5, REPRODUCED), (4, 4, INCONCLUSIVE), (30, 40, REPRODUCED), (0, 6, NOT_REPRODUCED)],
)
def test_shares_of_runs_are_exact(count, number, verdict):
    assert share_above("x", count, number, 0.5).verdict == verdict


def test_the_interval_of_a_share_is_wilsons():
    assert share_of(18, 23) == pytest.approx((0.581, 0.903), abs=1e-3)
