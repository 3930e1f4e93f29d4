"""What the tables of docs/validation.md have in common: surrogates, and a row for each case."""

import argparse
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sim.study.design import Axis
from sim.surrogates.answers import Refusal
from sim.surrogates.sample import standard_errors
from sim.surrogates.surrogate import Surrogate
from tests.made.surrogates import asked, made_sample


def unit_axes(count: int) -> tuple[Axis, ...]:
    return tuple(Axis(f"x{number}", 0.0, 1.0) for number in range(count))


def fitted(
    x: np.ndarray, values: np.ndarray, axes: Sequence[Axis], counts: np.ndarray
) -> Surrogate:
    """Return the surrogate of replicates (n, R) at points (n, d), of those that count.

    It is fitted as a study would. Raises `Refusal` without answer.
    """
    errors, is_unknown = standard_errors(list(values), np.zeros(len(x)), x)
    regime = np.where(counts, "steady", "arrested")
    sample = made_sample(x, values.mean(axis=1), axes, errors, regime, is_unknown)
    return Surrogate.fit(asked(axes), sample)


#: What asks for the table of an answer, its truth, and how far that is known, both (rows,).
Question = tuple[Callable[[], pd.DataFrame], np.ndarray, np.ndarray]

HEADINGS = ("case", "designs with an answer", "truths held, %", "worst design, %")


def coverage(questions: Iterable[Question]) -> tuple[int, list[float]]:
    """Return how many questions there are, and what share of its truths each answer holds."""
    number, held = 0, list[float]()
    for ask, truth, slack in questions:
        number += 1
        try:
            table = ask()
        except Refusal:
            continue
        inside = (table["low"] <= truth + slack) & (truth - slack <= table["high"])
        held.append(float(inside[table["low"].notna()].mean()))
    return number, held


def cells(name: str, questions: Iterable[Question]) -> tuple[str, ...]:
    """Return the row of a case in the table of `HEADINGS`."""
    number, held = coverage(questions)
    if not held:
        return name, f"0 of {number}", "no answer", ""
    share, worst = 100 * np.mean(held), 100 * min(held)
    return name, f"{len(held)} of {number}", f"{share:.1f}", f"{worst:.0f}"


def print_table(
    about: str,
    headings: Sequence[str],
    cases: Iterable[Any],
    row_of: Callable[[Any, int | None], Sequence[str]],
) -> None:
    """Print the rows of the cases whose name has a text, of so many designs as are asked for."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--only", default="", help="a part of the names of cases")
    parser.add_argument("--designs", type=int, help="designs of each case")
    options = parser.parse_args()
    for cells in (headings, ["---"] * len(headings)):
        print(f"| {' | '.join(cells)} |")
    for case in cases:
        if options.only in getattr(case, "name", str(case)):
            print(f"| {' | '.join(row_of(case, options.designs))} |", flush=True)
