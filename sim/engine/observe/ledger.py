"""The energy ledger of a system: the time series whose sum is its energy."""

from typing import NamedTuple


class Ledger(NamedTuple):
    """The energy ledger of a system; its names are those of time series (J).

    ``terms`` name -> sign: the signed sum of these series is constant. ``turnover`` names sums
    since the start whose change measures the energy that has passed through. ``powers`` name of a
    sum since the start -> name of the scalar with its mean rate (W).
    """

    terms: dict[str, int]
    turnover: tuple[str, ...]
    powers: dict[str, str]
