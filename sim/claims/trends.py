"""What judges of several flows share: all of many differences at once, means over flows."""

from collections.abc import Mapping, Sequence

import numpy as np
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.checks import beside, within
from sim.claims.place import Place, measured
from sim.claims.verdict import RISK, Check


def pooled(
    what: str, flows: Mapping[float, Place], values: Sequence[UFloat], low: float, high: float
) -> list[Check]:
    """Return the checks that a quantity lies within bounds in flows of many depths.

    The mean of all decides, in which each counts alike: weights from the errors of a few replicates
    would favour what seems sure by chance. A single flow counts where it is clearly
    beyond the bounds as one of so many, and is shown otherwise.
    """
    mean = sum(values) / len(values)
    single = [
        within(f"{what}, n = {n:g}", value, low, high, [place])
        for (n, place), value in zip(flows.items(), values, strict=True)
    ]
    every = within(f"{what}, {len(flows)} depths", mean, low, high, flows.values())
    clear = RISK / (len(single) + 1)
    return [every, *(one if one.failing < clear else beside([one])[0] for one in single)]


def mean_of_others(rows: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return for each replicate along an axis the mean of all others; a single one its own.

    What is largest among many quantities is told by the others, and how large by the replicate
    itself, so that chance, which makes the largest of many, adds nothing.
    """
    number = rows.shape[axis]
    return (rows.sum(axis=axis, keepdims=True) - rows) / (number - 1) if number > 1 else rows


def least(rows: np.ndarray) -> UFloat:
    """Return the least of the means of many quantities, with an interval that holds for all.

    Parameters
    ----------
    rows : (R, B) array
        B quantities of R replicates.

    Notes
    -----
    The intervals are Student's at a level divided by B (Bonferroni), so that all B hold together at
    95 %. One that is clearly negative is returned first; else the one that is lowest with its
    interval. So all are positive only if this one is, and one is negative if this one is.
    """
    replicates, number = rows.shape
    means = rows.mean(axis=0)
    if replicates < 2:
        return measured(float(means.min()), np.inf)
    widths = student(replicates - 1, number) * rows.std(axis=0, ddof=1) / np.sqrt(replicates)
    worst = np.argmin(means + widths)
    if means[worst] + widths[worst] >= 0:
        worst = np.argmin(means - widths)
    return measured(float(means[worst]), float(widths[worst]))
