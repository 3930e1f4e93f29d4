"""What matters, by a surrogate or by the runs of a design: Sobol' indices, Morris' screening.

First-order index: the share of the variance that a parameter explains alone. Total index: its share
with all interactions. Both are of a parameter that is spread evenly over its range, in its scale.

Of a surrogate they are those of SALib: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259; of
interactions Saltelli 2002, ibid. 145, 280. Of runs those of Janon et al. 2014, ESAIM: Probab. Stat.
18, 342 (first order: the correlation of two runs that have the parameter in common) and Jansen
1999, Comput. Phys. Commun. 117, 35 (total: the squared difference of two runs that differ in it
alone). The noise of the runs is in no product of two runs, but adds to squares: its variance is
taken off each of them. Morris' mean and deviation of elementary effects: Campolongo et al. 2007,
Environ. Model. Softw. 22, 1509.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from sim.base.errors import percent
from sim.base.statistics import MANY, student
from sim.study.questions import FEWEST_BLOCKS
from sim.surrogates.answers import EVEN, Refusal
from sim.surrogates.fit import LENGTHS, counted_probability
from sim.surrogates.sample import scaled
from sim.surrogates.surrogate import Surrogate

#: Columns of a table.
#:
#: ``index`` is ``first``, ``total``, ``interaction`` or ``sum`` (of the first-order indices; its
#: ``parameter`` is ``all``), or Morris' ``mu``, ``mu_star`` or ``sigma``. ``other`` names the
#: second parameter of an interaction. ``low`` and ``high`` are the ends of the 95 % interval,
#: not-a-number where there is none. ``doubt`` says what is doubtful about the row alone. The others
#: are the same in all rows: ``blocks`` of the sample that count, ``left_out`` those with a run that
#: failed or has no value; ``noise``, the share of the variance that comes from the scatter between
#: replicates, 0 for a surrogate, not-a-number where it is not known; ``error`` of the surrogate,
#: relative to the mean size, not-a-number for runs; ``absent``, the share of the ranges in which a
#: flow of another regime is likelier, 0 for runs.
COLUMNS = (
    *("index", "parameter", "other", "value", "low", "high"),
    *("blocks", "left_out", "noise", "error", "absent", "doubt"),
)

#: Indices that are shares of the variance, from 0 to 1.
_SHARES = ("first", "total", "sum")

#: Least spread of values, relative to their size, that is not from rounding.
_LEAST_SPREAD = 1e-12

#: What a total index must be below, with its interval, to be without effect.
NEGLIGIBLE = 0.01

#: What may be doubtful about a row.
_OUTSIDE = "outside 0 to 1 by more than its interval, by too few points"
_NO_INTERVAL = "no interval, as effects at different places are equal or too few"

#: Blocks of a sample of a surrogate, a power of two; and samples, with as many realisations each.
BLOCKS, _SCRAMBLINGS, _REALISATIONS = 2**11, 8, 4

#: Waves of a realisation, and its longest correlation length, of the unit cube.
_WAVES, _LONGEST = 128, 1.0

#: Shares beyond which there are no indices: of the ranges without such a flow, of the variance that
#: points do not tell of each other, and of that which comes from noise.
_MOST_ABSENT, _MOST_UNEXPLAINED, _MOST_NOISE = 0.5, 0.5, 0.5

#: Points at which ranges are looked at, and the seed of all that is drawn.
_PLACES, _SEED = 2**12, 1

#: Blocks for a degree of freedom of an interval, and fewest degrees. A few blocks hold most of the
#: variance of a ratio; with these, intervals of eight blocks hold the truth as often as they say.
_BLOCKS, _FREEDOM = 4, 3

#: Fewest different effects that give an interval, and difference of equal ones, of their size.
_FEWEST_EFFECTS, _EQUAL = 3, 1e-9

#: How much larger a mean size may be by noise, in its standard deviations, once it is taken off.
_FOLDED = 0.6


def tabulate(
    names: Iterable[tuple[str, str, str]],
    estimate: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    **basis: Any,
) -> pd.DataFrame:
    """Return values and ends of intervals as a table of `COLUMNS`.

    ``names`` has index, parameter and other of each; ``basis`` what is the same in all rows.
    """
    rows = [(*name, *numbers) for name, *numbers in zip(names, estimate, low, high, strict=True)]
    table = pd.DataFrame(rows, columns=list(COLUMNS[:6]))
    is_outside = table["index"].isin(_SHARES) & ((table["high"] < 0) | (table["low"] > 1))
    known = {"left_out": 0, "noise": 0.0, "error": np.nan, "absent": 0.0} | basis
    return table.assign(**known, doubt=np.where(is_outside, _OUTSIDE, ""))[list(COLUMNS)]


def _require_spread(values: np.ndarray) -> None:
    """Raise `Refusal` where values do not vary by more than rounding."""
    if np.ptp(values) <= _LEAST_SPREAD * np.abs(values).max():
        value = f"{values.max():.6g} everywhere, so nothing can matter"
        raise Refusal(f"no indices, as the observable does not vary: it is {value}")


def require_little_noise(share: float, lack: str) -> None:
    """Raise `Refusal`, with what is lacking, where noise is most of the variance between runs."""
    if share > _MOST_NOISE:
        raise Refusal(
            f"{lack}, as the noise of the runs is {percent(share)} of the variance between them, "
            f"beyond {percent(_MOST_NOISE)}; more replicates or longer runs make it smaller"
        )


def shares_of(names: Sequence[str]) -> list[tuple[str, str, str]]:
    """Return index, parameter and other parameter of first-order and total indices, and the sum."""
    alone = [(index, name, "") for index in ("first", "total") for name in names]
    return [*alone, ("sum", "all", "")]


def indices_of_surrogate(surrogate: Surrogate, blocks: int = BLOCKS) -> pd.DataFrame:
    """Return the indices of a surrogate as `sobol_indices`, with all that is weak about them.

    Raises `Refusal` if the mean means little in most of the ranges, or is rough or constant.
    """
    from scipy.stats import qmc

    shares = qmc.Sobol(len(surrogate.parameters), rng=_SEED).random(_PLACES)
    places = scaled(shares, surrogate.bounds, surrogate.scales)
    absent = require_learned(surrogate, places, "no indices")
    _require_spread(surrogate.sample["mean"].values[surrogate.in_mean])
    return sobol_indices(surrogate, blocks).assign(error=surrogate.error, absent=absent)


def require_learned(surrogate: Surrogate, places: np.ndarray, lack: str) -> float:
    """Return the share of places (n, k) where a mean is of unlikely regimes, or no run is near.

    Raises `Refusal`, with what is lacking, where that is most of them, or the mean is rough.
    """
    counted = counted_probability(surrogate, surrogate.probability(places))
    absent = float((surrogate.is_far(places) | (counted < EVEN)).mean())
    if absent > _MOST_ABSENT:
        raise Refusal(
            f"{lack}, as surrogate {surrogate.name} is of flows that are "
            f"{' or '.join(surrogate.mean_regimes)}, and in {percent(absent)} of the ranges no "
            "such flow is likely, or no run is near; ask narrower ranges, or name other regimes "
            "with the surrogate"
        )
    if (share := surrogate.process.unexplained_share) > _MOST_UNEXPLAINED:
        raise Refusal(
            f"{lack}, as the points of surrogate {surrogate.name} do not tell "
            f"{percent(min(1.0, share))} of the variance of each other; more points lessen it"
        )
    return absent


def sobol_indices(surrogate: Surrogate, blocks: int = BLOCKS) -> pd.DataFrame:
    """Return first-order and total indices and interactions of a surrogate, as a table.

    They are means over `_SCRAMBLINGS` independent samples of so many ``blocks``. The interval has
    two parts, added in quadrature. The sample's own is from the scatter between these. That of the
    surrogate is from realisations: its mean plus its error times a smooth random field of variance
    1, whose correlation length is drawn for each: from the shortest that a process may have.
    """
    from SALib.sample import sobol

    names, rng = list(surrogate.parameters), np.random.default_rng(_SEED)
    # The unit cube, as SALib describes it.
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    estimates, deviations = [], []
    for seed in range(1, _SCRAMBLINGS + 1):
        shares = sobol.sample(problem, blocks, calc_second_order=True, seed=seed)
        mean, error = surrogate.predict(scaled(shares, surrogate.bounds, surrogate.scales))
        estimates.append(_sobol(problem, mean))
        for _ in range(_REALISATIONS if error.any() else 0):
            values = mean + error * smooth_field(shares, rng)
            deviations.append(_sobol(problem, values) - estimates[-1])
    sampling = student(_SCRAMBLINGS - 1) * np.std(estimates, axis=0, ddof=1) / np.sqrt(_SCRAMBLINGS)
    spread = np.sqrt(np.mean(np.square(deviations), axis=0)) if deviations else 0.0
    half = np.hypot(sampling, float(student(MANY)) * spread)
    middle, pairs = np.mean(estimates, axis=0), combinations(names, 2)
    rows = [*shares_of(names), *(("interaction", *pair) for pair in pairs)]
    return tabulate(rows, middle, middle - half, middle + half, blocks=_SCRAMBLINGS * blocks)


def _sobol(problem: dict[str, Any], values: np.ndarray) -> np.ndarray:
    """Return first-order and total indices, the sum of the former, and interactions."""
    from SALib.analyze import sobol

    analysis = sobol.analyze(problem, values, True, num_resamples=2, seed=_SEED)
    pairs = analysis["S2"][np.triu_indices(problem["num_vars"], 1)]
    return np.concatenate([analysis["S1"], analysis["ST"], [analysis["S1"].sum()], pairs])


def smooth_field(shares: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a smooth random field of variance 1 at points (n, k) of the unit cube.

    It is a sum of random waves, with a Gaussian correlation (Rahimi and Recht 2007).
    """
    length = np.exp(rng.uniform(*np.log([LENGTHS[0], _LONGEST])))
    waves = rng.normal(size=(shares.shape[1], _WAVES)) / length
    phases = rng.uniform(0, 2 * np.pi, _WAVES)
    return np.sqrt(2 / _WAVES) * np.cos(shares @ waves + phases).sum(axis=1)


