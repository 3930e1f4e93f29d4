"""Answers as files, and what they say in words.

A surrogate is arrays and JSON in netCDF, from which the same predictions follow; sensitivities and
propagations are tables; a calibration has the groups that ArviZ reads.
"""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError, percent
from sim.base.seals import is_damaged, read_summary
from sim.parameters.observables import forms
from sim.study.design import Axis
from sim.study.file import QUESTIONS
from sim.study.model import Study
from sim.surrogates.answers import (
    KEY,
    Refusal,
    answer_name,
    caveats_in,
    caveats_of_posterior,
    read_table,
    refusal_in,
    sealed_file,
    sentence,
    stored_answer,
    table_text,
)
from sim.surrogates.fit import Regimes, has_known_regime
from sim.surrogates.posterior import LEAST_PROBABILITY, MOST_UNCOUNTED, at_ends, ridges, summarize
from sim.surrogates.process import Process
from sim.surrogates.sample import Frame, points_of_mean, unit_cube
from sim.surrogates.surrogate import Surrogate

#: What lines tell of a spread.
_SPREAD = {"mean": "mean", "deviation": "standard deviation", "exceedance": "probability above {}"}

#: Most parameters that a line names.
_MOST_NAMED = 3

#: Value of the attribute ``format`` of such a file.
FORMAT = "talus surrogate 1"

#: Attributes of a surrogate that are words.
_WORDS = ("name", "observable", "unit", "meaning", "system")

#: Attributes of an axis that are tuples or none, and of a process that are numbers or switches.
_TUPLES = ("choices", "normal")
_OF_PROCESS = ("is_log", "has_scatter", "widening", "exponent", "is_local")


def save_surrogate(surrogate: Surrogate, path: Path) -> None:
    """Write a surrogate; the file appears complete or not at all.

    Its end has a summary, which is read without opening it.
    """
    process, regimes = surrogate.process, surrogate.regimes
    about = {name: getattr(surrogate, name) for name in _WORDS} | {
        "axes": [asdict(axis) for axis in surrogate.axes],
        "fixed": dict(surrogate.fixed),
        "mean_regimes": surrogate.mean_regimes,
        **{name: getattr(process, name) for name in _OF_PROCESS},
        "form": process.frame.form.name if process.frame else "",
    }
    file = surrogate.sample.assign(
        theta=("number", process.theta), regime_theta=(("process", "regime_number"), regimes.theta)
    )
    file.attrs = {
        "format": FORMAT,
        "about": json.dumps(about, ensure_ascii=False),
        "error": surrogate.error,
        "coverage": surrogate.coverage,
    }
    points, hours = len(process.y), float(surrogate.sample["core_hours"].sum())
    left_out = f" ({surrogate.omissions} left out)" if surrogate.omissions else ""
    line = f"surrogate {surrogate.name}: {points} points{left_out}, error "
    line += f"{percent(surrogate.error)}, {hours:.2g} core hours"
    summary = {"line": line, "error": surrogate.error, "points": points}
    with sealed_file(path, summary | {KEY: list(surrogate.caveats)}) as temporary:
        file.to_netcdf(temporary, engine="netcdf4")


def load_surrogate(path: Path) -> Surrogate:
    """Read a surrogate; see `sim.surrogates.answers.stored_answer`."""
    with stored_answer(path, "surrogate"):
        with xr.open_dataset(path, engine="netcdf4") as file:
            stored = file.load()
        if stored.attrs.get("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT}")
        return _surrogate(stored, json.loads(stored.attrs["about"]))


