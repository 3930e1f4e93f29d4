"""Tests without an interval: trends, ranks, shares of runs. Their statistics come from scipy."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain, combinations, pairwise
from math import comb, inf, nan, prod

import numpy as np
from scipy import stats
from uncertainties import UFloat, ufloat

from sim.base.statistics import share_of_rises, student
from sim.claims.checks import reported, within
from sim.claims.place import Place, replicate_mean, with_interval
from sim.claims.verdict import RISK, SIGMAS, Check, spent

Groups = Sequence[np.ndarray]

#: How the name of a likelihood begins: a paper with one run per point sees what its sentence says.
LIKELIHOOD = "probability that of one run per point"

# Statistics are cached by the values they are of: readings and grids that do not change these ask
# for them again.

#: Largest number of values whose trend is tested by permutations, and number of permutations.
FEW, PERMUTATIONS = 12, 4999


def trend(
    quantity: str,
    strata: Sequence[Groups],
    places: Iterable[Place] = (),
    *,
    rising: bool = True,
    margin: float | None = None,
    labels: Sequence[str] = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity rises (or falls) along a parameter: Jonckheere's trend test.

    It shows the mean of Kendall's τ of group number and value, with the p-value of their statistic.
    Each of ``strata`` has the groups of replicates, arrays (R,), in the order of the parameter: one
    stratum, or one per cell or frequency within which groups can be compared. Their p-values are
    combined (Stouffer, weighted with the root of their sizes).

    With a ``margin`` the values are positive, and the claim is about any two groups of a stratum.
    It holds only where surely no two of them go the other way by this share or more (one-sided
    equivalence), since that no reversal is seen is no evidence that there is none. It fails only
    where two surely do, corrected for the number of pairs. All pairs are tested, not neighbours
    alone: single steps may be too small to show a decrease over several. A pair pays for the looks
    at its own places: ``places`` are those of the groups, then in the same order. The text of the
    check names by ``labels``, such as ``"20 Hz"``, the surest reversal, if that refutes the claim,
    with the interval of the difference, whose ``unit`` is that of the values.
    """
    sign, places = 1 if rising else -1, tuple(places)
    sizes = [sum(map(len, groups)) for groups in strata]
    rank_trends = [
        _rank_trend(
            tuple(np.repeat(np.arange(len(groups)), [*map(len, groups)])),
            tuple(sign * np.concatenate(groups)),
        )
        for groups in strata
    ]
    taus, *p_values = zip(*rank_trends, strict=True)
    tau = float(np.average(taus, weights=sizes))
    p_rising, p_falling = (_stouffer_p(ps, sizes) for ps in p_values)
    # The threshold applies to τ, whose sign is the direction of the trend.
    bounds, name = ((0.0, inf) if rising else (-inf, 0.0)), f"Kendall's τ of {quantity}"
    check = _p_value_check(name, sign * tau, bounds, (p_rising, p_falling), places)
    if margin is None:
        return check
    groups, pairs = [*chain.from_iterable(strata)], _pairs([*map(len, strata)])
    ordered = [
        (groups[one], groups[other]) if rising else (groups[other], groups[one])
        for one, other, _ in pairs
    ]
    watched = [place.looks for place in places] or [0] * len(groups)
    looks = [max(watched[one], watched[other]) for one, other, _ in pairs]
    p_beyond, p_within = (
        [spent(p, number) for p, number in zip(ps, looks, strict=True)]
        for ps in _against(ordered, margin)
    )
    p_of_any = [min(1.0, number * p) for p, (*_, number) in zip(p_beyond, pairs, strict=True)]
    p_fails = min(p_of_any, default=1.0)
    # All of these have paid for their looks.
    check = replace(check, tested=(max(check.p_holds, *p_within), p_fails), looks=0)
    if not (labels and p_fails <= RISK):
        return check
    one, other, _ = pairs[int(np.argmin(p_of_any))]
    reversal = _reversal((groups[one], groups[other]), (labels[one], labels[other]), unit)
    return replace(check, text=f"{check.value:.3g}; {reversal}")


def _pairs(sizes: Sequence[int]) -> list[tuple[int, int, int]]:
    """Return any two groups of a stratum, as numbers through all strata, and their correction.

    It is a factor on their p-value for all pairs of all strata (Bonferroni). Strata have equal
    shares of the risk: one with many groups takes nothing from the others.
    """
    ends = np.cumsum([0, *sizes]).tolist()
    return [
        (*pair, len(sizes) * comb(end - first, 2))
        for first, end in pairwise(ends)
        for pair in combinations(range(first, end), 2)
    ]


