"""Tables of indices: a value with its interval a row, what it rests on, and what is doubtful."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sim.surrogates.refusals import Refusal

#: Columns of a table.
#:
#: ``index`` is ``first``, ``total``, ``interaction`` or ``sum`` (of the first-order indices; its
#: ``parameter`` is ``all``), or Morris' ``mu``, ``mu_star`` or ``sigma``. ``other`` names the
#: second parameter of an interaction. ``low`` and ``high`` are the ends of the 95 % interval,
#: not-a-number where there is none. Those that follow are the same in all rows, but for the last.
#: ``blocks`` are those of the sample that count, ``left_out`` those with a run that failed or has
#: no value. ``noise`` is the share of the variance that comes from the scatter between replicates:
#: 0 for a surrogate, not-a-number where it is not known. ``error`` is that of the surrogate,
#: relative to the mean size, not-a-number for runs. ``absent`` is the share of the ranges in which
#: a flow of another regime is likelier; 0 for runs. ``doubt`` says in words what is doubtful about
#: the row alone, see `with_doubts`; `sim.surrogates.caveats` has what is about all rows.
COLUMNS = (
    *("index", "parameter", "other", "value", "low", "high"),
    *("blocks", "left_out", "noise", "error", "absent", "doubt"),
)

#: Indices that are shares of the variance, from 0 to 1.
_SHARES = ("first", "total", "sum")

#: Least spread of values, relative to their size, that is not from rounding.
_LEAST_SPREAD = 1e-12

#: What a total index must be below, with its interval, to be without effect.
NEGLIGIBLE = 0.01

#: What is doubtful about a row.
_OUTSIDE = "outside 0 to 1 by more than its interval, by too few points"


def tabulate(
    names: Iterable[tuple[str, str, str]],
    estimate: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    **basis: Any,
) -> pd.DataFrame:
    """Return values and ends of intervals as a table of `COLUMNS`.

    ``names`` has index, parameter and other parameter of each; ``basis`` the columns that are the
    same in all rows, see `COLUMNS`.
    """
    rows = [(*name, *numbers) for name, *numbers in zip(names, estimate, low, high, strict=True)]
    table = pd.DataFrame(rows, columns=list(COLUMNS[:6]))
    known = {"left_out": 0, "noise": 0.0, "error": np.nan, "absent": 0.0, "doubt": ""} | basis
    return table.assign(**known)[list(COLUMNS)]


def with_doubts(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with what is doubtful about each row alone, beside what it has."""
    is_outside = table["index"].isin(_SHARES) & ((table["high"] < 0) | (table["low"] > 1))
    return table.assign(doubt=table["doubt"].mask(is_outside, _OUTSIDE))


def require_spread(values: np.ndarray, source: str) -> None:
    """Raise `Refusal` where values do not vary by more than rounding."""
    if np.ptp(values) <= _LEAST_SPREAD * np.abs(values).max():
        raise Refusal(
            f"{source}: no indices, as the observable does not vary: it is {values.max():.6g} "
            "everywhere, so nothing can matter"
        )


def shares_of(names: Sequence[str]) -> list[tuple[str, str, str]]:
    """Return index, parameter and other parameter of first-order and total indices, and the sum."""
    alone = [(index, name, "") for index in ("first", "total") for name in names]
    return [*alone, ("sum", "all", "")]
