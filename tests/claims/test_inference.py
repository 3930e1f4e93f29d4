"""Trends, ranks and shares of runs; statements about many quantities at once; ratios."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from sim.claims.checks import at_least, conjunction_p, within
from sim.claims.inference import (
    mann_whitney_p,
    mean_of_others,
    outranks,
    same_by_rank,
    share_above,
    single_rise,
    smallest_mean,
    trend,
)
from sim.claims.place import quotient, with_interval
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, SIGMAS, Check
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


@pytest.mark.parametrize(
    ("means", "options", "verdicts"),
    [
        # That no reversal is seen is no evidence of none.
        ((1, 2, 2, 3), {"scatter": 0.02}, (REPRODUCED, REPRODUCED, INCONCLUSIVE)),
        # A sure reversal of 3 %: smaller than the share it refutes nothing.
        ((1, 2, 1.94, 3), {"scatter": 0.01}, (REPRODUCED, REPRODUCED, NOT_REPRODUCED)),
        # Nor does a trend that is a sure reversal as a whole.
        ((1, 0.97), {"scatter": 0.01}, (NOT_REPRODUCED, INCONCLUSIVE, NOT_REPRODUCED)),
    ],
)
def test_a_reversal_counts_on_either_side_from_one_share_on(means, options, verdicts):
    rising = groups(*means, replicates=12, **options)
    for margin, verdict in zip((None, 0.05, 0.001), verdicts, strict=True):
        for samples, is_rising in ((rising, True), (rising[::-1], False)):
            check = trend("x", [samples], rising=is_rising, margin=margin)
            assert check.verdict == verdict


def test_samples_are_the_same_by_rank_within_a_margin():
    first = np.linspace(0.99, 1.01, 8)
    verdicts = [
        same_by_rank("x", first, factor * first, 0.03, ()).verdict for factor in (1, 1.03, 1.2, 0.8)
    ]
    assert verdicts == [REPRODUCED, INCONCLUSIVE, NOT_REPRODUCED, NOT_REPRODUCED]
    # Two states of which either sample has both: no common mean is needed.
    states = np.array([1.0, 1.001, 1.002, 1.003, 2.0, 2.001, 2.002, 2.003])
    assert same_by_rank("x", states, states[::-1], 0.03, ()).verdict == INCONCLUSIVE


def test_strata_are_compared_within():
    """The quantity falls within each stratum and rises from one to the other."""
    strata = [groups(3, 2, 1), groups(13, 12, 11)]
    assert trend("x", strata).verdict == NOT_REPRODUCED
    mixed = [groups(1, 2, 3), groups(1, 2, 3), groups(1, 2, 3), groups(3, 2, 1)]
    assert trend("x", mixed).verdict == REPRODUCED
    assert trend("x", mixed, margin=0.05).verdict == NOT_REPRODUCED


def watched(*looks):
    """Return places that have been looked at so often."""
    return [SimpleNamespace(id=f"{n}", samples=99, freedom=7, looks=n) for n in looks]


def test_a_pair_pays_for_the_looks_at_its_own_places():
    """A reversal between the first two; the third has been looked at nine times."""
    samples = groups(2, 1.5, 3, replicates=8)
    free, paid = (trend("x", [samples], places, margin=0.05) for places in ((), watched(1, 1, 9)))
    assert paid.p_fails == pytest.approx(4 * free.p_fails)
    assert paid.verdict == NOT_REPRODUCED
    assert trend("x", [samples], watched(1, 9, 1), margin=0.05).verdict == INCONCLUSIVE
    # That all of them rise is shown by all of them.
    rising = groups(1, 2, 3, replicates=8)
    assert trend("x", [rising], watched(1, 1, 9)).p_holds == pytest.approx(
        2**10 * trend("x", [rising]).p_holds
    )


def test_a_stratum_of_many_groups_takes_nothing_from_another():
    """One that falls is as sure beside one of ten groups as beside one of two."""
    falls, few, many = groups(2, 1.5), groups(1, 2), groups(*range(1, 11))
    p_values = {trend("x", [falls, other], margin=0.05).p_fails for other in (few, many)}
    assert len(p_values) == 1 and p_values != {1.0}


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


def test_that_some_of_several_hold_has_one_p_value():
    """All of them: the largest; any of them: Bonferroni's."""
    p_values = [0.01, 0.5, 0.02]
    assert [conjunction_p(p_values, least) for least in (3, 2, 1)] == [0.5, 0.04, 0.03]
    assert conjunction_p([0.6, 0.5], 1) == conjunction_p([], 1) == 1


SLOPES = {"holds": 0.0, "fails": 3.0, "open": 1.0}


