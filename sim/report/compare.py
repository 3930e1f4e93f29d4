"""The comparison of two runs or two studies, as a table and as JSON."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.base.errors import InputError
from sim.dataset.compare import Comparison, Mean, Pair, compare, read_side
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
from sim.report.points import align_table
from sim.report.second_opinion import ask

_HEADINGS = ("point", "A", "B", "B - A", "p", "")
_RIGHT = {"p"}


def show(
    first: Path,
    second: Path | None,
    quantity: str = "velocity",
    ignored: Sequence[str] = (),
    format: str = "text",
    **opinion: Any,
) -> str:
    """Return the comparison of two runs or two studies as ``text`` or ``json``.

    Without a second it is what another engine says of a study, see `sim.report.second_opinion.ask`.

    Raises
    ------
    InputError
        When a file cannot be read or lacks the quantity, when an ignored parameter is unknown, or
        when they have no point in common.
    """
    if second is None:
        return "\n".join(ask(first, **opinion))
    parameters = {name for model in SYSTEMS.values() for name in model.model_fields}
    for name in ignored:
        if name not in parameters:
            raise InputError.of_value("--ignore", "", name, "a parameter of a system")
    (first_side, unit), (second_side, _) = (read_side(path, quantity) for path in (first, second))
    comparison = compare(first_side, second_side, ignored)
    if format == "json":
        return as_json(comparison, quantity, unit)
    files = [f"A: {first}", f"B: {second}"]
    return "\n".join([*files, *text_lines(comparison, f"{quantity} ({unit})")])


def text_lines(comparison: Comparison, heading: str) -> list[str]:
    """Return differing settings, a line per pair of points, and a summary."""
    usual_values = _distinguishing_parameters(comparison.pairs)
    rows: list[tuple[str, ...]] = []
    for pair, differs in zip(comparison.pairs, comparison.is_real, strict=True):
        words = [
            setting(pair.system, name, pair.key[name])
            for name, usual in usual_values.items()
            if name in pair.key and pair.key[name] != usual
        ]
        rows.append(
            (
                ", ".join(words) or pair.system,
                *(_mean_text(mean) for mean in (pair.first, pair.second, pair.difference)),
                f"{pair.chance:.2g}" if np.isfinite(pair.chance) else "not known",
                "differs" if differs else "",
            )
        )
    settings = [f"{name}: A {a}, B {b}" for name, (a, b) in comparison.differing_parameters.items()]
    table = align_table(_HEADINGS, rows, _RIGHT)
    return [*settings, "", f"{heading}, with 95 % intervals", *table, "", *_summary(comparison)]


def _distinguishing_parameters(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return the parameters that distinguish pairs, each with its most common value.

    Parameters that vary exactly like an earlier one are left out. The value is None unless more
    than half of the pairs have it; lines of pairs omit it.
    """
    usual_values: dict[str, Any] = {}
    patterns: set[tuple[int, ...]] = set()
    for name in dict.fromkeys(name for pair in pairs for name in pair.key):
        values = [pair.key.get(name) for pair in pairs]
        pattern = tuple(map(values.index, values))
        if len(set(pattern)) > 1 and pattern not in patterns:
            value, count = Counter(values).most_common(1)[0]
            usual_values[name] = value if 2 * count > len(values) else None
            patterns.add(pattern)
    return usual_values


def _mean_text(mean: Mean) -> str:
    error = f"± {mean.half_width:.2g}" if np.isfinite(mean.half_width) else "(error not known)"
    return f"{mean.value:.4g} {error}"


def _summary(comparison: Comparison) -> list[str]:
    """Return lines on the number of pairs that differ, their ratios, and unmatched points."""
    number, differing = len(comparison.pairs), sum(comparison.is_real)
    unknown = sum(not np.isfinite(pair.chance) for pair in comparison.pairs)
    several = "points differ" if differing != 1 else "point differs"
    lines = [
        f"{differing} of {number} {several} by more than chance (Welch's test; 5 % of them false)"
    ]
    if unknown:
        lines.append(f"{unknown} cannot be told: a single replicate without an error of its own")
    ratios = [pair.second.value / pair.first.value for pair in comparison.pairs if pair.first.value]
    if len(ratios) > 1:
        low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9))
        lines.append(f"B / A: median {middle:.4g}, 80 % of the points from {low:.4g} to {high:.4g}")
    if any(comparison.unmatched_counts):
        first, second = comparison.unmatched_counts
        lines.append(f"not in both: {first} of A, {second} of B")
    if any(comparison.shorter_counts):
        shorter = f"{comparison.shorter_counts[0]} of A, {comparison.shorter_counts[1]} of B"
        lines.append(f"left out, as the same was run for longer or more often: {shorter}")
    return lines


def as_json(comparison: Comparison, quantity: str, unit: str) -> str:
    """Return the comparison as JSON, with null for unknown numbers."""
    pairs = [
        {
            "system": pair.system,
            "parameters": dict(pair.key),
            **{
                name: _mean_entry(mean)
                for name, mean in (
                    ("a", pair.first),
                    ("b", pair.second),
                    ("difference", pair.difference),
                )
            },
            "p": pair.chance if np.isfinite(pair.chance) else None,
            "differs": differs,
        }
        for pair, differs in zip(comparison.pairs, comparison.is_real, strict=True)
    ]
    document = {
        "quantity": quantity,
        "unit": unit,
        "different": {
            name: list(values) for name, values in comparison.differing_parameters.items()
        },
        "alone": list(comparison.unmatched_counts),
        "shorter": list(comparison.shorter_counts),
        "points": pairs,
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)


def _mean_entry(mean: Mean) -> Mapping[str, Any]:
    has_half_width = np.isfinite(mean.half_width)
    return {"value": mean.value, "half_width": mean.half_width if has_half_width else None}
