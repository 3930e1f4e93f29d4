"""Where one side of a range ends and the other begins, found in a few rounds of refinement."""

from collections.abc import Mapping
from dataclasses import dataclass

from sim.parameters import canonical_number

#: A range, and later each gap that may hold the boundary, is divided into this many parts.
PARTS = 4

#: Further rounds at most; a tolerance that asks for more is refused.
MAX_ROUNDS = 8

#: Relative slack of comparisons with the tolerance: steps of 0.1 need not sum to 0.4.
_SLACK = 1e-9

#: What is known at some values of a parameter: a side by name, or ``None`` where it is open.
Sides = Mapping[float, str | None]


@dataclass(frozen=True)
class Located:
    """What is known of a boundary.

    Attributes
    ----------
    verdict : str
        ``found``: within the tolerance; ``wide``: between values that are further apart, with
        undecided or contradictory ones in between; ``none``: one side alone, at both ends
        of the range; ``several``: the same side at both ends and the other in between; ``open``: no
        more than one side is seen, and an end of the range is undecided.
    below, above : str
        Sides at the low and at the high end, ``""`` where nothing is decided.
    low, high : float or None
        The boundary lies between; ``None`` unless it is ``found`` or ``wide``.
    """

    verdict: str
    below: str
    above: str
    low: float | None = None
    high: float | None = None


def further_rounds(low: float, high: float, tolerance: float) -> int:
    """Return how many rounds after the first bring every gap down to the tolerance.

    >>> further_rounds(10, 20, 0.25)
    2
    """
    rounds, gap = 0, (high - low) / PARTS
    while gap > tolerance * (1 + _SLACK) and rounds <= MAX_ROUNDS:
        rounds, gap = rounds + 1, gap / PARTS
    return rounds


def divided(low: float, high: float) -> list[float]:
    """Return the ends of a range and the values that divide it, in canonical form."""
    step = (high - low) / PARTS
    return [canonical_number(low + step * part) for part in range(PARTS)] + [high]


def located(sides: Sides, tolerance: float) -> Located:
    """Say what the sides of some values tell about the boundary.

    Everything decided below ``low`` is on the side of the low end, everything decided above
    ``high`` on that of the high end.
    """
    decided = [(value, side) for value, side in sorted(sides.items()) if side is not None]
    if not decided:
        return Located("open", "", "")
    below, above = decided[0][1], decided[-1][1]
    if below == above:
        if any(side != below for _, side in decided):
            return Located("several", below, above)
        whole = sides[min(sides)] is not None and sides[max(sides)] is not None
        return Located("none" if whole else "open", below, above)
    first = next(index for index, (_, side) in enumerate(decided) if side != below)
    last = max(index for index, (_, side) in enumerate(decided) if side != above)
    low, high = decided[first - 1][0], decided[last + 1][0]
    verdict = "found" if high - low <= tolerance * (1 + _SLACK) else "wide"
    return Located(verdict, below, above, low, high)


def next_values(sides: Sides, tolerance: float) -> list[float]:
    """Return the values to compute next; none when nothing can be gained.

    The boundary lies between ``low`` and ``high`` of `located`. Without values in between, this
    gap is divided. Values in between are undecided or contradict each other and would be again, so
    the gaps next to ``low`` and ``high`` are divided, and what is undecided is closed in on.
    """
    found = located(sides, tolerance)
    if found.low is None or found.high is None:
        return []
    inside = sorted(value for value in sides if found.low < value < found.high)
    gaps = (
        [(found.low, inside[0]), (inside[-1], found.high)] if inside else [(found.low, found.high)]
    )
    wide = [(low, high) for low, high in gaps if high - low > tolerance * (1 + _SLACK)]
    return [value for low, high in wide for value in divided(low, high)[1:-1]]