def slope(kind: str, **options) -> Check:
    """Return the check of a slope between -1 and 1 that holds, fails or is open."""
    return Check(kind, SLOPES[kind], 0.1, -1.0, 1.0, points=(kind,), **options)


@pytest.mark.parametrize(
    ("kinds", "verdict"),
    [
        (["holds"] * 3, REPRODUCED),
        (["holds"] * 3 + ["fails", "open"], REPRODUCED),
        (["holds", "holds", "open", "open", "fails"], INCONCLUSIVE),
        # Three of five cannot hold where three fail.
        (["holds", "holds", "fails", "fails", "fails"], NOT_REPRODUCED),
        (["fails"] * 5, NOT_REPRODUCED),
        (["holds", "open", "fails", "fails"], NOT_REPRODUCED),
        (["holds", "holds", "open", "fails"], INCONCLUSIVE),
        # Two that were run are no variety, and do not deny one.
        (["holds"] * 2, INCONCLUSIVE),
        (["fails"] * 2, INCONCLUSIVE),
    ],
)
def test_some_of_several_checks_must_hold(kinds, verdict):
    check = at_least("depths", 3, [slope(kind) for kind in kinds])
    assert (check.verdict, check.value) == (verdict, kinds.count("holds"))
    assert check.points == tuple(dict.fromkeys(kinds))


@pytest.mark.parametrize("option", [{"withheld": "it still moves"}, {"samples": 2}])
def test_checks_that_decide_nothing_are_open_ones_among_several(option):
    held = [slope("holds"), slope("holds")]
    assert at_least("x", 3, [*held, slope("holds")]).verdict == REPRODUCED
    for kind in SLOPES:
        assert at_least("x", 3, [*held, slope(kind, **option)]).verdict == INCONCLUSIVE


def test_looks_are_paid_for_once_by_several_checks():
    slight = [Check("x", 0.0, 0.01, -1, 1, tested=(0.01, 0.9), looks=1) for _ in range(3)]
    # 0.01 counts fourfold at the first look.
    assert at_least("x", 3, slight).p_holds == pytest.approx(0.04)
    assert at_least("x", 2, slight).p_holds == pytest.approx(0.08)


def test_some_of_several_are_priced_by_those_that_are_open():
    """More replicates of a depth that holds already decide nothing."""
    places = [SimpleNamespace(id=name, samples=99, freedom=7, looks=0) for name in "abc"]
    checks = [
        within("x", with_interval(value, 0.1), -inf, 1, [place])
        for value, place in zip((0.5, 0.98, 0.96), places, strict=True)
    ]
    check = at_least("x", 3, checks)
    assert check.verdict == INCONCLUSIVE
    assert check.points == ("a", "b", "c") and check.open_points == ("b", "c")


def test_single_rises_are_counted_over_all_choices():
    """Of nine choices of one value each of (1, 3, 5) and (2, 4, 6), six rise."""
    rise = single_rise([np.array([1.0, 3.0, 5.0]), np.array([2.0, 4.0, 6.0])])
    assert rise.nominal_value == pytest.approx(6 / 9)
    assert single_rise([np.zeros(4), np.ones(4), np.full(4, 2.0)]).std_dev == 0
    rng = np.random.default_rng(1)
    groups = [rng.normal(size=20) + 0.5 * number for number in range(4)]
    draws = np.array([rng.choice(group, 20_000) for group in groups])
    share = (np.diff(draws, axis=0) > 0).all(axis=0).mean()
    assert single_rise(groups).nominal_value == pytest.approx(share, abs=0.015)


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


def half_width(numerator, denominator) -> float:
    return SIGMAS * quotient(numerator, denominator).std_dev


def test_a_well_known_divisor_gives_the_propagated_error():
    ratio = quotient(with_interval(3.0, 0.3), with_interval(2.0, 0.02))
    assert ratio.nominal_value == 1.5
    assert SIGMAS * ratio.std_dev == pytest.approx(1.5 * np.hypot(0.1, 0.01), rel=5e-3)


def test_the_interval_holds_a_threshold_where_the_difference_is_not_sure():
    """At its farther end ``over - t · under`` is just as far from zero as its own interval."""
    numerator, denominator = with_interval(1.0, 0.2), with_interval(2.0, 1.0)
    end = 0.5 + half_width(numerator, denominator)
    assert abs(1.0 - end * 2.0) == pytest.approx(np.hypot(0.2, end * 1.0))


def test_a_divisor_that_may_be_zero_leaves_the_ratio_open():
    assert half_width(with_interval(1.16, 0.1), with_interval(3.98, 4.5)) == np.inf
    assert half_width(with_interval(1.16, 0.1), with_interval(3.98, np.inf)) == np.inf