def _surrogate(stored: xr.Dataset, about: dict[str, Any]) -> Surrogate:
    axes = tuple(
        Axis(**row | {name: tuple(row[name]) for name in _TUPLES if row[name] is not None})
        for row in about["axes"]
    )
    sample = stored.drop_vars(["theta", "regime_theta"])
    sample.attrs = {"scatter": int(about["has_scatter"]), "fixed": about["fixed"]}
    mean_regimes = tuple(about["mean_regimes"])
    chosen = points_of_mean(sample, mean_regimes)
    x = unit_cube(axes, sample)
    process = Process(
        x[chosen],
        sample["mean"].values[chosen],
        sample["standard_error"].values[chosen] ** 2,
        theta=stored["theta"].values,
        frame=_frame(about, axes),
        # A file of an earlier version has not all of these.
        **{name: about[name] for name in _OF_PROCESS if name in about},
    )
    regime = sample["regime"].values
    is_known = has_known_regime(regime, mean_regimes)
    regimes = Regimes(x[is_known], regime[is_known], np.atleast_2d(stored["regime_theta"].values))
    return Surrogate(
        **{name: about[name] for name in _WORDS},
        axes=axes,
        fixed=about["fixed"],
        mean_regimes=mean_regimes,
        sample=sample,
        process=process,
        regimes=regimes,
    )


def _frame(about: dict[str, Any], axes: tuple[Axis, ...]) -> Frame | None:
    if not (name := about.get("form", "")):
        return None
    known = forms(str(about["system"]), str(about["observable"]))
    if name not in known:
        raise InputError(
            f"surrogate {about['name']}: no plug-in that is loaded declares its form {name}"
        )
    return Frame(known[name], axes, about["fixed"])


def load_table(path: Path) -> pd.DataFrame:
    """Read the table of a sensitivity or a propagation; see `stored_answer`."""
    with stored_answer(path, path.parent.name):
        content = read_table(path)
        if content is None:
            raise ValueError("its checksum is wrong")
        words: dict[str, type] = {"parameter": str, "other": object, "doubt": object}
        texts = {"keep_default_na": False, "na_values": [""], "dtype": words}
        table = pd.read_csv(io.BytesIO(content), **texts)
        if "doubt" not in table:
            raise ValueError("it is of an earlier version")
        return table.fillna(dict.fromkeys(words, ""))


def save_posterior(
    name: str, groups: Mapping[str, xr.Dataset], caveats: Sequence[str], path: Path
) -> None:
    """Write the groups of a calibration; the file appears complete or not at all.

    Its end has a line with what it says, and what is doubtful about that; ``caveats`` are those of
    the surrogate.
    """
    caveats = [*caveats_of_posterior(groups["observed_data"].attrs, at_ends(groups)), *caveats]
    line = f"calibration {name}: {' '.join(outcome_sentences(groups))}"
    with sealed_file(path, {"line": line, KEY: caveats}) as temporary:
        for number, (key, group) in enumerate(groups.items()):
            group.to_netcdf(temporary, mode="a" if number else "w", group=key, engine="netcdf4")


def load_posterior(path: Path) -> dict[str, xr.Dataset]:
    """Read the groups of a calibration; see `sim.surrogates.answers.stored_answer`."""
    with stored_answer(path, "calibration"):
        with netCDF4.Dataset(path) as file:
            names = list(file.groups)
        groups = {}
        for name in names:
            with xr.open_dataset(path, group=name, engine="netcdf4") as group:
                groups[name] = group.load()
        return groups


def outcome_sentences(groups: Mapping[str, xr.Dataset]) -> list[str]:
    """Return how a calibration ended, and what it says of each parameter."""
    attributes = groups["observed_data"].attrs
    if attributes["outcome"] == "no fit":
        return [_no_fit(attributes)]
    sentences = []
    for row in summarize(groups).itertuples():
        ends = f"{row.low:.3g} to {row.high:.3g}"
        sentences.append(
            f"{row.parameter} = {row.median:.3g} ({ends})."
            if row.informed
            else f"{row.parameter} is not determined ({ends})."
        )
    return [*sentences, *map(_ridge_sentence, ridges(groups))]


