"""Checks of a claim, and the verdicts that follow from them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf, isfinite, isnan, nan
from typing import Annotated

from pydantic import AfterValidator, Field
from scipy.special import ndtri, stdtr

from sim.base.errors import printable
from sim.base.plugins import allowed
from sim.base.statistics import CONFIDENCE, MANY, student

VERDICTS = (
    REPRODUCED := "reproduced",
    REPRODUCED_IN_PART := "reproduced in part",
    NOT_REPRODUCED := "not reproduced",
    READING_DEPENDENT := "depends on the reading",
    PROTOCOL_DEPENDENT := "depends on the protocol",
    PAPER_INCONSISTENT := "paper inconsistent",
    INCONCLUSIVE := "inconclusive",
    UNTESTABLE := "untestable",
)

#: Verdict of a check without a vote: it has no thresholds, or another statistic decides.
REPORTED = "reported"

#: How often a verdict may be wrong: a one-sided bound holds at 95 %. A p-value equal to the risk
#: decides: three replicates that all rank above three others have p = 0.05.
RISK = round(1 - CONFIDENCE, 12)

#: Fewer independent samples than this decide nothing.
MIN_SAMPLES = 8

#: Half width of a 95 % interval in standard deviations, rounded as in tables.
SIGMAS = round(float(student(MANY)), 2)

#: End of the reason of a withheld check that longer runs would decide.
LONGER_RUNS = "longer runs"

#: Beyond this factor on the replicates there is no plan: the value lies on its threshold.
MAX_REPLICATE_FACTOR = 1000


class Untestable(Exception):
    """The dataset lacks what a claim is about; the message says what."""


class Ambiguous(Exception):
    """Two points are equally what a judge asks for, and are not one flow; the message names both.

    It is not `Untestable`, so that no judge goes on without the flow.
    """


class Unbounded(Untestable):
    """A boundary was searched and not found: beyond the range or among undecided runs."""


#: Text without control characters and marks of direction, a p-value, and half of an interval.
Line = Annotated[str, AfterValidator(printable)]
Chance = Annotated[float, Field(ge=0, le=1)]
HalfWidth = Annotated[
    float,
    allowed(
        "a number >= 0, or not-a-number",
        lambda width: isinstance(width, int | float) and not width < 0,
    ),
]


@dataclass(frozen=True)
class Check:
    """One measured quantity against its threshold."""

    #: The quantity in words or symbols, its conditions included.
    what: Line
    #: Measured value and half width of its 95 % interval. A statistic that has no interval, that of
    #: a rank test, has ``tested`` instead.
    value: float
    half_width: HalfWidth
    #: The claim holds strictly between them; one of them may be infinite. Both are infinite for a
    #: quantity that is only reported.
    low: float
    high: float
    #: Unit of all four, empty for pure numbers.
    unit: Line = ""
    #: Points measured.
    points: tuple[str, ...] = ()
    #: Independent samples of the point with the fewest; infinite for exact experiments.
    samples: Annotated[float, Field(ge=0)] = inf
    #: Least degrees of freedom of these points, as used for the interval.
    freedom: Annotated[float, Field(gt=0)] = inf
    #: Part of the claim that it tests, where the claim has several parts.
    part: str = ""
    #: Whether it has a vote. A check without one is shown with its thresholds.
    votes: bool = True
    #: Why it decides nothing although it is measured: an unsettled flow, for example.
    withheld: Line = ""
    #: p-values that the claim holds and that it fails, from a test without an interval.
    tested: tuple[Chance, Chance] | None = None
    #: The points among them whose runs are too short.
    short: tuple[str, ...] = ()
    #: Whether its interval is the step of a scan, which more replicates do not narrow.
    coarse: bool = False
    #: How often it has been judged, this time included, with the option of buying more runs where
    #: it is open; 0 in a study that buys none. See `spent`.
    looks: Annotated[int, Field(ge=0)] = 0
    #: The measured value in words, where ± does not say it: counts of runs, lopsided intervals.
    text: Line = ""
    #: The points among them that more replicates would decide; all of them if it is empty.
    open_points: tuple[str, ...] = ()

    @property
    def has_vote(self) -> bool:
        """True where the check has a vote, decided or not."""
        return self.votes and (self.low > -inf or self.high < inf)

    @property
    def can_decide(self) -> bool:
        """True where there is enough data behind the check to decide anything."""
        measured = self.tested is not None or isfinite(self.value + self.half_width)
        return measured and self.samples >= MIN_SAMPLES and not self.withheld

    @cached_property
    def p_holds(self) -> float:
        """p-value of "holds": how often chance alone would be as clear of the outside.

        With two thresholds it is the p-value at the nearer one (two one-sided tests).
        """
        p = max(self._p_beyond(self.value - self.low), self._p_beyond(self.high - self.value))
        return spent(self.tested[0] if self.tested else p, self.looks)

    @cached_property
    def p_fails(self) -> float:
        """p-value of "fails": how often chance alone would be as clear of the allowed range."""
        below, above = self.low - self.value, self.value - self.high
        p = min(self._p_beyond(below, True), self._p_beyond(above, True))
        return spent(self.tested[1] if self.tested else p, self.looks)

    def _p_beyond(self, distance: float, inclusive: bool = False) -> float:
        """Return the p-value of a distance from a threshold.

        An exact value lies beyond the threshold or not; ``inclusive`` counts a value on it as
        beyond. Some intervals are Student's and some are not; those of sums and quotients are
        neither. The result is the larger p-value of Student's and the normal distribution with that
        interval, so it is never too small.
        """
        if not isfinite(self.half_width):
            return 1.0
        if self.half_width == 0:
            return 0.0 if distance > 0 or (inclusive and distance == 0) else 1.0
        p_one_sided = (
            stdtr(freedom, -distance * student(freedom) / self.half_width)
            for freedom in (min(self.freedom, MANY), MANY)
        )
        return float(max(p_one_sided))

    @property
    def bound(self) -> float:
        """Distance from the value to its one-sided bound at 95 %, or what its looks leave of it.

        Both bounds are those of two one-sided tests.
        """
        if not self.looks:
            return self.half_width * float(student(MANY, sides=1) / student(MANY))
        return self.half_width * _clearance(self.looks) / SIGMAS

    @property
    def verdict(self) -> str:
        """Verdict of the check alone: clear of the threshold on one side, on the other, or not."""
        if not self.has_vote:
            return REPORTED
        if not self.can_decide:
            return INCONCLUSIVE
        if self.p_fails <= RISK:
            return NOT_REPRODUCED
        return REPRODUCED if self.p_holds <= RISK else INCONCLUSIVE

    @property
    def replicate_factor(self) -> float:
        """Factor on the number of replicates that would decide the check at its present value.

        NaN where it is decided or needs something other than replicates, infinite where no number
        would decide it. Bounds shrink as one over the root of the number of replicates.
        """
        if self.verdict != INCONCLUSIVE or not self.can_decide:
            return nan
        if self.coarse:
            return inf
        # What the next look may spend of the risk.
        needed_clear = _clearance(self.looks and self.looks + 1)
        if self.tested is not None:
            clear = -float(ndtri(min(self.tested)))
        else:
            ends = [end for end in (self.low, self.high) if isfinite(end)]
            distance = min(abs(self.value - end) for end in ends)
            clear = distance / self.half_width * float(student(MANY))
        needed = (needed_clear / clear) ** 2 if clear > 0 else inf
        return needed if needed <= MAX_REPLICATE_FACTOR else inf


def spent(p: float, looks: int, most: float = 1.0) -> float:
    """Return a p-value that accounts for looking again; unchanged without looks.

    Beds are bought until a claim is decided, so a value on its threshold is looked at until chance
    decides. The k-th look therefore may spend 1/2^k of the 2.5 % that a bound may be wrong over all
    looks: its p-value counts 2^(k+1)-fold against `RISK`. However many looks there are, a value on
    its threshold is decided, either way, in at most 5 of 100 cases.

    >>> spent(0.01, 0), spent(0.01, 1), spent(0.01, 2)
    (0.01, 0.04, 0.08)
    """
    return min(most, p * 2 ** (looks + 1)) if looks else p


def _clearance(looks: int) -> float:
    """Return how clear of a threshold a value must be at a look, in standard deviations."""
    return -float(ndtri(RISK / spent(1.0, looks, most=inf)))


def holm_p(p_list: Sequence[float]) -> float:
    """Return the smallest of several p-values with Holm's correction for their number; 1 for none.

    It is the first p-value that Holm (1979) adjusts: it tests whether any of them is too small for
    chance.

    >>> holm_p([0.01, 0.04, 0.03])
    0.03
    """
    return min(1.0, len(p_list) * min(p_list)) if p_list else 1.0


def combined_verdict(checks: Iterable[Check]) -> str:
    """Return the verdict on one statement: all votes must hold, and one failure refutes it.

    That all hold needs no correction for their number. A failure must be clear with Holm's
    correction. Without any vote the verdict is inconclusive.
    """
    p_holds, p_fails = p_values(checks)
    if p_fails <= RISK:
        return NOT_REPRODUCED
    return REPRODUCED if p_holds <= RISK else INCONCLUSIVE


def p_values(checks: Iterable[Check]) -> tuple[float, float]:
    """Return the p-values that all votes on a statement hold, and that any fails.

    The second one has Holm's correction for multiple tests, which counts withheld votes too: a
    statement that they may refute as well has as many chances to fail.
    """
    votes = [check for check in checks if check.has_vote]
    usable = [check for check in votes if check.can_decide]
    fails = holm_p([check.p_fails if check.can_decide else 1.0 for check in votes])
    is_complete = usable and len(usable) == len(votes)
    return max(check.p_holds for check in usable) if is_complete else 1.0, fails


def verdict_of_parts(parts: Sequence[Sequence[Check]]) -> str:
    """Return the verdict on a claim of several parts, from the votes on each part.

    The claim is reproduced in part where a part is reproduced and another is not, or not yet; that
    any part holds must be clear with Holm's correction. It is not reproduced where no part is: one
    part that fails does not refute the others.
    """
    voting_parts = [checks for checks in parts if checks]
    if not voting_parts:
        return UNTESTABLE
    verdicts = {combined_verdict(checks) for checks in voting_parts}
    if len(verdicts) == 1 and len(voting_parts) == len(parts):
        return verdicts.pop()
    if REPRODUCED in verdicts:
        p_holds = holm_p([p_values(checks)[0] for checks in voting_parts])
        return REPRODUCED_IN_PART if p_holds <= RISK else INCONCLUSIVE
    return INCONCLUSIVE


def plan(check: Check) -> str:
    """Return what would decide an open check; empty if it is decided or does not vote.

    >>> plan(Check("x", 1.5, 1.0, 1.0, inf, freedom=7))
    'about 3 times the replicates'
    """
    if check.verdict != INCONCLUSIVE:
        return ""
    if check.withheld:
        return check.withheld
    if not check.can_decide:
        return "more independent samples: longer runs or more replicates"
    if check.coarse:
        return "finer steps of the scan: its interval is half a step"
    if isnan(check.replicate_factor) or check.replicate_factor == inf:
        return "no number of replicates: the value lies on the threshold"
    return f"about {max(2, ceil(check.replicate_factor))} times the replicates"
