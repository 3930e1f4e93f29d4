"""Write the four files of a figure from a dataset: PNG, SVG or GIF, data and caption."""

import sys
import textwrap
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.errors import Allowed, InputError
from sim.base.files import atomic_write, file_version
from sim.base.messages import one_of
from sim.base.seals import checked_read
from sim.dataset.results import Results, load_results, require_known_options
from sim.figures.caption import caption, point_notes
from sim.figures.data import Drawing, FigureData, figure_data, point_table, read_once
from sim.figures.pictures import (
    Animation,
    current_record,
    read_records,
    save_animation,
    save_picture,
    settle,
    write_records,
)
from sim.figures.plot import message_figure
from sim.figures.style import DOUBTFUL, SETTINGS, escape_label
from sim.study.figure_spec import FIGURES, FigureSpec
from sim.study.load import load_study
from sim.study.plottable import ROLES, kinds
from sim.surrogates.answers import sentence, with_caveats

#: Letters of a caveat beneath a picture, for each inch of its width.
_LETTERS = 17

#: Largest number that is drawn: axes cannot hold all that a computer can.
LARGEST = 1e100
_TOO_LARGE = f"a number of its data is beyond {LARGEST:g}"


def drawing_of(kind: str) -> Drawing:
    """Return what draws a kind of plot: its own functions, or those that draw all else."""
    one = kinds()[kind]
    found: Any = resolve_name(one.drawing) if one.drawing else None
    roles = {role: getattr(found, role) for role in ROLES if hasattr(found, role)}
    return Drawing(**{"table": point_table, "notes": point_notes, **roles, **one.own})


def find_spec(name: str, entries: Mapping[str, FigureSpec] | None = None) -> FigureSpec:
    """Return the specification of a figure: as the study feeds it, or as the catalogue has it.

    Raises ``InputError`` for an unknown name.
    """
    specs = {**FIGURES, **(entries or {})}
    if name not in specs:
        hint = "" if entries is not None else "; a plot of a study needs --study STUDY.yaml"
        question, names = one_of(name, specs)
        raise InputError.of_value("figure", "name", name, Allowed(question, names + hint))
    return specs[name]


def render(spec: FigureSpec, dataset_path: Path, folder: Path) -> list[Path]:
    """Draw one figure from a study's ``dataset.nc`` into files in a folder, made if absent.

    They are ``<name>.png``, ``.svg``, of an animation ``.gif``, ``.csv`` (the plotted data) and
    ``.caption.txt``. Raises ``InputError`` for a missing dataset, or one without points for it.
    """
    results = read_once(load_results, dataset_path, file_version(dataset_path))
    require_known_options(results.dataset, dataset_path)
    try:
        data, kind, table = _contents(spec, results)
    except KeyError as error:
        raise InputError(f"{dataset_path}: not the dataset of a study: {error}") from None
    if data.rows.empty:
        raise InputError(f"{dataset_path}: figures: no point feeds {spec.name}")
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{spec.name}{suffix}" for suffix in spec.suffixes]
    with ExitStack() as stack:
        still, other, csv, text = (stack.enter_context(atomic_write(file)) for file in files)
        stack.enter_context(mpl.rc_context(SETTINGS))
        drawn, figure = _draw(data, kind)
        if isinstance(drawn, Animation):
            save_animation(drawn, other)
        save_picture(figure, spec.title, None if spec.animated else other, still)
        for file, content in zip((csv, text), _texts(data, kind, table), strict=True):
            file.write_text(content, encoding="utf-8")
    return files


def draw(spec: FigureSpec, results: Results) -> Figure:
    """Return the picture of a study's plot, without writing a file."""
    with mpl.rc_context(SETTINGS):
        return _draw(*_contents(spec, results)[:2])[1]


def _draw(data: FigureData, kind: Drawing) -> tuple[Figure | Animation, Figure]:
    """Return what a kind of plot draws, and its picture with the final layout."""
    drawn = kind.draw(data)
    figure = drawn.figure if isinstance(drawn, Animation) else drawn
    (axes, *_) = figure.axes
    is_message = bool(axes.texts) and not axes.axison
    if not (is_message or data.rows["completed"].any()):
        axes.text(0.5, 0.5, "no point completed", ha="center", transform=axes.transAxes)
    settle(figure)
    return drawn, figure


