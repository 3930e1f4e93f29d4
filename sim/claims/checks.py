"""From a measured quantity and its thresholds to a check."""

from collections.abc import Iterable
from math import inf

from uncertainties import UFloat

from sim.claims.place import Place
from sim.claims.verdict import SIGMAS, Check


def within(
    what: str,
    measured: UFloat | float,
    low: float,
    high: float,
    places: Iterable[Place] = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity lies between two thresholds.

    ``measured`` has a standard deviation that stands for its 95 % interval, see
    `sim.claims.place.Place`; a plain number is exact.
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
        freedom=min((place.freedom for place in places), default=inf),
    )


def above(
    what: str,
    measured: UFloat | float,
    threshold: float,
    places: Iterable[Place] = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity exceeds a threshold; arguments as for `within`."""
    return within(what, measured, threshold, inf, places, unit)


def below(
    what: str,
    measured: UFloat | float,
    threshold: float,
    places: Iterable[Place] = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity stays below a threshold; arguments as for `within`."""
    return within(what, measured, -inf, threshold, places, unit)


def reported(what: str, measured: UFloat | float, places: Iterable[Place] = ()) -> Check:
    """Return a check without thresholds, which decides nothing; arguments as for `within`."""
    return within(what, measured, -inf, inf, places)
