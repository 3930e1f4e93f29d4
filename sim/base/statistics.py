"""The one confidence level of all intervals, and Student's distribution at it."""

import numpy as np

#: Share of cases in which an interval holds the true value.
CONFIDENCE = 0.95


def student(freedom: float, number: int = 1) -> np.float64:
    """Return the half width of a 95 % interval in standard errors, by Student's distribution.

    Of several intervals, so that all of a ``number`` hold together at 95 % (Bonferroni).
    """
    # A run needs it only at its end, and the import takes a quarter of a second.
    from scipy.special import stdtrit

    # As numpy's number it makes single precision double, which a float of Python's would not.
    return stdtrit(freedom, 1 - (1 - CONFIDENCE) / (2 * number))
