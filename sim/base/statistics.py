"""The one confidence level of all intervals, and Student's distribution at it."""

import numpy as np

#: Share of cases in which an interval holds the true value.
CONFIDENCE = 0.95

#: Degrees of freedom from which on Student's distribution is the normal one.
MANY = 1e6


def student(freedom: float, number: int = 1, sides: int = 2) -> np.float64:
    """Return the half width of a 95 % interval in standard errors, by Student's distribution.

    Of several intervals, so that all of a ``number`` hold together at 95 % (Bonferroni). One of
    one side is the distance to a bound that holds at 95 %.
    """
    # A run needs it only at its end, and the import takes a quarter of a second.
    from scipy.special import stdtrit

    # As numpy's number it makes single precision double, which a float of Python's would not.
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

    Two replicates or more give Student's interval over them, which knows how much one initial state
    differs from another; where few agree by accident, what each knows of itself still counts:
    the interval is not smaller than that of the mean of their own. A single one has only its own.

    >>> mean_interval(np.array([1.0]), np.array([0.1]))[1]
    'within run'
    """
    own = float(np.sqrt((half_widths**2).sum())) / max(1, values.size)
    if values.size >= 2:
        known = filter(np.isfinite, (float(student_half_width(values)), own))
        return max(known, default=np.nan), "replicates"
    if values.size == 1 and np.isfinite(own):
        return own, "within run"
    return np.nan, "none"