def _contents(spec: FigureSpec, results: Results) -> tuple[FigureData, Drawing, pd.DataFrame]:
    """Return the selected data of a figure, its kind, and the plotted data.

    Where a question has no answer, or a number is beyond `LARGEST`, the kind says that alone.
    """
    data, kind = figure_data(results, spec), drawing_of(spec.kind)
    if spec.answer.file and results.runs:
        if data.refusal:
            table = pd.DataFrame({"refusal": [data.refusal]})
            return data, _message_kind(kind, data.refusal), table
        kind = _kind_of_answer(kind, data.answer, data.caveats)
    if data.rows.empty:
        return data, kind, data.rows
    data = kind.select(data)
    table = kind.table(data)
    numbers = table.infer_objects().select_dtypes("number").to_numpy(float)
    if (np.abs(numbers) > LARGEST).any():
        kind = _message_kind(kind, _TOO_LARGE)
    return data, kind, table


def _kind_of_answer(kind: Drawing, answer: Path, caveats: Sequence[str]) -> Drawing:
    """Return a kind of plot that tells the caveats of the answer it shows.

    They stand beneath the picture, in the first paragraph of its caption, and in its data. Errors
    on an answer from elsewhere name its file in a line.
    """
    guard = checked_read(answer, "whole answer", replaceable=False)

    @guard
    def draw(data: FigureData) -> Figure | Animation:
        drawn = kind.draw(data)
        figure = drawn.figure if isinstance(drawn, Animation) else drawn
        width = int(_LETTERS * figure.get_figwidth())
        line = textwrap.fill(escape_label(sentence(caveats[:1])), width)
        figure.supxlabel(line, fontsize=7, color=DOUBTFUL)
        return drawn

    @guard
    def notes(data: FigureData) -> list[str]:
        first, *others = kind.notes(data) or [""]
        return [f"{first} {sentence(caveats)}".strip(), *others]

    @guard
    def table(data: FigureData) -> pd.DataFrame:
        return with_caveats(kind.table(data), caveats)

    return kind._replace(draw=draw, notes=notes, table=table)


def _message_kind(kind: Drawing, text: str) -> Drawing:
    def draw_message(data: FigureData) -> Figure | Animation:
        figure = message_figure(escape_label(text))
        return Animation(figure, 1, lambda number: None) if data.spec.animated else figure

    return kind._replace(draw=draw_message, notes=lambda data: [f"Nothing is drawn: {text}."])


def _texts(data: FigureData, kind: Drawing, table: pd.DataFrame) -> tuple[str, str]:
    csv = table.to_csv(index=False, float_format="%.10g")
    return csv, caption(data, kind.notes(data)) + "\n"


def draw_figures(
    names: Sequence[str],
    dataset_path: Path,
    out_folder: Path,
    processes: int = 1,
    code: str = "",
    study_path: Path | None = None,
) -> None:
    """Draw figures of a study in parallel; a failed figure does not stop the others.

    They are named in the catalogue, or in the file of the study, whose ``dataset.nc`` they show.
    Given the hash of the ``code`` that draws, figures are skipped whose files are unchanged since
    this code drew them from this dataset and their entry of the catalogue.

    Raises ``InputError`` for an unknown figure, a missing dataset, or one without points for a
    figure. Of several errors the first is raised; the others are printed on standard error.
    """
    entries = load_study(study_path, None).entries if study_path else None
    specs = {name: find_spec(name, entries) for name in names}
    records = read_records(out_folder) if code else {}
    outdated = [
        name
        for name, spec in specs.items()
        if name not in records
        or records[name] != current_record(spec, dataset_path, out_folder, code)
    ]
    forks = get_context("fork")
    with ProcessPoolExecutor(max(1, min(processes, len(outdated))), forks) as pool:
        futures = {
            name: pool.submit(render, specs[name], dataset_path, out_folder) for name in outdated
        }
        problems = {name: future.exception() for name, future in futures.items()}
    if code and outdated and out_folder.is_dir():
        for name in (name for name, problem in problems.items() if not problem):
            if record := current_record(specs[name], dataset_path, out_folder, code):
                records[name] = record
        write_records(out_folder, records)
    if failures := [problem for problem in problems.values() if problem]:
        for problem in failures[1:]:
            print(f"error: {problem}", file=sys.stderr)
        raise failures[0]