def _against(
    pairs: Sequence[tuple[np.ndarray, np.ndarray]], margin: float
) -> tuple[list[float], list[float]]:
    """Return the p-values that the second of a pair is lower by the margin, and that it is not."""
    raised = tuple((tuple(low), tuple((1 + margin) * high)) for low, high in pairs)
    return _mann_whitney_ps(raised), _mann_whitney_ps(tuple(one[::-1] for one in raised))


def _reversal(pair: tuple[np.ndarray, np.ndarray], labels: Sequence[str], unit: str) -> str:
    change = replicate_mean(pair[1]) - replicate_mean(pair[0])
    verb = "rises" if change.nominal_value > 0 else "falls"
    size = ufloat(abs(change.nominal_value), SIGMAS * change.std_dev)
    amount = f"{size:.2uP}".replace("±", " ± ") if np.isfinite(size.std_dev) else f"{size.n:.3g}"
    return f"{verb} from {labels[0]} to {labels[1]} by {amount} {unit}".rstrip()


@lru_cache(maxsize=10_000)
def _rank_trend(order: tuple[int, ...], values: tuple[float, ...]) -> tuple[float, float, float]:
    """Return Kendall's τ of values (N,) and their order, and its p-values of a rise and a fall."""
    arrays = np.array(order), np.array(values)
    p_rising, p_falling = (_trend_p(*arrays, tail) for tail in ("greater", "less"))
    return float(stats.kendalltau(*arrays).statistic), p_rising, p_falling


def _trend_p(order: np.ndarray, values: np.ndarray, alternative: str) -> float:
    """Return the p-value that values (N,) rise with their order, or fall.

    Few values are tested by permutations: with many equal orders the distribution of τ is normal
    only for large N.
    """
    if values.size > FEW:
        return _finite_p(stats.kendalltau(order, values, alternative=alternative).pvalue)
    first, second = np.nonzero(order[:, None] < order)

    def score(permuted: np.ndarray, axis: int) -> np.ndarray:
        return np.sign(permuted[..., second] - permuted[..., first]).sum(axis=axis)

    return stats.permutation_test(
        (values,),
        score,
        permutation_type="pairings",
        alternative=alternative,
        n_resamples=PERMUTATIONS,
        rng=np.random.default_rng(0),
    ).pvalue


def reported_order(quantity: str, strata: Sequence[Groups], *, rising: bool = True) -> Check:
    """Report how likely one run per point is in the order of a sentence, in all strata at once."""
    sign = 1 if rising else -1
    orders = [single_rise([sign * group for group in groups]) for groups in strata]
    return reported_likelihood(quantity, orders)


def single_rise(groups: Groups) -> UFloat:
    """Return the probability that one value of each group, drawn at random, rises throughout."""
    return ufloat(*_share_of_rises(tuple(map(tuple, groups))))


@lru_cache(maxsize=10_000)
def _share_of_rises(groups: tuple[tuple[float, ...], ...]) -> tuple[float, float]:
    return share_of_rises([np.array(group) for group in groups])


def reported_likelihood(quantity: str, likelihoods: Iterable[UFloat]) -> Check:
    """Report the probability that one run per point shows all of several independent orders."""
    check = reported(f"{LIKELIHOOD} {quantity}", prod(likelihoods))
    low, high = max(0.0, check.value - check.half_width), min(1.0, check.value + check.half_width)
    return replace(check, text=f"{check.value:.2g} ({low:.2g} to {high:.2g})")


def outranks(
    quantity: str, first: np.ndarray, second: np.ndarray, places: Iterable[Place]
) -> Check:
    """Return the check that replicates (R,) rank above others: Mann and Whitney's test.

    The value shown is the share of pairs in which the first exceeds the second. The test needs no
    distribution, so replicates may be in different states.
    """
    p_values = mann_whitney_p(first, second), mann_whitney_p(second, first)
    share = stats.mannwhitneyu(first, second).statistic / (len(first) * len(second))
    return _p_value_check(quantity, float(share), (0.5, inf), p_values, places)


def mann_whitney_p(above: np.ndarray, below: np.ndarray) -> float:
    """Return the p-value of Mann and Whitney's test that one sample ranks above another."""
    return _mann_whitney_ps(((tuple(above), tuple(below)),))[0]


@lru_cache(maxsize=10_000)
def _mann_whitney_ps(pairs: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]) -> list[float]:
    """Return the p-values of pairs of samples; a call for all that are alike is much faster.

    Whether there are ties decides on the distribution that the test assumes.
    """
    kinds = defaultdict(list)
    for number, (above, below) in enumerate(pairs):
        has_ties = len({*above, *below}) < len(above) + len(below)
        kinds[len(above), len(below), has_ties].append(number)
    p_values = [1.0] * len(pairs)
    for numbers in kinds.values():
        samples = (np.array([pairs[number][side] for number in numbers]) for side in (0, 1))
        found = stats.mannwhitneyu(*samples, alternative="greater", axis=1).pvalue
        for number, p_value in zip(numbers, found, strict=True):
            p_values[number] = _finite_p(p_value)
    return p_values


