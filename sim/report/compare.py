"""A comparison of two runs or two studies as a table to read and as JSON for other programs."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.base.errors import InputError
from sim.dataset.compare import Comparison, Mean, Pair, compare, read_measured
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
from sim.report.points import aligned

_HEADINGS = ("point", "A", "B", "B - A", "p", "")
_RIGHT = {"p"}


def show(first: Path, second: Path, quantity: str, ignored: Sequence[str], format: str) -> str:
    """Return how far two runs or two studies are apart, as ``text`` or ``json``.

    Raises
    ------
    InputError
        When either cannot be read or has no such quantity, for an unknown parameter that is to be
        ignored, and when they have no point in common.
    """
    known = {name for model in SYSTEMS.values() for name in model.model_fields}
    for name in ignored:
        if name not in known:
            raise InputError.of_value("--ignore", "", name, "a parameter of the chute or the belt")
    (one, unit), (other, _) = (read_measured(path, quantity) for path in (first, second))
    found = compare(one, other, quantity, unit, ignored)
    return as_json(found) if format == "json" else as_text(found, (str(first), str(second)))


def as_text(found: Comparison, names: tuple[str, str]) -> str:
    """Return a line per pair, and below what is different and what differs."""
    shown = _telling(found.pairs)
    rows: list[tuple[str, ...]] = []
    for pair, real in zip(found.pairs, found.real, strict=True):
        words = [
            setting(pair.system, name, pair.key[name])
            for name, usual in shown.items()
            if name in pair.key and pair.key[name] != usual
        ]
        rows.append(
            (
                ", ".join(words) or pair.system,
                *(_with_error(mean) for mean in (pair.first, pair.second, pair.difference)),
                f"{pair.chance:.2g}" if np.isfinite(pair.chance) else "not known",
                "differs" if real else "",
            )
        )
    lines = [f"{letter}: {name}" for letter, name in zip("AB", names, strict=True)]
    lines += [f"{name}: A {one}, B {other}" for name, (one, other) in found.differ.items()]
    heading = f"{found.quantity} ({found.unit}), with 95 % intervals"
    return "\n".join([*lines, "", heading, *aligned(_HEADINGS, rows, _RIGHT), "", *_summary(found)])


def _telling(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return the parameters that tell pairs apart, without those that follow from one before.

    Each with the value that more than half of the pairs have, which need not be said, if any.
    """
    found: dict[str, Any] = {}
    seen: set[tuple[int, ...]] = set()
    for name in dict.fromkeys(name for pair in pairs for name in pair.key):
        values = [pair.key.get(name) for pair in pairs]
        pattern = tuple(map(values.index, values))
        if len(set(pattern)) > 1 and pattern not in seen:
            value, count = Counter(values).most_common(1)[0]
            found[name] = value if 2 * count > len(values) else None
            seen.add(pattern)
    return found


def _with_error(mean: Mean) -> str:
    error = f"± {mean.half_width:.2g}" if np.isfinite(mean.half_width) else "(error not known)"
    return f"{mean.value:.4g} {error}"


def _summary(found: Comparison) -> list[str]:
    """Return how many pairs differ, their ratios, and what only one side has."""
    number, real = len(found.pairs), sum(found.real)
    unknown = sum(not np.isfinite(pair.chance) for pair in found.pairs)
    several = "points differ" if real != 1 else "point differs"
    lines = [f"{real} of {number} {several} by more than chance (Welch's test; 5 % of them false)"]
    if unknown:
        lines.append(f"{unknown} cannot be told: a single replicate without an error of its own")
    ratios = [pair.second.value / pair.first.value for pair in found.pairs if pair.first.value]
    if len(ratios) > 1:
        low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9))
        lines.append(f"B / A: median {middle:.4g}, 80 % of the points from {low:.4g} to {high:.4g}")
    if any(found.alone):
        lines.append(f"not in both: {found.alone[0]} of A, {found.alone[1]} of B")
    if any(found.shorter):
        told = f"{found.shorter[0]} of A, {found.shorter[1]} of B"
        lines.append(f"left out, as the same was run for longer or more often: {told}")
    return lines


def as_json(found: Comparison) -> str:
    """Return the comparison as JSON, numbers that are not known as null."""
    pairs = [
        {
            "system": pair.system,
            "parameters": dict(pair.key),
            **{
                name: _plain(mean)
                for name, mean in (
                    ("a", pair.first),
                    ("b", pair.second),
                    ("difference", pair.difference),
                )
            },
            "p": pair.chance if np.isfinite(pair.chance) else None,
            "differs": real,
        }
        for pair, real in zip(found.pairs, found.real, strict=True)
    ]
    document = {
        "quantity": found.quantity,
        "unit": found.unit,
        "different": {name: list(values) for name, values in found.differ.items()},
        "alone": list(found.alone),
        "shorter": list(found.shorter),
        "points": pairs,
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)


def _plain(mean: Mean) -> Mapping[str, Any]:
    known = np.isfinite(mean.half_width)
    return {"value": mean.value, "half_width": mean.half_width if known else None}
