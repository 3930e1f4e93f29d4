"""From a dataset to the four files of a figure: PNG, SVG or GIF, the data, the caption."""

import importlib
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from sim.base.errors import InputError
from sim.base.files import replacing
from sim.dataset.results import Results, load_results
from sim.figures.animation import save_gif
from sim.figures.caption import (
    caveat_sentence,
    failure_sentence,
    interval_sentence,
    parameters_sentence,
    protocol_sentence,
    regime_sentence,
)
from sim.figures.columns import parameter_columns
from sim.figures.regime_map import boundary_sentence
from sim.figures.style import SETTINGS
from sim.figures.summary import FigureData, figure_data
from sim.study.catalogue import FIGURES, FigureSpec

#: Resolution of the first picture of an animation, dots per inch.
POSTER = 150

#: Passes of the layout at most.
PASSES = 6

#: Parameters that every table of data tells beside those of its figure.
PROTOCOL = ("protocol", "target", "limit")


def draw(name: str, dataset_path: str | Path, out_folder: str | Path) -> list[Path]:
    """Draw one figure of a study.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    dataset_path : str or Path
        The study's ``dataset.nc``.
    out_folder : str or Path
        Folder for the files; made if absent.

    Returns
    -------
    list of Path
        ``<name>.png``, ``.svg``, ``.csv`` (the data behind the picture) and ``.caption.txt``; of an
        animation ``.gif`` instead of ``.svg``.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for the figure.
    """
    if name not in FIGURES:
        raise InputError.of_value("figure", "name", name, "one of " + ", ".join(FIGURES))
    return render(FIGURES[name], Path(dataset_path), Path(out_folder))


def render(spec: FigureSpec, dataset_path: Path, folder: Path) -> list[Path]:
    """Draw one figure and write its files into ``folder``; see `sim.figures.draw`.

    Its module gives the texts ``LEAD``, ``NAMED`` (parameters) and ``PAPER`` of the caption and the
    function ``draw(data)``, which returns a figure, or an `Animation` of one that moves. It may
    give ``select(data)``, which narrows the points to those drawn, ``table(data)``, the data behind
    what are not velocities, and ``notes(data)``, the sentences on error bars where they are not
    those of velocities.
    """
    results = load_results(dataset_path)
    try:
        data, module = _drawn(spec, results)
    except KeyError as error:
        raise InputError(f"{dataset_path}: not the dataset of a study: {error}") from None
    if data.rows.empty:
        raise InputError(f"{dataset_path}: figures: no point feeds {spec.name}")
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{spec.name}{suffix}" for suffix in spec.suffixes]
    with ExitStack() as stack:
        still, other, csv, text = (stack.enter_context(replacing(file)) for file in files)
        stack.enter_context(mpl.rc_context(SETTINGS))
        drawn = module.draw(data)
        figure = drawn.figure if spec.animated else drawn
        if not data.rows["completed"].any():
            figure.axes[0].text(
                0.5, 0.5, "no point completed", ha="center", transform=figure.axes[0].transAxes
            )
        settle(figure)
        # Without a date in them, the same data gives the same bytes.
        if spec.animated:
            save_gif(drawn, other)
        else:
            figure.savefig(other, format="svg", metadata={"Title": spec.title, "Date": None})
        figure.savefig(still, format="png", dpi=POSTER if spec.animated else None)
        _save_small(still, spec.title)
        for file, content in zip((csv, text), _texts(data, spec, module), strict=True):
            file.write_text(content, encoding="utf-8")
    return files


def settle(figure: Figure) -> None:
    """Lay out a figure until its axes stay where they are.

    The first pass does not know yet how large axes to scale become, and may leave their labels
    beyond the edges.
    """
    places = None
    for _ in range(PASSES):
        before, places = places, [axes.get_position().bounds for axes in figure.axes]
        if before is not None and np.allclose(before, places, atol=1e-3):
            break
        figure.draw_without_rendering()


def derived(spec: FigureSpec, results: Results) -> tuple[str, str]:
    """Return what the files of a figure's data (CSV) and caption hold, without drawing it."""
    data, module = _drawn(spec, results)
    return _texts(data, spec, module)


def _drawn(spec: FigureSpec, results: Results) -> tuple[FigureData, ModuleType]:
    """Return the data that a figure shows, and its module."""
    data = figure_data(results, spec)
    module = importlib.import_module(f"sim.figures.{spec.name}")
    if hasattr(module, "select") and not data.rows.empty:
        data = module.select(data)
    return data, module


def _texts(data: FigureData, spec: FigureSpec, module: ModuleType) -> tuple[str, str]:
    """Return the data behind a figure as CSV, and its caption."""
    table = module.table(data) if hasattr(module, "table") else velocities(data, spec, module)
    return table.to_csv(index=False, float_format="%.10g"), caption(data, spec, module) + "\n"


def _save_small(picture: Path, title: str) -> None:
    """Write a PNG again with 256 colours, a third of its size, and its title."""
    with Image.open(picture) as opened:
        small = opened.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    told = PngInfo()
    told.add_itxt("Title", title)
    small.save(picture, format="PNG", optimize=True, pnginfo=told, dpi=opened.info.get("dpi"))


def caption(data: FigureData, spec: FigureSpec, module: ModuleType) -> str:
    """Return the caption: what is drawn, parameters, error bars, regimes, what is missing.

    It ends with what the paper says that the figure shows.
    """
    rows = data.rows
    if hasattr(module, "notes"):
        values = module.notes(data)
    elif spec.regimes:
        values = [boundary_sentence(data.boundaries, spec.axes)]
    else:
        values = [interval_sentence(rows), regime_sentence(rows)]
    sentences = (
        f"{spec.paper}. {module.LEAD}",
        parameters_sentence(rows, spec.system, module.NAMED),
        protocol_sentence(rows, spec.system),
        *values,
        caveat_sentence(rows),
        failure_sentence(rows),
        module.PAPER,
    )
    return " ".join(sentence for sentence in sentences if sentence)


def velocities(data: FigureData, spec: FigureSpec, module: ModuleType) -> pd.DataFrame:
    """Return the data behind a figure of velocities, one row per point."""
    names = dict.fromkeys([*spec.axes, *spec.curves, *module.NAMED, *PROTOCOL])
    return behind(data.rows, spec.system, list(names))


def behind(rows: pd.DataFrame, system: str, parameters: list[str]) -> pd.DataFrame:
    """Return parameters and outcome of points, one row each, units in the headings."""
    return pd.DataFrame(
        parameter_columns(rows, system, parameters)
        | {
            "mean velocity [m s-1]": rows["velocity"],
            "half width of 95 % interval [m s-1]": rows["half_width"],
            "interval": rows["interval"],
            "completed replicates": rows["completed"],
            "replicates": rows["replicates"].astype(int),
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
            "stopped by": rows["stopped"],
            "reason of failures": rows["reason"],
            "caveat": rows["caveat"],
        }
    )
