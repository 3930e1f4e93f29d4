"""Locate the boundary between two regimes along a parameter, in a few rounds of refinement."""

from collections.abc import Mapping
from dataclasses import dataclass

from sim.parameters import canonical_number

#: Number of parts into which a range, and later each gap that may hold the boundary, is divided.
PARTS = 4

#: Maximum number of further rounds; a tolerance that needs more is refused.
MAX_ROUNDS = 8

#: Relative slack of comparisons with the tolerance: steps of 0.1 need not sum to 0.4.
_SLACK = 1e-9

#: Map from values of a parameter to the name of their side, ``None`` where it is undecided.
Sides = Mapping[float, str | None]


@dataclass(frozen=True)
class BoundaryEstimate:
    """Estimate of a boundary.

    Attributes
    ----------
    verdict : str
        ``found``: known within the tolerance. ``wide``: known less exactly, as the values in
        between are undecided or contradict each other. ``none``: all decided values, both ends of
        the range among them, are on one side. ``several``: both ends are on the same side, values
        in between on the other. ``open``: at most one side occurs, and an end is undecided.
    below, above : str
        Sides of the lowest and of the highest decided value, ``""`` if no value is decided.
    low, high : float or None
        Interval that contains the boundary; ``None`` unless it is ``found`` or ``wide``.
    """

    verdict: str
    below: str
    above: str
    low: float | None = None
    high: float | None = None


def further_rounds(low: float, high: float, tolerance: float) -> int:
    """Return the number of rounds after the first that bring every gap down to the tolerance.

    >>> further_rounds(10, 20, 0.25)
    2
    """
    rounds, gap = 0, (high - low) / PARTS
    while gap > tolerance * (1 + _SLACK) and rounds <= MAX_ROUNDS:
        rounds, gap = rounds + 1, gap / PARTS
    return rounds


def divide_range(low: float, high: float) -> list[float]:
    """Return the ends of a range and the values that divide it into `PARTS`, in canonical form."""
    step = (high - low) / PARTS
    return [canonical_number(low + step * part) for part in range(PARTS)] + [high]


def locate_boundary(sides: Sides, tolerance: float) -> BoundaryEstimate:
    """Return the estimate of a boundary from the sides of some values.

    All decided values below ``low`` are on the side of the low end, all above ``high`` on the side
    of the high end.
    """
    decided = [(value, side) for value, side in sorted(sides.items()) if side is not None]
    if not decided:
        return BoundaryEstimate("open", "", "")
    below, above = decided[0][1], decided[-1][1]
    if below == above:
        if any(side != below for _, side in decided):
            return BoundaryEstimate("several", below, above)
        has_decided_ends = sides[min(sides)] is not None and sides[max(sides)] is not None
        return BoundaryEstimate("none" if has_decided_ends else "open", below, above)
    first = next(index for index, (_, side) in enumerate(decided) if side != below)
    last = max(index for index, (_, side) in enumerate(decided) if side != above)
    low, high = decided[first - 1][0], decided[last + 1][0]
    verdict = "found" if high - low <= tolerance * (1 + _SLACK) else "wide"
    return BoundaryEstimate(verdict, below, above, low, high)


def next_values(sides: Sides, tolerance: float) -> list[float]:
    """Return the values to compute next, or none if no value would help.

    The boundary lies between ``low`` and ``high`` of `locate_boundary`. If no values lie in
    between, this gap is divided. Otherwise the values in between are undecided or contradict each
    other, and further values among them would do the same. Then the gaps next to ``low`` and
    ``high`` are divided, which narrows the undecided zone.
    """
    boundary = locate_boundary(sides, tolerance)
    low, high = boundary.low, boundary.high
    if low is None or high is None:
        return []
    inside = sorted(value for value in sides if low < value < high)
    gaps = [(low, inside[0]), (inside[-1], high)] if inside else [(low, high)]
    wide = [(low, high) for low, high in gaps if high - low > tolerance * (1 + _SLACK)]
    return [value for low, high in wide for value in divide_range(low, high)[1:-1]]
