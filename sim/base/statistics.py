"""Statistics of replicates: intervals at one confidence level, and orders of single runs."""

from collections.abc import Sequence

import numpy as np

#: Share of cases in which an interval holds the true value.
CONFIDENCE = 0.95

#: Degrees of freedom above which Student's distribution is taken at this value (normal).
MANY = 1e6


def student(freedom: float, number: int = 1, sides: int = 2) -> np.float64:
    """Return the half width of a 95 % interval in standard errors, by Student's distribution.

    With ``number`` intervals, all hold together at 95 % (Bonferroni). With one side, it is the
    distance to a one-sided 95 % bound.
    """
    # Imported here: it takes a quarter of a second, and a run needs it only at its end.
    from scipy.special import stdtrit

    # The result is a number of NumPy: it turns single precision into double, a Python float not.
    return stdtrit(min(freedom, MANY), 1 - (1 - CONFIDENCE) / (sides * number))


def student_half_width(values: np.ndarray) -> np.ndarray:
    """Return the half width of Student's 95 % interval of the mean, along the first axis.

    Not-a-number for fewer than two values.
    """
    if len(values) < 2:
        return np.full(values.shape[1:], np.nan)
    return student(len(values) - 1) * values.std(axis=0, ddof=1) / np.sqrt(len(values))


def mean_interval(values: np.ndarray, half_widths: np.ndarray) -> tuple[float, str]:
    """Return the half width of the 95 % interval of a mean over replicates, and its kind.

    Two or more replicates give Student's interval over them, which includes the scatter between
    initial states. Few replicates may agree by accident, so the interval is at least that of the
    mean of their own intervals. A single replicate has only its own.

    >>> mean_interval(np.array([1.0]), np.array([0.1]))[1]
    'within run'
    """
    own = float(np.sqrt((half_widths**2).sum())) / max(1, values.size)
    if values.size >= 2:
        candidates = filter(np.isfinite, (float(student_half_width(values)), own))
        return max(candidates, default=np.nan), "replicates"
    if values.size == 1 and np.isfinite(own):
        return own, "within run"
    return np.nan, "none"


def share_of_rises(groups: Sequence[np.ndarray]) -> tuple[float, float]:
    """Return how often one value of each group, drawn at random, rises throughout.

    A paper that has one run per point can say "increases monotonically" of such a draw alone. The
    ``groups`` are the replicates (R,) of each point, in the order of the points. Returns the share
    of all choices of one value per group, and its standard error by the jackknife over the values
    of all groups.
    """
    share, variance = _share_of_rises(groups), 0.0
    for number, group in enumerate(groups):
        others = [
            _share_of_rises([*groups[:number], np.delete(group, left_out), *groups[number + 1 :]])
            for left_out in range(group.size)
        ]
        variance += (group.size - 1) * float(np.var(others))
    return share, float(np.sqrt(variance))


def _share_of_rises(groups: Sequence[np.ndarray]) -> float:
    below, share = np.array([-np.inf]), np.array([1.0])
    for group in groups:
        share = (share * (below < group[:, None])).sum(axis=1) / group.size
        below = group
    return float(share.sum())
