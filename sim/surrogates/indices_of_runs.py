"""What matters, by the runs of a design that is made for it: Sobol' indices and Morris' screening.

Indices are those of Janon et al. 2014, ESAIM: Probab. Stat. 18, 342 (first order: the correlation
of two runs that have the parameter in common) and Jansen 1999, Comput. Phys. Commun. 117, 35
(total: the squared difference of two runs that differ in it alone). The noise of the runs is in
no product of two runs, but adds to squares: its variance is taken off each of them. Morris' mean
and deviation of elementary effects: Campolongo et al. 2007, Environ. Model. Softw. 22, 1509.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim.base.errors import percent
from sim.base.statistics import student
from sim.study.surrogate import FEWEST_BLOCKS
from sim.surrogates.index_table import require_spread, shares_of, tabulate, with_doubts
from sim.surrogates.refusals import Refusal

#: Share of the variance that may come from noise: beyond, nothing is left to share out.
_MOST_NOISE = 0.5

#: Blocks for a degree of freedom of an interval, and fewest degrees. A few blocks hold most of the
#: variance of a ratio; with these, intervals of eight blocks hold the truth as often as they say.
_BLOCKS, _FREEDOM = 4, 3

#: Fewest different effects that give an interval, and difference of equal ones, of their size.
_FEWEST_EFFECTS, _EQUAL = 3, 1e-9
_NO_INTERVAL = "no interval, as effects at different places are equal or too few"

#: How much larger a mean size may be by noise, in its standard deviations, once it is taken off.
_FOLDED = 0.6


@dataclass(frozen=True)
class DesignRuns:
    """The runs of a design, in its order.

    Attributes
    ----------
    names : tuple of str
        The k parameters.
    values : numpy.ndarray
        Means of the runs (n,). Not-a-number stands for a run that failed, or whose flow has no
        value.
    variances : numpy.ndarray
        Variances (n,) of these means, from the scatter between replicates; not-a-number where a
        point has one.
    points : numpy.ndarray
        Numbers (n,), the same for rows that are one point.
    source : str
        What the answer is called, for messages.
    """

    names: tuple[str, ...]
    values: np.ndarray
    variances: np.ndarray
    points: np.ndarray
    source: str

    @property
    def noise(self) -> np.ndarray:
        """Variance of each mean; the mean of all where it is not known, 0 where none is."""
        is_known = np.isfinite(self.variances)
        common = self.variances[is_known].mean() if is_known.any() else 0.0
        return np.where(is_known, self.variances, common)

    def blocks(self, size: int) -> tuple[np.ndarray, int, float]:
        """Return the rows of each whole block (b, size), how many are not, and the share of noise.

        An estimator needs all of a block. The noise is not-a-number where no point has replicates.

        Raises
        ------
        Refusal
            If fewer than `FEWEST_BLOCKS` blocks are whole, if the values do not vary, or if most of
            their variance is noise.
        """
        rows = np.arange(len(self.values) // size * size).reshape(-1, size)
        whole = rows[np.isfinite(self.values[rows]).all(axis=1)]
        if len(whole) < FEWEST_BLOCKS:
            raise Refusal(
                f"{self.source}: no indices, as {len(whole)} of {len(rows)} blocks of {size} "
                f"points have a value at each and {FEWEST_BLOCKS} are needed; more "
                "blocks, other ranges or the key regimes may give others"
            )
        require_spread(self.values[whole], self.source)
        share = float(self.noise[whole].mean() / self.values[whole].var())
        if share > _MOST_NOISE:
            raise Refusal(
                f"{self.source}: no indices, as the noise of the runs is {percent(share)} of "
                f"the variance between them, beyond {percent(_MOST_NOISE)}; more replicates or "
                "longer runs make it smaller"
            )
        is_known = np.isfinite(self.variances[whole]).any()
        return whole, len(rows) - len(whole), share if is_known else np.nan

    def noise_of_difference(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return the variance of the differences between rows: none between equal points."""
        differ = self.points[one] != self.points[other]
        return np.where(differ, self.noise[one] + self.noise[other], 0.0)