def _no_fit(attributes: Mapping[str, Any]) -> str:
    """Return why no parameters fit."""
    probability, uncounted = float(attributes["probability"]), float(attributes["uncounted"])
    if uncounted > MOST_UNCOUNTED:
        return (
            f"No parameters in the ranges fit: {percent(uncounted)} of those that come nearest "
            f"lie where the flow is {attributes['uncounted_regime']}."
        )
    chance = f"{probability:.2g}" if probability > 0 else "below 0.001"
    return (
        "No parameters in the ranges fit: measurements as far from the model as these would "
        f"have a probability of {chance}, where {LEAST_PROBABILITY:g} is the least accepted."
    )


def _ridge_sentence(ridge: tuple[str, str, float]) -> str:
    first, second, correlation = ridge
    goes = "larger" if correlation > 0 else "smaller"
    return (
        f"A combination of {first} and {second} is known better than each: a larger {first} goes "
        f"with a {goes} {second} (correlation {correlation:.2f})."
    )


def summary_lines(study: Study, folder: Path) -> list[str]:
    """Return what the answers in the results of a study say of themselves, a line for each."""
    paths = [path for question in study.questions if (path := folder / question.file).is_file()]
    return list(filter(None, (refusal_in(path) or _summary_line(path) for path in paths)))


def _summary_line(path: Path) -> str:
    """Return what an answer says of itself, and what is doubtful about it."""
    is_table = path.suffix == ".csv"
    has_changed = read_table(path) is None if is_table else is_damaged(path)
    if has_changed:
        return f"{answer_name(path)}: its file is damaged; rerun the study"
    if is_table:
        line = table_line(path)
        line = line and f"{answer_name(path)}: {line}"
    else:
        line = str((read_summary(path) or {}).get("line", ""))
    caveats = caveats_in(path)
    return f"{line.removesuffix('.')}. {sentence(caveats)}" if caveats else line


def table_line(path: Path) -> str:
    """Return what a table says first, with intervals; empty for a damaged file.

    It is the parameters that matter most, or mean, deviation and probabilities.
    """
    rows = list(csv.DictReader(table_text(path).splitlines()))
    if spread := [row for row in rows if row.get("index") in _SPREAD]:
        return ", ".join(
            f"{_SPREAD[row['index']].format(row['parameter'])} {float(row['value']):.3g} "
            f"({float(row['low']):.3g} to {float(row['high']):.3g})"
            for row in spread
        )
    shown = [row for row in rows if row.get("index") in ("total", "mu_star") and row.get("value")]
    if not shown:
        return ""
    shown.sort(key=lambda row: -float(row["value"]))
    texts = (
        f"{row['parameter']} {float(row['value']):.2g}"
        + (f" ({float(row['low']):.2g} to {float(row['high']):.2g})" if row["low"] else "")
        for row in shown[:_MOST_NAMED]
    )
    index = "mean size of the effect" if shown[0]["index"] == "mu_star" else "total index"
    return f"{index} of {', '.join(texts)}"


def answer_files(folder: Path) -> list[Path]:
    """Return the files of all answers in a folder of results."""
    kinds = (f"{one.folder}/*{one.ending}" for one in QUESTIONS.values())
    return [path for kind in kinds for path in sorted(folder.glob(kind))]


def find_surrogate(folder: Path, name: str | None = None) -> Surrogate:
    """Return a surrogate in a folder of results, by its name or by its observable.

    ``None`` stands for the only one.

    Raises `InputError` when there is none of that name, or several are of that observable. Raises
    `Refusal` when the runs do not give it.
    """
    files = {path.stem: path for path in sorted((folder / "surrogates").glob("*.nc"))}
    if name in files:
        return load_surrogate(files[str(name)])
    reasons = {path: refusal_in(path) for path in files.values()}
    refusals = [text for text in reasons.values() if text]
    surrogates = [load_surrogate(path) for path, text in reasons.items() if not text]
    fitting = [one for one in surrogates if name in (None, one.observable)]
    # One that was refused may be of the observable.
    if len(fitting) + len(refusals) != 1:
        allowed = "one of " + ", ".join(files) if files else "a study with surrogates that has run"
        raise InputError.of_value(folder, "surrogate", name, allowed)
    if refusals:
        raise Refusal(refusals[0])
    return fitting[0]
