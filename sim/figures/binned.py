"""Means of scattered points in groups of neighbours along an axis, with 95 % intervals."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from sim.base.statistics import student_half_width

#: Fewest and most groups, and fewest points of a value of x that is a group of its own.
_FEWEST, _MOST, _OF_ONE_VALUE = 3, 10, 3

#: What captions say of the groups.
GROUPS = "groups of points that are neighbours along x"


def binned_means(x: pd.Series, y: pd.Series, *, log: bool = False) -> pd.DataFrame:
    """Return the mean of ``y`` in groups of points that are neighbours in ``x``.

    There are about as many groups as points in each. Where x has few values, each is a group.

    Parameters
    ----------
    x, y : pandas.Series
        Coordinates of points; those without both are left out.
    log : bool
        Whether the means are those of the logarithm.

    Returns
    -------
    pandas.DataFrame
        A row per group in the order of x: ``from``, ``to`` and the mean ``x``, the ``mean`` with
        the ends ``low`` and ``high`` of Student's 95 % interval (not-a-number for one point), and
        the number of ``points``.
    """
    known = pd.DataFrame({"x": x, "y": np.log(y) if log else y}).dropna()
    if known["x"].nunique() * _OF_ONE_VALUE <= len(known):
        groups = known["x"]
    else:
        number = int(np.clip(round(len(known) ** 0.5), _FEWEST, _MOST))
        groups = pd.qcut(known["x"].rank(method="first"), number, labels=False)
    rows = []
    for _, group in known.groupby(groups):
        mean, half = group["y"].mean(), float(student_half_width(group["y"].to_numpy()))
        ends = np.array([mean, mean - half, mean + half])
        values = np.exp(ends) if log else ends
        rows.append([group["x"].min(), group["x"].max(), group["x"].mean(), *values, len(group)])
    return pd.DataFrame(rows, columns=["from", "to", "x", "mean", "low", "high", "points"])


def draw_running_mean(axes: Axes, x: pd.Series, y: pd.Series, *, log: bool) -> None:
    """Draw a line through the means of `binned_means`, and a band of their intervals."""
    means = binned_means(x, y, log=log)
    axes.fill_between(
        means["x"], means["low"], means["high"], color="#000000", alpha=0.13, linewidth=0, zorder=1
    )
    axes.plot(means["x"], means["mean"], color="#333333", linewidth=1.6, zorder=2.5)
