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


def make_ledger(*names: str, turnover: tuple[str, ...]) -> Ledger:
    """Return a ledger of energies, losses and works: each work came in, all else is the outcome.

    The mean rate of ``normal_loss`` is ``normal_power``, and so for each loss and work.
    """
    terms = {name: -1 if name.endswith("_work") else 1 for name in names}
    sums = [name for name in names if not name.endswith("_energy")]
    return Ledger(terms, turnover, {name: f"{name.rpartition('_')[0]}_power" for name in sums})
