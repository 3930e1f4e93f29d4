"""Boundaries that were looked for from several starts, joined to one with an honest interval."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sim.base.statistics import student


def over_seeds(
    rows: pd.DataFrame, chosen: pd.DataFrame, settings: Sequence[str]
) -> tuple[float, float, int]:
    """Return value and half width of the 95 % interval of the boundary with the least bracket.

    Then how many boundaries of the kind repeat one with another seed.

    How much one start differs from another is pooled over all boundaries of a kind that were looked
    for from several seeds, and goes into the interval of those with a single one too. Without any,
    the bracket is the interval; it is never smaller than that.

    Parameters
    ----------
    rows : pandas.DataFrame
        All boundaries of the kind, with ``low`` and ``high`` finite.
    chosen : pandas.DataFrame
        Those among them that are asked for, one at least.
    settings : sequence of str
        Columns in which boundaries must agree to differ in nothing but the seed.
    """
    middle = 0.5 * (rows["low"] + rows["high"]).astype(float)
    bracket = 0.5 * (rows["high"] - rows["low"]).astype(float)
    narrowest = rows.loc[bracket[chosen.index].idxmin()]
    starts = rows.index[(rows[settings] == narrowest[settings]).all(axis=1)]
    groups = middle.groupby([rows[name] for name in settings], dropna=False)
    half_width = float(bracket[starts].mean())
    freedom = len(rows) - groups.ngroups
    if freedom:
        variance = ((middle - groups.transform("mean")) ** 2).sum() / freedom
        half_width = max(half_width, float(student(freedom) * np.sqrt(variance / len(starts))))
    return float(middle[starts].mean()), half_width, freedom
