"""What a check of a claim is, and which verdict follows from it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite

from sim.base.statistics import student

REPRODUCED = "reproduced"
NOT_REPRODUCED = "not reproduced"
INCONCLUSIVE = "inconclusive"
UNTESTABLE = "untestable"

#: Of a check without thresholds, which decides nothing.
REPORTED = "reported"

VERDICTS = (REPRODUCED, NOT_REPRODUCED, INCONCLUSIVE, UNTESTABLE)

#: Fewer independent samples than this decide nothing.
TOO_FEW = 8

#: Degrees of freedom from which on Student's distribution is the normal one.
_MANY = 1e6

#: Half width of a 95 % interval in standard deviations, as tables have it.
SIGMAS = round(float(student(_MANY)), 2)


class Untestable(Exception):
    """The dataset lacks what a claim is about; the message says what."""


class Unbounded(Untestable):
    """A boundary was looked for and not found, beyond the range or among undecided runs."""


@dataclass(frozen=True)
class Check:
    """One measured quantity against its threshold.

    Attributes
    ----------
    what : str
        The quantity in words or symbols, its conditions included.
    value, half_width : float
        Measured value and half width of its 95 % interval, in ``unit``.
    low, high : float
        The claim holds strictly between them; one of them may be infinite. A quantity that is
        only reported has no finite one.
    unit : str
        Unit of all four, empty for pure numbers.
    points : tuple of str
        Points measured.
    samples : float
        Independent samples behind the poorest of these points; infinite for exact experiments.
    freedom : float
        Degrees of freedom of the interval, those of the poorest of these points.
    """

    what: str
    value: float
    half_width: float
    low: float
    high: float
    unit: str = ""
    points: tuple[str, ...] = ()
    samples: float = inf
    freedom: float = inf

    @property
    def verdict(self) -> str:
        """The interval lies between the thresholds, beyond one of them, or across."""
        if self.low == -inf and self.high == inf:
            return REPORTED
        low, high = self.value - self.half_width, self.value + self.half_width
        if not (isfinite(low) and isfinite(high)) or not self.samples >= TOO_FEW:
            return INCONCLUSIVE
        if self.low < low and high < self.high:
            return REPRODUCED
        return NOT_REPRODUCED if self.fails_among(1) else INCONCLUSIVE

    def fails_among(self, number: int) -> bool:
        """Return whether the quantity is clear of the allowed range as one of several checks.

        One of many checks fails by chance more often than a single one, so the interval widens
        with their number (Bonferroni), the more the fewer replicates it comes from.
        """
        freedom = min(self.freedom, _MANY)
        wider = student(freedom, number) / student(freedom)
        half_width = self.half_width * float(wider)
        return self.value + half_width <= self.low or self.value - half_width >= self.high


def together(checks: Sequence[Check]) -> str:
    """Return the verdict on a claim: all of its checks must hold, and one that fails is enough.

    That one must fail as one of so many. Checks that only report are left out; none at all is
    inconclusive.
    """
    deciding = [check for check in checks if check.verdict != REPORTED]
    found = {check.verdict for check in deciding}
    failing = [check for check in deciding if check.verdict == NOT_REPRODUCED]
    if any(check.fails_among(len(deciding)) for check in failing):
        return NOT_REPRODUCED
    return REPRODUCED if found == {REPRODUCED} else INCONCLUSIVE
