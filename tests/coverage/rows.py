"""What the tables of docs/validation.md have in common: a row for each case, in Markdown."""

import argparse
from collections.abc import Callable, Iterable, Sequence
from typing import Any


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
