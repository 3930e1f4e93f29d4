"""Which of a system's time series add up to its energy."""

from typing import NamedTuple


class Ledger(NamedTuple):
    """The energy ledger of a system; values name time series (J).

    ``terms`` name -> sign: their signed sum is constant. ``turnover`` names those, sums since the
    start, whose change measures how much energy has passed through. ``powers`` name of a sum since
    the start -> name of the scalar that holds its mean rate (W).
    """

    terms: dict[str, int]
    turnover: tuple[str, ...]
    powers: dict[str, str]
