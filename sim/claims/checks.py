"""From a measured quantity and its thresholds to a check; votes, parts and several of checks."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import chain
from math import inf, nan

from uncertainties import UFloat

from sim.claims.place import Place
from sim.claims.verdict import INCONCLUSIVE, LONGER_RUNS, REPRODUCED, SIGMAS, Check, Untestable

#: What a judge gets of bounds that are several numbers, or two.
Numbers = Sequence[float]
Pair = tuple[float, float]


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


def at_least(quantity: str, number: int, checks: Sequence[Check]) -> Check:
    """Return the check that at least so many of several checks hold, whichever these are.

    The value shown is how many hold by themselves. That fewer can hold means that all but
    ``number - 1`` of them fail. Checks that decide nothing count as open.
    """
    chances = [(one.p_holds, one.p_fails) if one.can_decide else (1.0, 1.0) for one in checks]
    p_holds, p_fails = zip(*chances, strict=True) if chances else ((), ())
    too_few = conjunction_p(p_fails, len(checks) - number + 1) if len(checks) >= number else 1.0

    return Check(
        what=quantity,
        value=sum(check.verdict == REPRODUCED for check in checks),
        half_width=nan,
        low=number - 0.5,
        high=inf,
        points=_united(check.points for check in checks),
        open_points=_united(check.points for check in checks if check.verdict == INCONCLUSIVE),
        # Looks are in the p-values of the checks already.
        tested=(conjunction_p(p_holds, number), too_few),
        short=_united(check.short for check in checks),
    )


def _united(points: Iterable[Iterable[str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(chain.from_iterable(points)))


def conjunction_p(p_values: Sequence[float], least: int) -> float:
    """Return the p-value that at least so many of several statements are true.

    It is K - u + 1 times the u-th smallest of K p-values (Benjamini and Heller 2008).

    >>> conjunction_p([0.01, 0.5, 0.02], 2)
    0.04
    """
    if least > len(p_values):
        return 1.0
    return min(1.0, (len(p_values) - least + 1) * sorted(p_values)[least - 1])


def correct_for(number: int, check: Check) -> Check:
    """Return a test without an interval as one of several, with Bonferroni's correction."""
    holds, fails = (min(1.0, number * p) for p in check.tested or (1.0, 1.0))
    return replace(check, tested=(holds, fails))
