"""Boundaries that were looked for from several starts, joined to one with an honest interval."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sim.base.statistics import student, student_half_width


def over_seeds(
    rows: pd.DataFrame, chosen: pd.DataFrame, settings: Sequence[str]
) -> tuple[float, float, int]:
    """Return value and half width of the 95 % interval of the boundary with the least bracket.

    Then from how many more seeds than one it was looked for. Its own seeds tell how much one start
    differs from another; of a single one the bracket is the interval, each of its ends a bound. It
    is never smaller than that.

    Parameters
    ----------
    rows : pandas.DataFrame
        All boundaries of the kind, with ``low`` and ``high`` finite.
    chosen : pandas.DataFrame
        Those among them that are asked for, one at least.
    settings : sequence of str
        Columns in which boundaries must agree to differ in nothing but the seed.
    """
    bracket = 0.5 * (rows["high"] - rows["low"]).astype(float)
    narrowest = rows.loc[bracket[chosen.index].idxmin()]
    starts = rows[(rows[settings] == narrowest[settings]).all(axis=1)]
    middle = 0.5 * (starts["low"] + starts["high"]).to_numpy(float)
    half_width = float(bracket[starts.index].mean() * student(np.inf) / student(np.inf, sides=1))
    if middle.size > 1:
        half_width = max(half_width, float(student_half_width(middle)))
    return float(middle.mean()), half_width, middle.size - 1