@dataclass(frozen=True)
class DesignRuns:
    """The runs of a design over parameters ``names`` (k), in its order.

    ``values`` are means of the runs (n,), not-a-number for a run that failed, or whose flow has no
    value; ``variances`` (n,) of these are from the scatter between replicates, not-a-number where a
    point has one; ``points`` are numbers (n,), the same for rows that are one point.
    """

    names: tuple[str, ...]
    values: np.ndarray
    variances: np.ndarray
    points: np.ndarray

    @property
    def noise(self) -> np.ndarray:
        """Variance of each mean; the mean of all where it is not known, 0 where none is."""
        is_known = np.isfinite(self.variances)
        common = self.variances[is_known].mean() if is_known.any() else 0.0
        return np.where(is_known, self.variances, common)

    def blocks(self, size: int) -> tuple[np.ndarray, int, float]:
        """Return the rows of each whole block (b, size), how many are not, and the share of noise.

        An estimator needs all of a block. The noise is not-a-number where no point has replicates.
        Raises `Refusal` if fewer than `FEWEST_BLOCKS` blocks are whole, if the values do not vary,
        or if most of their variance is noise.
        """
        rows = np.arange(len(self.values) // size * size).reshape(-1, size)
        whole = rows[np.isfinite(self.values[rows]).all(axis=1)]
        if len(whole) < FEWEST_BLOCKS:
            raise Refusal(
                f"no indices, as {len(whole)} of {len(rows)} blocks of {size} points have a value "
                f"at each and {FEWEST_BLOCKS} are needed; more blocks, other ranges or the key "
                "regimes may give others"
            )
        _require_spread(self.values[whole])
        share = float(self.noise[whole].mean() / self.values[whole].var())
        require_little_noise(share, "no indices")
        is_known = np.isfinite(self.variances[whole]).any()
        return whole, len(rows) - len(whole), share if is_known else np.nan

    def noise_of_difference(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return the variance of the differences between rows: none between equal points."""
        differ = self.points[one] != self.points[other]
        return np.where(differ, self.noise[one] + self.noise[other], 0.0)


def sobol_indices_of_runs(runs: DesignRuns) -> pd.DataFrame:
    """Return first-order and total indices from the runs of a Saltelli design, as a table.

    Intervals are from the scatter between blocks (jackknife), which noise adds to. Raises
    `Refusal`, see `DesignRuns.blocks`.
    """
    rows, left_out, noise = runs.blocks(len(runs.names) + 2)
    first, between, last = rows[:, :1], rows[:, 1:-1], rows[:, -1:]
    count, unlike = len(rows), [_unlike(runs, one, between) for one in (last, first)]
    means = [one.mean(axis=0) for one in unlike]
    others = [(count * mean - one) / (count - 1) for mean, one in zip(means, unlike, strict=True)]
    estimate, half = _with_sum(*means), _half_width(_with_sum(*others))
    basis = {"blocks": count, "left_out": left_out, "noise": noise}
    return tabulate(shares_of(runs.names), estimate, estimate - half, estimate + half, **basis)


def _unlike(runs: DesignRuns, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return what `_with_sum` needs the means of, for pairs of rows in blocks, (b, k, 4)."""
    centred = runs.values - np.nanmean(runs.values)
    x, y = np.broadcast_arrays(centred[one], centred[other])
    square = (x**2 + y**2 - runs.noise[one] - runs.noise[other]) / 2
    apart = ((x - y) ** 2 - runs.noise_of_difference(one, other)) / 2
    return np.stack([x, y, square, apart], axis=-1)


def _with_sum(*means: np.ndarray) -> np.ndarray:
    """Return first-order and total indices and the sum of the first, along the last axis.

    They follow from the shares of the variance in which two runs differ, from means (..., 4).
    """
    x, y, square, apart = np.moveaxis(np.stack(means), -1, 0)
    last, total = apart / (square - ((x + y) / 2) ** 2)
    return np.concatenate([1 - last, total, (1 - last).sum(axis=-1, keepdims=True)], axis=-1)


def _half_width(jackknifed: np.ndarray) -> np.ndarray:
    """Return half widths of intervals, from the estimates (b, ...) without each block in turn."""
    count = len(jackknifed)
    return student(max(_FREEDOM, count / _BLOCKS)) * np.sqrt((count - 1) * jackknifed.var(axis=0))


def morris_indices_of_runs(
    runs: DesignRuns, shares: np.ndarray, places: np.ndarray, is_number: Sequence[bool]
) -> pd.DataFrame:
    """Return Morris' ``mu``, ``mu_star`` and ``sigma`` from the runs of a design, as a table.

    They are in the unit of the observable: its change where a parameter goes from the one end of
    its range to the other; of words, which are not numbers and have no order, to another one.
    Blocks are trajectories of k + 1. ``shares`` are the points in the unit cube as the design asked
    for them, ``places`` those that were run, which may be rounded, (n, k). Raises `Refusal`, see
    `DesignRuns.blocks`, and if a parameter has the same value in all runs.
    """
    rows, left_out, noise = runs.blocks(len(runs.names) + 1)
    one, other = rows[:, :-1], rows[:, 1:]
    changed = np.abs(shares[other] - shares[one]).argmax(axis=-1)
    steps = np.take_along_axis(places[other] - places[one], changed[..., None], axis=-1)[..., 0]
    steps = np.where(np.asarray(is_number)[changed], steps, np.sign(steps))
    parts = []
    for number, name in enumerate(runs.names):
        chosen = (changed == number) & (steps != 0)
        # A pair of points that comes again tells nothing new.
        pairs = np.sort(runs.points[np.stack([one[chosen], other[chosen]], axis=1)], axis=1)
        new = np.unique(pairs, axis=0, return_index=True)[1]
        start, end, step = (array[chosen][new] for array in (one, other, steps))
        if not len(new):
            raise Refusal(
                f"no effects, as {name} has the same value on both sides of each "
                "step; a wider range has more values"
            )
        effects = (runs.values[end] - runs.values[start]) / step
        noises = runs.noise_of_difference(start, end) / step**2
        parts.append(_effects(effects, float(np.mean(noises))))
    estimate, low, high = np.stack(parts, axis=-1).reshape(3, -1)
    labels = [(index, name, "") for index in ("mu", "mu_star", "sigma") for name in runs.names]
    table = tabulate(labels, estimate, low, high, blocks=len(rows), left_out=left_out, noise=noise)
    return table.assign(doubt=np.where(table["low"].isna(), _NO_INTERVAL, ""))


def _effects(effects: np.ndarray, noise: float) -> np.ndarray:
    """Return ``mu``, ``mu_star``, ``sigma`` of different effects (n,), lowest and highest, (3, 3).

    ``noise`` is the mean variance of an effect. Intervals are not-a-number for fewer than
    `_FEWEST_EFFECTS`, and where all effects are equal, unless these are 0.
    """
    count = len(effects)
    moments = _moments(effects, noise)
    ends = np.full((2, 3), np.nan)
    largest = np.abs(effects).max()
    if count >= _FEWEST_EFFECTS and (np.ptp(effects) > _EQUAL * largest or not largest):
        others = np.array([np.delete(effects, left_out) for left_out in range(count)])
        half = _half_width(_moments(others, noise))
        half[1] = np.hypot(half[1], _FOLDED * np.sqrt(noise))
        ends = np.array([moments - half, moments + half])
    rows = np.vstack([moments, ends])
    rows[:, 1:] = np.maximum(0.0, rows[:, 1:])
    rows[:, 2] = np.sqrt(rows[:, 2])
    return rows


def _moments(effects: np.ndarray, noise: float) -> np.ndarray:
    """Return mean, mean size and variance of effects (..., n), without their noise, (..., 3)."""
    sizes = np.sqrt(np.maximum(0.0, effects**2 - noise))
    variance = effects.var(axis=-1, ddof=1) if effects.shape[-1] > 1 else 0.0 * sizes.mean(axis=-1)
    return np.stack([effects.mean(axis=-1), sizes.mean(axis=-1), variance - noise], axis=-1)
