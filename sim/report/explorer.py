"""The explorer of a report: the numbers of all points, and the program that draws them.

The page draws with Vega-Lite. Program and numbers are in the page itself, compressed, so that it
loads nothing from elsewhere.
"""

import base64
import gzip
import json
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.statistics import student_half_width
from sim.figures.caption import observable_text, parameter_text
from sim.figures.surrogates import held_note, regime_note, section_rows, shown_settings
from sim.parameters import SYSTEMS, field_info
from sim.report.numbers import subscripts
from sim.study.plottable import numbers
from sim.surrogates.answers import EVEN, sentence
from sim.surrogates.surrogate import Surrogate

#: Folder of the drawing program, and its parts, each of which needs those before it.
VEGA = Path(__file__).parent / "vega"
_PROGRAMS = ("vega", "vega-lite", "vega-embed")

#: Significant digits of the numbers.
_DIGITS = 4

#: Ends of the names of observables that say how sure others are; intervals show that.
_ERRORS = ("_error", "_half_width", "_seed")

#: Observables that say how a run was computed, and nothing of its flow.
_BOOKKEEPING = {
    *("steps", "time_step_used", "wall_time", "loop_time", "average_start", "independent_samples"),
}

#: What the table of points says in words, and how the explorer labels it.
_WORDS = {"regime": "regime", "quality": "quality of the mean", "series": "series"}


def explorer_data(
    dataset: xr.Dataset,
    runs: Sequence[Mapping[str, Any]],
    varied: Mapping[str, Mapping[str, np.ndarray]],
    surrogates: Sequence[Surrogate] = (),
) -> dict[str, Any]:
    """Return what the explorer shows of the points of a dataset and its surrogates, by system.

    ``runs`` is the table of runs, see `sim.report.runs.run_rows`, ``varied`` the parameters that
    vary, see `sim.report.runs.varied_parameters`.

    Each system has ``columns``, ``links`` and ``curves``. A column has a ``name``, a ``label`` with
    its unit, a ``kind`` (``parameter``, ``observable`` or ``word``) and its ``values``, one per
    point and ``None`` where unknown; the series of a point are a list. An observable is a mean over
    replicates; its ``half`` is half the width of the 95 % interval. ``links`` lead to the row of a
    point in the table of runs. ``curves`` are sections of surrogates: ``y`` is the observable,
    ``x`` the parameter, and ``note`` says in HTML what is held. ``rows`` have the value of the
    parameter, ``mean``, ``low`` and ``high`` of the 95 % band, ``likely``: whether the regimes of
    the mean are, the number of the ``part`` of the line in which this is the same, and words that
    are chosen.
    """
    systems = {}
    for system in dict.fromkeys(run["system"] for run in runs):
        rows = [run for run in runs if run["system"] == system]
        points = dataset.isel(point=[run["number"] - 1 for run in rows])
        columns = [*_parameters(varied[system], system), *_observables(points, system, rows)]
        columns += [
            {"name": name, "label": label, "kind": "word", "values": [row[name] for row in rows]}
            for name, label in _WORDS.items()
        ]
        systems[system] = {
            "columns": columns,
            "links": [f"#run-{run['number']}" for run in rows],
            "curves": [
                section
                for surrogate in surrogates
                if surrogate.system == system
                for section in _curves(surrogate)
            ],
        }
    return systems


def _parameters(varied: Mapping[str, np.ndarray], system: str) -> list[dict[str, Any]]:
    columns = []
    for name, values in varied.items():
        is_number = values.dtype.kind in "fi"
        columns.append(
            {
                "name": name,
                "label": _label(system, name),
                "kind": "parameter" if is_number else "word",
                "values": _numbers(values) if is_number else [str(value) for value in values],
            }
        )
    return columns


def _label(system: str, name: str) -> str:
    """Return the label of a parameter, without a symbol whose subscript a menu cannot show."""
    text, symbol = parameter_text(system, name), field_info(SYSTEMS[system])[name].symbol
    return text.replace(f" {symbol}", "", 1) if "_" in symbol else text


def _observables(
    points: xr.Dataset, system: str, rows: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Return the columns of the observables of a system that have more than one value."""
    is_completed = (points["status"] == "completed").values
    columns = []
    for name, observable in numbers(system).items():
        is_shown = not (observable.is_mean or name in _BOOKKEEPING or name.endswith(_ERRORS))
        if not is_shown or observable.source not in points:
            continue
        if name == "velocity":
            means = np.array([row["velocity"] for row in rows], dtype=float)
            halves = np.array([row["half_width"] for row in rows], dtype=float)
        else:
            values = np.where(is_completed, points[observable.source].values, np.nan)
            finite = [replicates[np.isfinite(replicates)] for replicates in values]
            means = np.array([each.mean() if each.size else np.nan for each in finite])
            halves = np.array([float(student_half_width(each)) for each in finite])
        if len(np.unique(means[np.isfinite(means)])) > 1:
            column = {
                "name": name,
                "label": observable_text(name, observable.unit, "si", system),
                "kind": "observable",
                "values": _numbers(means),
            }
            if np.isfinite(halves).any():
                column["half"] = _numbers(halves)
            columns.append(column)
    return columns


def _curves(surrogate: Surrogate) -> Iterator[dict[str, Any]]:
    """Yield a section along each parameter of a surrogate."""
    lead = f"Line and band: surrogate {surrogate.name} and its 95 % interval"
    lead += f", for each {' and '.join(surrogate.choices)}" if surrogate.choices else ""
    lead += f" ({surrogate.basis}). {sentence(surrogate.caveats)}".rstrip()
    for axis in surrogate.numeric:
        table = pd.concat(
            [section_rows(surrogate, axis, chosen) for chosen in shown_settings(surrogate)]
        )
        likely = table["probability"] >= EVEN
        table["low"] = table["mean"] - table["half_width"]
        table["high"] = table["mean"] + table["half_width"]
        rows = table[[axis.name, "mean", "low", "high"]].map(_rounded)
        is_first = (likely != likely.shift()) | (table[axis.name].diff() < 0)
        rows = rows.assign(likely=likely, part=is_first.cumsum())
        rows = rows.assign(**{name: table[name].map(str) for name in surrogate.choices})
        notes = [lead, held_note(surrogate, axis.name)]
        if not likely.all():
            notes.append(regime_note(surrogate, "The line is dashed where"))
        yield {
            "x": axis.name,
            "y": surrogate.observable,
            "note": subscripts(" ".join(filter(None, notes))),
            "rows": rows.to_dict("records"),
        }


def _numbers(values: np.ndarray) -> list[float | None]:
    return [_rounded(value) if isfinite(value) else None for value in values]


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def compressed(data: Any) -> str:
    """Return data as JSON that is compressed and in letters that a page can hold."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return _letters(text.encode())


def drawing_program() -> str:
    """Return the program of Vega-Lite, compressed like `compressed`."""
    return _letters(b"\n".join((VEGA / f"{name}.min.js").read_bytes() for name in _PROGRAMS))


def _letters(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")
