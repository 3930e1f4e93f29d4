"""From a measured quantity and its thresholds to a check; votes and parts of checks."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import inf

from uncertainties import UFloat

from sim.claims.place import Place
from sim.claims.verdict import LONGER_RUNS, SIGMAS, Check, Untestable


def within(
    what: str,
    measured: UFloat | float,
    low: float,
    high: float,
    places: Iterable[Place] = (),
    unit: str = "",
) -> Check:
    """Return the check that a quantity lies between two thresholds.

    The standard deviation of ``measured`` stands for its 95 % interval, see
    `sim.claims.place.Place`. A plain number is exact.
    """
    places = tuple(places)
    return Check(
        what=what,
        value=float(getattr(measured, "nominal_value", measured)),
        half_width=SIGMAS * float(getattr(measured, "std_dev", 0.0)),
        low=float(low),
        high=float(high),
        unit=unit,
        points=tuple(dict.fromkeys(place.id for place in places)),
        samples=min((place.samples for place in places), default=inf),
        freedom=min((place.freedom for place in places), default=inf),
        looks=max((place.looks for place in places), default=0),
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


def reported(
    what: str, measured: UFloat | float, places: Iterable[Place] = (), unit: str = ""
) -> Check:
    """Return a check without thresholds, which decides nothing; arguments as for `within`."""
    return within(what, measured, -inf, inf, places, unit)


def remove_votes(checks: Iterable[Check]) -> list[Check]:
    """Return the checks without a vote; they are still shown with their thresholds."""
    return [replace(check, votes=False) for check in checks]


def withhold(checks: Iterable[Check], reason: str) -> list[Check]:
    """Return checks that decide nothing for a reason; unchanged checks if it is empty."""
    return [
        replace(
            check,
            withheld=reason or check.withheld,
            short=check.points if LONGER_RUNS in reason else check.short,
        )
        for check in checks
    ]


def judge_parts(**judges: Callable[[], Iterable[Check]]) -> list[Check]:
    """Return the checks on the parts of a claim, each part judged by its own function.

    A part without data has no checks. Raises `Untestable` if no part has any.
    """
    checks, reasons = [], []
    for part, judge in judges.items():
        try:
            checks += [replace(check, part=part) for check in judge()]
        except Untestable as error:
            reasons.append(f"{part}: {error}")
    if not checks:
        raise Untestable("; ".join(reasons))
    return checks
