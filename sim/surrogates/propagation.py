"""How an observable is spread where parameters are: mean, deviation, quantiles, exceedance.

Of runs, intervals take these for independent draws, which a design that spreads them evenly
betters: Student's of the mean; of the deviation Bonett's, for other than normal values (2006,
Comput. Stat. Data Anal. 50, 775), with few degrees of freedom; of a quantile two of the sorted
values (Conover 1999, Practical Nonparametric Statistics, section 3.2); of a probability Clopper and
Pearson's. The noise of the runs is taken off their variance, and the values are drawn together by
as much.

Of a surrogate they are those of realisations of it: its mean plus its error times a smooth random
field, as sensitivities have them.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sim.base.statistics import CONFIDENCE, MANY, student, student_half_width
from sim.study.design import Axis, read_comparison
from sim.study.questions import FEWEST_BLOCKS
from sim.surrogates.answers import Refusal
from sim.surrogates.indices import (
    DesignRuns,
    require_learned,
    require_little_noise,
    smooth_field,
    tabulate,
)
from sim.surrogates.sample import unscaled
from sim.surrogates.surrogate import Surrogate

#: Draws of a sample of a surrogate, a power of two; samples, and realisations for each.
DRAWS, _SCRAMBLINGS, _REALISATIONS = 2**12, 8, 16

#: Share of the points of the design without a value beyond which there is no spread.
_MOST_LEFT_OUT = 0.5

#: Runs for a degree of freedom of the interval of a deviation, and fewest degrees: with these it
#: holds an exponential distribution's as often as it says. Kurtosis of a tail so long that it does
#: not, and what is said of it.
_RUNS, _FREEDOM, _LONG_TAIL = 8, 3, 6.0
_TAILED = "a long tail, of which its interval holds less often than 95 %"

#: Probability below and above an interval.
_TAIL = (1 - CONFIDENCE) / 2


def labels(quantiles: Sequence[float], exceeds: Sequence[float]) -> list[tuple[str, str, str]]:
    """Return what the rows of a table are of: mean, deviation, quantiles, probabilities."""
    asked = [("quantile", level) for level in quantiles] + [("exceedance", x) for x in exceeds]
    rows = (("mean", "", ""), ("deviation", "", ""))
    return [*rows, *((index, f"{number:.10g}", "") for index, number in asked)]


def spread_of_runs(
    runs: DesignRuns, quantiles: Sequence[float], exceeds: Sequence[float]
) -> pd.DataFrame:
    """Return the spread of the runs of a design, as `sim.surrogates.indices.tabulate` does.

    A quantile of which too few runs give an interval has no value. Raises `Refusal` where too few
    runs have a value, or most of their variance is noise.
    """
    is_known = np.isfinite(runs.values)
    values, count, total = runs.values[is_known], int(is_known.sum()), len(is_known)
    if count < max(FEWEST_BLOCKS, (1 - _MOST_LEFT_OUT) * total):
        raise Refusal(
            f"no spread, as {count} of {total} points have a value, and {FEWEST_BLOCKS} and half "
            "of them are needed; other ranges or the key regimes may give others"
        )
    variance, noise = float(values.var(ddof=1)), float(runs.noise[is_known].mean())
    share = noise / variance if variance else 0.0
    require_little_noise(share, "no spread")
    mean = values.mean()
    drawn = np.sort(mean + np.sqrt(1 - share) * (values - mean))
    half = float(student_half_width(values))
    rows = [(mean, mean - half, mean + half), _deviation(values, noise)]
    rows += [_quantile(drawn, level) for level in quantiles]
    rows += [_exceedance(int((drawn > value).sum()), count) for value in exceeds]
    known = np.isfinite(runs.variances[is_known]).any()
    basis: dict[str, Any] = {"left_out": total - count, "noise": share if known else np.nan}
    table = tabulate(labels(quantiles, exceeds), *np.array(rows).T, blocks=count, **basis)
    fourth = float(((values - mean) ** 4).mean())
    if fourth > _LONG_TAIL * float(values.var()) ** 2:
        table.loc[table["index"] == "deviation", "doubt"] = _TAILED
    few = table["value"].isna() & (table["index"] == "quantile")
    levels = table["parameter"][few].astype(float)
    fewest = np.ceil(np.log(_TAIL) / np.log(np.maximum(levels, 1 - levels)))
    doubt = "without a value, which takes {:,.0f} runs or more"
    table.loc[few, "doubt"] = fewest.map(doubt.format)
    return table


def _deviation(values: np.ndarray, noise: float) -> tuple[float, float, float]:
    """Return the standard deviation without noise, and the ends of Bonett's interval."""
    count, variance = len(values), float(values.var(ddof=1))
    if not variance:
        return 0.0, 0.0, 0.0
    z = float(student(max(_FREEDOM, count / _RUNS)))
    cut = int(count / (2 * np.sqrt(max(count - 4, 1))))
    trimmed = np.sort(values)[cut : count - cut].mean()
    fourth = count * ((values - trimmed) ** 4).sum() / ((values - values.mean()) ** 2).sum() ** 2
    factor = count / (count - float(student(MANY)))
    error = factor * np.sqrt(max(0.0, fourth - (count - 3) / count) / (count - 1))
    ends = factor * variance * np.exp([-z * error, z * error])
    low, high = np.sqrt(np.maximum(0.0, ends - noise))
    return float(np.sqrt(max(0.0, variance - noise))), float(low), float(high)


