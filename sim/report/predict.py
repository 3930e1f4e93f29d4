"""The command ``predict``: what a surrogate says at values of its parameters."""

import json
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sim.base.errors import InputError, align_table
from sim.base.numbers import number
from sim.dataset.results import Results, load_current
from sim.study.load import folder_of_results, load_study
from sim.study.surrogate import SurrogateFile
from sim.surrogates.answers import KEY, parted, refusal_in, sentence
from sim.surrogates.sample import sample_points
from sim.surrogates.storage import find_surrogate, load_surrogate
from sim.surrogates.surrogate import Surrogate


def predict(
    source: Path,
    at: Sequence[str],
    of: str | None,
    extrapolate: bool,
    format: str,
    results: Path = Path("results"),
    *,
    highest: bool = False,
    lowest: bool = False,
) -> str:
    """Return mean, half width and probabilities at some values, as ``table`` or ``json``.

    ``source`` is a study file, with the folder of all ``results``, or a folder of results. Values
    are ``parameter=value``, or ``parameter=value,value`` for a row of each. ``of`` is the name or
    the observable of the surrogate, the only one if omitted. With ``highest`` or ``lowest`` the
    parameters without a value are searched, else numbers are held in the middle of their ranges.

    Raises `InputError` when there is no such surrogate, or a value is missing or out of range, or
    the study file has changed since the study was run.
    """
    if highest and (lowest or extrapolate):
        other = "--lowest" if lowest else "--extrapolate"
        raise InputError.of_value(other, "", "given", "--highest without it")
    folder = source if source.is_dir() else _current_folder(source, of, results)
    surrogate = find_surrogate(folder, of)
    values, names = _values(surrogate, at), surrogate.regimes.names
    if highest or lowest:
        find = surrogate.highest if highest else surrogate.lowest
        every = (dict(zip(values, one, strict=True)) for one in product(*values.values()))
        places = [find(**one) for one in every]
    else:
        single: dict[str, Any] = {k: v[0] if len(v) == 1 else v for k, v in values.items()}
        places = [surrogate(extrapolate=extrapolate, **single)]
    rows = [row for place in places for row in _rows(place, names)]
    caveats = tuple(dict.fromkeys(one for place in places for one in parted(place.attrs[KEY])))
    if format == "json":
        document = {
            "surrogate": surrogate.name,
            "observable": surrogate.observable,
            "unit": surrogate.unit,
            "error": surrogate.error,
            KEY: list(caveats),
            "held": places[0].attrs.get("held", ""),
            "rows": rows,
        }
        return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    notes = _notes(surrogate, places[0], "highest" if highest else "lowest")
    return "\n".join([*_lines(surrogate, rows), *notes, *filter(None, [sentence(caveats)])])


def _current_folder(source: Path, of: str | None, results: Path) -> Path:
    """Return the results of a study file; dataset and surrogate must be those that it asks for."""
    study = load_study(source, results)
    folder = folder_of_results(study, results) / study.name
    dataset = load_current(study, folder, title=False)
    named = [spec for spec in study.surrogates if spec.name == of]
    for spec in named or [spec for spec in study.surrogates if of in (None, spec.observable)]:
        path = folder / spec.file
        if not path.is_file() or not (
            refusal_in(path) or _is_of(spec, load_surrogate(path), dataset)
        ):
            message = f"{source}: surrogate {spec.name}: not as in {folder}; run the study again"
            raise InputError(message)
    return folder


def _is_of(spec: SurrogateFile, surrogate: Surrogate, dataset: Results) -> bool:
    entry = spec.observable, spec.axes, spec.mean_regimes
    if entry != (surrogate.observable, surrogate.axes, surrogate.mean_regimes):
        return False
    now, then = sample_points(dataset, spec), surrogate.sample
    means = now["mean"].values, then["mean"].values
    return now["point"].values.tolist() == then["point"].values.tolist() and np.allclose(
        *means, equal_nan=True
    )


def _values(surrogate: Surrogate, at: Sequence[str]) -> dict[str, list[Any]]:
    values: dict[str, list[Any]] = {}
    for text in at:
        name, sign, written = text.partition("=")
        if not (name and sign and written):
            raise InputError.of_value("--at", "", text, "PARAMETER=VALUE")
        if name not in {axis.name for axis in surrogate.axes} | set(surrogate.fixed):
            allowed = "one of " + ", ".join(axis.name for axis in surrogate.axes)
            raise InputError.of_value("--at", "", name, allowed)
        if name in values:
            raise InputError.of_value("--at", name, written, "each parameter once")
        parts = [_value(surrogate, name, part) for part in written.split(",")]
        values[name] = parts
    return values


def _value(surrogate: Surrogate, name: str, text: str) -> Any:
    """Return a value of a parameter: one of its choices, or a number where it is one."""
    choices = {str(choice).lower(): choice for choice in surrogate.choices.get(name, ())}
    if text.lower() in choices:
        return choices[text.lower()]
    try:
        return number(text)
    except ValueError:
        return text


def _rows(answer: xr.Dataset, regimes: Sequence[str]) -> list[dict[str, Any]]:
    columns = {name: answer["probability"].sel(regime=name, drop=True) for name in regimes}
    table = answer.drop_dims("regime").assign(columns)
    # A single place has no dimension, of which a table needs one.
    frame = (table if answer["mean"].dims else table.expand_dims("row")).to_dataframe()
    rows = frame.reset_index().drop(columns="row", errors="ignore").to_dict("records")
    likely = {"likely": answer.attrs["likely"]} if "likely" in answer.attrs else {}
    return [
        {str(name): value for name, value in row.items() if name not in regimes}
        | {"probability": {name: row[name] for name in regimes}}
        | likely
        for row in rows
    ]


def _lines(surrogate: Surrogate, rows: Sequence[dict[str, Any]]) -> list[str]:
    given = [axis.name for axis in surrogate.axes]
    unit = "" if surrogate.unit == "1" else f" ({surrogate.unit})"
    headings = (*given, f"{surrogate.observable}{unit}", "± 95 %", *surrogate.regimes.names)
    cells = [
        (
            *(_cell(row.get(name), row.get("likely", {}).get(name)) for name in given),
            f"{row['mean']:.4g}",
            f"{row['half_width']:.2g}",
            *(f"{chance:.2f}" for chance in row["probability"].values()),
        )
        for row in rows
    ]
    return align_table(headings, cells, set(headings))


def _cell(value: Any, likely: Sequence[Any] | None) -> str:
    """Return a value as text, with the range or the words in which it lies where it was found."""
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    if likely and isinstance(value, float):
        return f"{text} ({likely[0]:.3g} to {likely[1]:.3g})"
    others = [str(one) for one in likely or () if one != value]
    return f"{text} (or {' or '.join(others)})" if others else text


def _notes(surrogate: Surrogate, answer: xr.Dataset, found: str) -> list[str]:
    left_out = f" ({surrogate.omissions} left out)" if surrogate.omissions else ""
    held, names = answer.attrs.get("held"), ", ".join(answer.attrs.get("likely", {}))
    searched = f"{found} over {names}; in brackets where it lies with 95 % probability"
    return [
        *([f"held: {held}"] if held else []),
        *([searched] if names else []),
        f"surrogate {surrogate.name}: {surrogate.basis}{left_out}",
    ]
