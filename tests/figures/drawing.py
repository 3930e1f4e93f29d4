"""Figures as their kinds of plot draw them, without files."""

import io
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sim.dataset.results import Results, load_results
from sim.figures.data import FigureData, figure_data
from sim.figures.pictures import Animation
from sim.figures.render import _contents, _texts, drawing_of, find_spec, render
from sim.figures.style import SETTINGS
from sim.study.figure_spec import FIGURES, FigureSpec

_loaded = cache(load_results)


def data_of_figure(name: str, results: Results | Path) -> FigureData:
    """Return the data of a figure, from a dataset that is loaded once."""
    return figure_data(_loaded(results) if isinstance(results, Path) else results, FIGURES[name])


def picture(data: FigureData) -> Figure | Animation:
    """Return a figure as its kind draws the points of the data."""
    with mpl.rc_context(SETTINGS):
        return drawing_of(data.spec.kind).draw(data)


def drawn(name: str, results: Results | Path) -> tuple[Any, FigureData]:
    """Return a figure as its kind draws it, and its data."""
    data = drawing_of(FIGURES[name].kind).select(data_of_figure(name, results))
    return picture(data), data


def derive_texts(spec: FigureSpec, results: Results) -> tuple[str, str]:
    """Return the data (CSV) and the caption of a figure as texts, without drawing it."""
    return _texts(*_contents(spec, results))


def texts(name: str, dataset: Path) -> tuple[pd.DataFrame, str]:
    """Return the contents of the files with the data and the caption of a figure."""
    data, caption = derive_texts(FIGURES[name], _loaded(dataset))
    return pd.read_csv(io.StringIO(data)), caption


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data of a figure."""
    return drawing_of(data.spec.kind).table(data)


def notes(data: FigureData) -> str:
    """Return the sentences of a caption on a kind of plot."""
    return " ".join(drawing_of(data.spec.kind).notes(data))


def without_particles(data: FigureData) -> FigureData:
    """Return the data of a figure without the particles of any point."""
    return replace(data, results=replace(data.results, states={}))


def dashes(line: Line2D) -> object:
    """Return the dash pattern as it was given to matplotlib."""
    offset, pattern = line._unscaled_dash_pattern
    return "-" if pattern is None else (int(offset), tuple(pattern))


def draw(name: str, dataset: Path, folder: Path) -> list[Path]:
    """Draw a figure of the catalogue; return its files."""
    return render(find_spec(name), dataset, folder)