def same_by_rank(
    quantity: str, first: np.ndarray, second: np.ndarray, margin: float, places: Iterable[Place]
) -> Check:
    """Return the check that two samples of positive values (R,) are the same within a share.

    It holds where the first, raised by the ``margin``, ranks above the second and the second, so
    raised, above the first (two one-sided tests of Mann and Whitney). It fails where one of them
    ranks above the other, so raised (Bonferroni). The value shown is the ratio of their medians.
    Replicates may be in different states.
    """
    raised = 1 + margin
    p_holds = max(mann_whitney_p(raised * first, second), mann_whitney_p(raised * second, first))
    p_fails = 2 * min(
        mann_whitney_p(first, raised * second), mann_whitney_p(second, raised * first)
    )
    ratio = float(np.median(first) / np.median(second))
    p_values = p_holds, min(1.0, p_fails)
    return _p_value_check(quantity, ratio, (1 - margin, raised), p_values, places)


def share_above(
    quantity: str, count: int, number: int, threshold: float, places: Iterable[Place] = ()
) -> Check:
    """Return the check that a share exceeds a threshold, by the exact binomial test."""
    p_holds, p_fails = (
        stats.binomtest(count, number, threshold, alternative=alternative).pvalue
        for alternative in ("greater", "less")
    )
    bounds = threshold, inf
    check = _p_value_check(quantity, count / number, bounds, (p_holds, p_fails), places)
    return replace(check, text=share_text(count, number))


def reported_share(quantity: str, count: int, number: int, places: Iterable[Place] = ()) -> Check:
    """Return a check without thresholds of a share of runs: so many of a number."""
    check = reported(quantity, count / number, places)
    return replace(check, half_width=nan, text=share_text(count, number))


def share_text(count: int, number: int) -> str:
    """Write a share of runs with its 95 % interval (Wilson).

    >>> share_text(5, 5), share_text(13, 18)
    ('5 of 5 (0.57 to 1)', '13 of 18 (0.49 to 0.88)')
    """
    interval = stats.binomtest(count, number).proportion_ci(method="wilson")
    return f"{count} of {number} ({interval.low:.2g} to {interval.high:.2g})"


def _finite_p(p: float) -> float:
    """Return a p-value, 1 in place of NaN: values that are all equal carry no information."""
    return 1.0 if np.isnan(p) else float(p)


def _stouffer_p(p_values: Sequence[float], sizes: Sequence[int]) -> float:
    if len(p_values) == 1:
        return p_values[0]
    # A p-value of exactly one would be infinitely certain of the opposite.
    inside = np.clip(p_values, 1e-15, 1 - 1e-15)
    weights = np.sqrt(sizes)
    return float(stats.combine_pvalues(inside, method="stouffer", weights=weights).pvalue)


def _p_value_check(
    quantity: str,
    value: float,
    bounds: tuple[float, float],
    p_values: tuple[float, float],
    places: Iterable[Place],
) -> Check:
    # Replicates are ranked or counted, however many independent samples each of them has.
    check = within(quantity, value, *bounds, places)
    return replace(check, half_width=nan, tested=p_values, samples=inf, freedom=inf)


def mean_of_others(rows: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return for each replicate along an axis the mean of all others; a single one its own.

    Other replicates select the largest of many quantities, and the replicate itself gives its size.
    So the choice of the largest adds no bias.
    """
    number = rows.shape[axis]
    return (rows.sum(axis=axis, keepdims=True) - rows) / (number - 1) if number > 1 else rows


def smallest_mean(rows: np.ndarray) -> UFloat:
    """Return the smallest of the means of B quantities (R, B), with an interval that holds for all.

    The intervals are Student's at a level divided by B (Bonferroni), so that all B hold together
    at 95 %. A clearly negative quantity is returned first; otherwise the one with the lowest end
    of its interval. So all are positive only if this one is, and some quantity is negative if this
    one is.
    """
    replicates, number = rows.shape
    means = rows.mean(axis=0)
    if replicates < 2:
        return with_interval(float(means.min()), np.inf)
    widths = student(replicates - 1, number) * rows.std(axis=0, ddof=1) / np.sqrt(replicates)
    worst = np.argmin(means + widths)
    if means[worst] + widths[worst] >= 0:
        worst = np.argmin(means - widths)
    return with_interval(float(means[worst]), float(widths[worst]))