def _quantile(values: np.ndarray, level: float) -> tuple[float, float, float]:
    """Return a quantile of sorted values and an interval; not-a-number where they are too few."""
    from scipy.stats import binom

    count = len(values)
    low, high = (int(rank) for rank in binom.ppf([_TAIL, 1 - _TAIL], count, level))
    if low < 1 or high >= count:
        return np.nan, np.nan, np.nan
    value = float(np.quantile(values, level, method="median_unbiased"))
    return value, float(values[low - 1]), float(values[high])


def _exceedance(above: int, count: int) -> tuple[float, float, float]:
    """Return the share of values above, and Clopper and Pearson's interval of its probability."""
    from scipy.special import betaincinv

    low = betaincinv(above, count - above + 1, _TAIL) if above else 0.0
    high = betaincinv(above + 1, count - above, 1 - _TAIL) if above < count else 1.0
    return above / count, float(low), float(high)


def spread_of_surrogate(
    surrogate: Surrogate,
    axes: Sequence[Axis],
    where: Sequence[str],
    quantiles: Sequence[float],
    exceeds: Sequence[float],
    draws: int = DRAWS,
) -> pd.DataFrame:
    """Return the spread of a surrogate whose parameters are spread as ``axes`` say.

    Draws satisfy the conditions ``where``. Raises `Refusal` where the surrogate has not learned its
    function, or is of other flows than are likely at the draws.
    """
    rng, rows, absent = np.random.default_rng(1), list[np.ndarray](), 0.0
    for seed in range(1, _SCRAMBLINGS + 1):
        x = _draw(axes, where, draws, seed)
        if not rows:
            absent = require_learned(surrogate, x, "no spread")
        mean, error = surrogate.predict(x)
        shares = unscaled(x, surrogate.bounds, surrogate.scales)
        for _ in range(_REALISATIONS):
            values = np.sort(mean + error * smooth_field(shares, rng))
            rows.append(np.array(list(_statistics(values, quantiles, exceeds))))
    table = np.array(rows)
    value, half = table.mean(axis=0), float(student(MANY)) * table.std(axis=0, ddof=1)
    low, high = value - half, value + half
    number = _SCRAMBLINGS * draws
    for row in range(2 + len(quantiles), len(value)):
        ends = np.quantile(table[:, row], [_TAIL, 1 - _TAIL])
        _, least, most = _exceedance(round(value[row] * number), number)
        low[row], high[row] = min(least, ends[0]), max(most, ends[1])
    low[1] = max(0.0, low[1])
    basis = {"blocks": number, "error": surrogate.error, "absent": absent}
    return tabulate(labels(quantiles, exceeds), value, low, high, **basis)


def _statistics(
    values: np.ndarray, quantiles: Sequence[float], exceeds: Sequence[float]
) -> Iterator[float]:
    yield values.mean()
    yield values.std()
    yield from np.quantile(values, quantiles)
    yield from (float((values > value).mean()) for value in exceeds)


def _draw(axes: Sequence[Axis], where: Sequence[str], draws: int, seed: int) -> np.ndarray:
    """Return values of parameters (n, k) that are spread as axes say, and satisfy conditions."""
    from scipy.stats import qmc

    shares = qmc.Sobol(len(axes), rng=seed).random(draws)
    pairs = zip(axes, shares.T, strict=True)
    columns = {axis.name: np.array(axis.values(column), float) for axis, column in pairs}
    conditions = [one.satisfied(columns) for text in where if (one := read_comparison(text))]
    x = np.column_stack(list(columns.values()))
    return x[np.all(conditions, axis=0)] if conditions else x
