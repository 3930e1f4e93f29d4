"""Tests that have no interval: trends, ranks, shares of runs. Their statistics come from scipy."""

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import inf, nan

import numpy as np
from scipy import stats

from sim.claims.place import Place
from sim.claims.verdict import RISK, Check, least

Groups = Sequence[np.ndarray]

#: Most values whose trend is tested by permutations, and how many of these.
FEW, PERMUTATIONS = 12, 4999


def trend(
    what: str,
    strata: Sequence[Groups],
    places: Iterable[Place] = (),
    *,
    rising: bool = True,
    monotone: bool = False,
) -> Check:
    """Return the check that a quantity rises (or falls) along a parameter: Jonckheere's trend test.

    Shown is the mean of Kendall's τ of groups and values; that τ has the same p-value as
    Jonckheere's and Terpstra's statistic.

    Parameters
    ----------
    what : str
        The quantity and the parameter.
    strata : sequence of sequence of (R,) arrays
        For each stratum the groups of replicates in the order of the parameter: one stratum, or one
        per cell or frequency within which groups can be compared. Their p-values are combined
        (Stouffer, weighted with the root of their sizes).
    places : iterable of Place
        What was measured.
    rising : bool
        Which way the claim has it.
    monotone : bool
        Whether the sentence says so of any two groups and of every stratum: then it also fails
        where one of them surely goes the other way, as one of so many (Holm). Not of neighbours
        alone: steps may be too small to show what several of them make.
    """
    sign = 1 if rising else -1
    up: list[float] = []
    down: list[float] = []
    taus, sizes, pairs = [], [], []
    for groups in strata:
        values = sign * np.concatenate(groups)
        order = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
        for chances, way in ((up, "greater"), (down, "less")):
            chances.append(_rising(order, values, way))
        taus.append(stats.kendalltau(order, values).statistic)
        sizes.append(values.size)
        if monotone:
            pairs += [superior(sign * low, sign * high) for low, high in combinations(groups, 2)]
    against = [_combined(down, sizes)]
    if monotone:
        against += [*(down if len(strata) > 1 else ()), *pairs]
    tau = float(np.average(taus, weights=sizes))
    fails = least(against)
    # What surely falls somewhere does not rise, however clear the trend of all.
    tested = (_combined(up, sizes) if fails > RISK else 1.0), fails
    # The thresholds are those of the statistic: a trend either way has another sign.
    return _tested(f"Kendall's τ of {what}", sign * tau, rising, tested, places)


def _rising(order: np.ndarray, values: np.ndarray, way: str) -> float:
    """Return the p-value that values (N,) rise with their order, or fall.

    Of few values by permutations: the distribution of τ where many share an order is normal for
    many only.
    """
    if values.size > FEW:
        return _chance(stats.kendalltau(order, values, alternative=way).pvalue)
    first, second = np.nonzero(order[:, None] < order)

    def score(permuted: np.ndarray, axis: int) -> np.ndarray:
        return np.sign(permuted[..., second] - permuted[..., first]).sum(axis=axis)

    return stats.permutation_test(
        (values,),
        score,
        permutation_type="pairings",
        alternative=way,
        n_resamples=PERMUTATIONS,
        rng=np.random.default_rng(0),
    ).pvalue


def outranks(what: str, first: np.ndarray, second: np.ndarray, places: Iterable[Place]) -> Check:
    """Return the check that replicates (R,) rank above others: Mann and Whitney's test.

    Shown is how often one of the first exceeds one of the second. It needs no distribution, so
    replicates may be in different states.
    """
    chances = superior(first, second), superior(second, first)
    exceeds = stats.mannwhitneyu(first, second).statistic / (len(first) * len(second))
    return _tested(what, float(exceeds), True, chances, places, 0.5)


def superior(above: np.ndarray, below: np.ndarray) -> float:
    """Return the p-value of Mann and Whitney's test that one sample ranks above another."""
    return _chance(stats.mannwhitneyu(above, below, alternative="greater").pvalue)


def share_above(
    what: str, count: int, number: int, threshold: float, places: Iterable[Place] = ()
) -> Check:
    """Return the check that a share exceeds a threshold, by the exact binomial test."""
    holds, fails = (
        stats.binomtest(count, number, threshold, alternative=way).pvalue
        for way in ("greater", "less")
    )
    return _tested(what, count / number, True, (holds, fails), places, threshold)


def share_of(count: int, number: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of runs (Wilson's)."""
    interval = stats.binomtest(count, number).proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


def _chance(p: float) -> float:
    """Return a p-value; values that are all the same tell nothing."""
    return 1.0 if np.isnan(p) else float(p)


def _combined(chances: Sequence[float], sizes: Sequence[int]) -> float:
    if len(chances) == 1:
        return chances[0]
    # A chance of exactly one would be infinitely sure of the opposite.
    inside = np.clip(chances, 1e-15, 1 - 1e-15)
    weights = np.sqrt(sizes)
    return float(stats.combine_pvalues(inside, method="stouffer", weights=weights).pvalue)


def _tested(
    what: str,
    value: float,
    above: bool,
    tested: tuple[float, float],
    places: Iterable[Place],
    threshold: float = 0.0,
) -> Check:
    # The replicate is what is ranked or counted, however many independent samples it has.
    places = tuple(places)
    return Check(
        what=what,
        value=value,
        half_width=nan,
        low=threshold if above else -inf,
        high=inf if above else threshold,
        points=tuple(dict.fromkeys(place.id for place in places)),
        tested=tested,
    )
