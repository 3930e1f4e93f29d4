"""Boundaries searched from several starts, pooled into one with an honest interval."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sim.base.statistics import student, student_half_width


def pool_seeds(
    rows: pd.DataFrame, candidates: pd.DataFrame, settings: Sequence[str]
) -> tuple[float, float, int]:
    """Return the boundary with the narrowest bracket: value, half width, further seeds.

    The half width is that of the 95 % interval; the last number is that of the seeds less one. The
    seeds show how much starts differ. With a single seed the bracket is the interval, each of its
    ends a bound of one side. The interval is never narrower than that.

    Parameters
    ----------
    rows : pandas.DataFrame
        All boundaries of the kind, with ``low`` and ``high`` finite.
    candidates : pandas.DataFrame
        The rows to choose from, at least one.
    settings : sequence of str
        Columns in which pooled boundaries agree: all parameters but the seed.
    """
    bracket = 0.5 * (rows["high"] - rows["low"]).astype(float)
    narrowest = rows.loc[bracket[candidates.index].idxmin()]
    starts = rows[(rows[settings] == narrowest[settings]).all(axis=1)]
    middle = 0.5 * (starts["low"] + starts["high"]).to_numpy(float)
    half_width = float(bracket[starts.index].mean() * student(np.inf) / student(np.inf, sides=1))
    if middle.size > 1:
        half_width = max(half_width, float(student_half_width(middle)))
    return float(middle.mean()), half_width, middle.size - 1
