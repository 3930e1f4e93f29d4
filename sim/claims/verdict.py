"""What a check of a claim is, and which verdict follows from it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING

from uncertainties import UFloat

if TYPE_CHECKING:
    from sim.claims.evidence import Place

REPRODUCED = "reproduced"
NOT_REPRODUCED = "not reproduced"
INCONCLUSIVE = "inconclusive"
UNTESTABLE = "untestable"

VERDICTS = (REPRODUCED, NOT_REPRODUCED, INCONCLUSIVE, UNTESTABLE)

#: Half width of a 95 % interval in standard deviations.
SIGMAS = 1.96

#: Fewer independent samples than this decide nothing.
TOO_FEW = 8


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
        The claim holds strictly between them; one of them may be infinite.
    unit : str
        Unit of all four, empty for pure numbers.
    points : tuple of str
        Points measured.
    samples : float
        Independent samples behind the poorest of these points; infinite for exact experiments.
    """

    what: str
    value: float
    half_width: float
    low: float
    high: float
    unit: str = ""
    points: tuple[str, ...] = ()
    samples: float = inf

    @property
    def verdict(self) -> str:
        """The interval lies between the thresholds, beyond one of them, or across."""
        low, high = self.value - self.half_width, self.value + self.half_width
        if not (isfinite(low) and isfinite(high)) or not self.samples >= TOO_FEW:
            return INCONCLUSIVE
        if self.low < low and high < self.high:
            return REPRODUCED
        return NOT_REPRODUCED if high <= self.low or low >= self.high else INCONCLUSIVE


def within(
    what: str,
    measured: UFloat | float,
    low: float,
    high: float,
    places: "Iterable[Place]" = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity lies between two thresholds.

    ``measured`` has a standard deviation that stands for its 95 % interval, see
    `sim.claims.evidence.Place`; a plain number is exact.
    """
    places = tuple(places)
    return Check(
        what=what,
        value=float(getattr(measured, "nominal_value", measured)),
        half_width=SIGMAS * float(getattr(measured, "std_dev", 0.0)),
        low=low,
        high=high,
        unit=unit,
        points=tuple(dict.fromkeys(place.id for place in places)),
        samples=min((place.samples for place in places), default=inf),
    )


def above(
    what: str,
    measured: UFloat | float,
    threshold: float,
    places: "Iterable[Place]" = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity exceeds a threshold; arguments as for `within`."""
    return within(what, measured, threshold, inf, places, unit)


def below(
    what: str,
    measured: UFloat | float,
    threshold: float,
    places: "Iterable[Place]" = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity stays below a threshold; arguments as for `within`."""
    return within(what, measured, -inf, threshold, places, unit)


def worst(verdicts: Sequence[str]) -> str:
    """Return the verdict on all: one failure fails them all, none at all is inconclusive."""
    if NOT_REPRODUCED in verdicts:
        return NOT_REPRODUCED
    return REPRODUCED if verdicts and set(verdicts) == {REPRODUCED} else INCONCLUSIVE
