"""Helpers for several flows: bounds on many differences at once, means over flows."""

from collections.abc import Mapping, Sequence

import numpy as np
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.checks import remove_votes, within
from sim.claims.place import Place, with_interval
from sim.claims.verdict import RISK, Check


def pooled_checks(
    quantity: str, flows: Mapping[float, Place], values: Sequence[UFloat], largest: float
) -> list[Check]:
    """Return the checks that a quantity deviates from zero by less than ``largest`` at all depths.

    The mean over the flows decides, with equal weights: weights from the errors of a few replicates
    would favour flows that seem certain by chance. A single flow has a vote only where it is
    clearly beyond the bounds, with Bonferroni's correction. Otherwise it is shown without a vote.
    """
    mean = sum(values) / len(values)
    flow_checks = [
        within(f"{quantity}, n = {n:g}", value, -largest, largest, [place])
        for (n, place), value in zip(flows.items(), values, strict=True)
    ]
    mean_check = within(f"{quantity}, {len(flows)} depths", mean, -largest, largest, flows.values())
    risk_each = RISK / (len(flow_checks) + 1)
    return [
        mean_check,
        *(
            check if check.p_fails < risk_each else remove_votes([check])[0]
            for check in flow_checks
        ),
    ]


def mean_of_others(rows: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return for each replicate along an axis the mean of all others; a single one its own.

    Other replicates select the largest of many quantities, and the replicate itself gives its size.
    So the choice of the largest adds no bias.
    """
    number = rows.shape[axis]
    return (rows.sum(axis=axis, keepdims=True) - rows) / (number - 1) if number > 1 else rows


def smallest_mean(rows: np.ndarray) -> UFloat:
    """Return the smallest of the means of many quantities, with an interval that holds for all.

    Parameters
    ----------
    rows : (R, B) array
        B quantities of R replicates.

    Notes
    -----
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
