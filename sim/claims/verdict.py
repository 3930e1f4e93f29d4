"""What a check of a claim is, and which verdict follows from it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, inf, isfinite, isnan, nan

from scipy.special import ndtri, stdtr

from sim.base.statistics import CONFIDENCE, MANY, student

REPRODUCED = "reproduced"
IN_PART = "reproduced in part"
NOT_REPRODUCED = "not reproduced"
ON_THE_READING = "depends on the reading"
PAPER_INCONSISTENT = "paper inconsistent"
INCONCLUSIVE = "inconclusive"
UNTESTABLE = "untestable"

#: Of a check that does not vote: without thresholds, or beside the statistic that decides.
REPORTED = "reported"

VERDICTS = (
    REPRODUCED,
    IN_PART,
    NOT_REPRODUCED,
    ON_THE_READING,
    PAPER_INCONSISTENT,
    INCONCLUSIVE,
    UNTESTABLE,
)

#: How often a verdict may be wrong: a bound of one side holds at 95 %. At the risk itself it is
#: decided: three replicates that all rank above three others have p = 0.05.
RISK = round(1 - CONFIDENCE, 12)

#: Fewer independent samples than this decide nothing.
TOO_FEW = 8

#: Half width of a 95 % interval in standard deviations, as tables have it.
SIGMAS = round(float(student(MANY)), 2)

#: How the reason ends why a check is withheld that longer runs would decide.
LONGER = "longer runs"

#: More than so many times the replicates is no plan: the value lies on its threshold.
NO_PLAN = 1000


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
        Measured value and half width of its 95 % interval, in ``unit``. A statistic that has no
        interval, that of a rank test, has ``tested`` instead.
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
        Least degrees of freedom behind the interval, those of the poorest of these points.
    part : str
        Part of the claim that it is on, where the claim says more than one thing.
    votes : bool
        Whether it decides. Others are shown with their threshold.
    withheld : str
        Why it decides nothing although it is measured: a flow that has not settled, say.
    tested : (float, float), optional
        How often chance alone would be as clear that the claim holds, and that it fails.
    short : tuple of str
        Of the points those that have been watched for too short a time.
    coarse : bool
        Whether its interval is the step of a scan, which more replicates leave as it is.
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
    part: str = ""
    votes: bool = True
    withheld: str = ""
    tested: tuple[float, float] | None = None
    short: tuple[str, ...] = ()
    coarse: bool = False

    @property
    def deciding(self) -> bool:
        """Whether it has a vote, decided or not."""
        return self.votes and (self.low > -inf or self.high < inf)

    @property
    def known(self) -> bool:
        """Whether there is enough behind it to decide anything."""
        measured = self.tested is not None or isfinite(self.value + self.half_width)
        return measured and self.samples >= TOO_FEW and not self.withheld

    @property
    def holding(self) -> float:
        """Probability of being so clear of the thresholds' outside were it there: p of "holds".

        With two thresholds that of the nearer one (two one-sided tests).
        """
        if self.tested is not None:
            return self.tested[0]
        return max(self._beyond(self.value - self.low), self._beyond(self.high - self.value))

    @property
    def failing(self) -> float:
        """Probability of being so clear of the allowed range were it in it: p of "fails"."""
        if self.tested is not None:
            return self.tested[1]
        below, above = self.low - self.value, self.value - self.high
        return min(self._beyond(below, True), self._beyond(above, True))

    def _beyond(self, distance: float, on_it: bool = False) -> float:
        """Return p of a distance from a threshold; an exact one is beyond it or not, or ``on_it``.

        Intervals are Student's or not, those of sums and quotients neither; p is the larger of what
        Student's and the normal distribution with that interval give, so it is never too small.
        """
        if not isfinite(self.half_width):
            return 1.0
        if self.half_width == 0:
            return 0.0 if distance > 0 or (on_it and distance == 0) else 1.0
        chances = (
            stdtr(freedom, -distance * student(freedom) / self.half_width)
            for freedom in (min(self.freedom, MANY), MANY)
        )
        return float(max(chances))

    @property
    def bound(self) -> float:
        """Distance from the value to a bound of one side that holds at 95 %.

        Both bounds are those of two one-sided tests.
        """
        return self.half_width * float(student(MANY, sides=1) / student(MANY))

    @property
    def verdict(self) -> str:
        """What it says by itself: clear of the threshold on one side, on the other, or neither."""
        if not self.deciding:
            return REPORTED
        if not self.known:
            return INCONCLUSIVE
        if self.failing <= RISK:
            return NOT_REPRODUCED
        return REPRODUCED if self.holding <= RISK else INCONCLUSIVE

    @property
    def times(self) -> float:
        """Times as many replicates that would decide it, were the value what it is now.

        NaN where it is decided or waits for something else, infinite where no number would. Bounds
        close in as one over the root of the replicates.
        """
        if self.verdict != INCONCLUSIVE or not self.known:
            return nan
        if self.coarse:
            return inf
        if self.tested is not None:
            clear = -float(ndtri(min(self.tested)))
            needed = (float(student(MANY, sides=1)) / clear) ** 2 if clear > 0 else inf
        else:
            ends = [end for end in (self.low, self.high) if isfinite(end)]
            distance = min(abs(self.value - end) for end in ends)
            needed = (self.bound / distance) ** 2 if distance else inf
        return needed if needed <= NO_PLAN else inf


def least(chances: Sequence[float]) -> float:
    """Return the smallest of several p-values, as that of one of so many; 1 for none.

    It is the first of those that Holm (1979) adjusts: whether any is too small by chance.

    >>> least([0.01, 0.04, 0.03])
    0.03
    """
    return min(1.0, len(chances) * min(chances)) if chances else 1.0


def together(checks: Iterable[Check]) -> str:
    """Return the verdict on one statement: all votes must hold, one that fails is enough.

    That all hold needs no correction for their number. That one fails must be clear as one of so
    many (Holm). Without any vote it is inconclusive.
    """
    holds, fails = chances(checks)
    if fails <= RISK:
        return NOT_REPRODUCED
    return REPRODUCED if holds <= RISK else INCONCLUSIVE


def chances(checks: Iterable[Check]) -> tuple[float, float]:
    """Return the p-values that all votes on a statement hold, and that one of so many fails."""
    deciding = [check for check in checks if check.deciding]
    known = [check for check in deciding if check.known]
    fails = least([check.failing for check in known])
    every = known and len(known) == len(deciding)
    return max(check.holding for check in known) if every else 1.0, fails


def of_parts(parts: Sequence[Sequence[Check]]) -> str:
    """Return the verdict on a claim that says several things from the votes on each of its parts.

    It is reproduced in part where one at least is and another is not, or not yet. That one of them
    holds, or that one fails, must be clear as one of so many (Holm).
    """
    voted = [checks for checks in parts if checks]
    if not voted:
        return UNTESTABLE
    verdicts = [together(checks) for checks in voted]
    if len(voted) == len(parts) and set(verdicts) == {REPRODUCED}:
        return REPRODUCED
    if REPRODUCED in verdicts:
        holds = least([chances(checks)[0] for checks in voted])
        return IN_PART if holds <= RISK else INCONCLUSIVE
    fails = least([chances(checks)[1] for checks in voted])
    return NOT_REPRODUCED if fails <= RISK else INCONCLUSIVE


def plan(check: Check) -> str:
    """Say what would decide an open check, empty for one that is decided or does not vote.

    >>> plan(Check("x", 1.5, 1.0, 1.0, inf, freedom=7))
    'about 3 times the replicates'
    """
    if check.verdict != INCONCLUSIVE:
        return ""
    if check.withheld:
        return check.withheld
    if not check.known:
        return "more independent samples: longer runs or more replicates"
    if check.coarse:
        return "finer steps of the scan: its interval is half a step"
    if isnan(check.times) or check.times == inf:
        return "no number of replicates: the value lies on the threshold"
    return f"about {max(2, ceil(check.times))} times the replicates"