def sobol_indices_of_runs(runs: DesignRuns) -> pd.DataFrame:
    """Return first-order and total indices from the runs of a Saltelli design, as a table.

    Intervals are from the scatter between blocks (jackknife), which noise adds to.

    Raises
    ------
    Refusal
        See `DesignRuns.blocks`.
    """
    rows, left_out, noise = runs.blocks(len(runs.names) + 2)
    first, between, last = rows[:, :1], rows[:, 1:-1], rows[:, -1:]
    unlike = [_unlike(runs, one, between) for one in (last, first)]
    means = [one.mean(axis=0) for one in unlike]
    count = len(rows)
    others = [(count * mean - one) / (count - 1) for mean, one in zip(means, unlike, strict=True)]
    estimate, jackknifed = _with_sum(*means), _with_sum(*others)
    half = _half_width(jackknifed, count)
    ends = estimate - half, estimate + half
    table = tabulate(
        shares_of(runs.names), estimate, *ends, blocks=count, left_out=left_out, noise=noise
    )
    return with_doubts(table)


def _unlike(runs: DesignRuns, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return what `_share_unlike` needs the means of, for pairs of rows in blocks, (b, k, 4)."""
    centred = runs.values - np.nanmean(runs.values)
    x, y = np.broadcast_arrays(centred[one], centred[other])
    square = (x**2 + y**2 - runs.noise[one] - runs.noise[other]) / 2
    apart = ((x - y) ** 2 - runs.noise_of_difference(one, other)) / 2
    return np.stack([x, y, square, apart], axis=-1)


def _share_unlike(means: np.ndarray) -> np.ndarray:
    """Return the share of the variance in which two runs differ, from means (..., 4)."""
    x, y, square, apart = np.moveaxis(means, -1, 0)
    return apart / (square - ((x + y) / 2) ** 2)


def _with_sum(last: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return first-order and total indices and the sum of the first, along the last axis."""
    alone, total = 1 - _share_unlike(last), _share_unlike(first)
    return np.concatenate([alone, total, alone.sum(axis=-1, keepdims=True)], axis=-1)


def _half_width(jackknifed: np.ndarray, count: int) -> np.ndarray:
    """Return half widths of intervals, from the estimates without each block in turn."""
    error = np.sqrt((count - 1) * jackknifed.var(axis=0))
    return student(max(_FREEDOM, count / _BLOCKS)) * error


def morris_indices_of_runs(
    runs: DesignRuns, shares: np.ndarray, places: np.ndarray, is_number: Sequence[bool]
) -> pd.DataFrame:
    """Return Morris' ``mu``, ``mu_star`` and ``sigma`` from the runs of a design, as a table.

    They are in the unit of the observable: its change where a parameter goes from the one end of
    its range to the other; of words, to another one.

    Parameters
    ----------
    runs : DesignRuns
        The runs; blocks are trajectories of k + 1.
    shares : numpy.ndarray
        The points in the unit cube as the design asked for them, (n, k).
    places : numpy.ndarray
        The values that were run, which may be rounded, as shares of the ranges, (n, k).
    is_number : sequence of bool
        Which parameters are numbers; others are words or switches, without an order.

    Raises
    ------
    Refusal
        See `DesignRuns.blocks`; if a parameter has the same value in all runs.
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
                f"{runs.source}: no effects, as {name} has the same value on both sides of each "
                "step; a wider range has more values"
            )
        effects = (runs.values[end] - runs.values[start]) / step
        noise_of_effect = np.mean(runs.noise_of_difference(start, end) / step**2)
        parts.append(_effects(effects, float(noise_of_effect)))
    estimate, low, high = np.stack(parts, axis=-1).reshape(3, -1)
    labels = [(index, name, "") for index in ("mu", "mu_star", "sigma") for name in runs.names]
    table = tabulate(labels, estimate, low, high, blocks=len(rows), left_out=left_out, noise=noise)
    table["doubt"] = np.where(table["low"].isna(), _NO_INTERVAL, "")
    return with_doubts(table)


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
        half = _half_width(_moments(others, noise), count)
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
