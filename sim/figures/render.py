"""Write the four files of a figure from a dataset: PNG, SVG or GIF, data and caption."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.dataset.results import Results, load_results, require_known_options
from sim.figures.caption import caption
from sim.figures.data import FigureData, figure_data
from sim.figures.gif import Animation, save_gif
from sim.figures.style import SETTINGS
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import FigureSpec
from sim.study.plot_kinds import PlotKind, find_kind

#: Resolution of the first picture of an animation, dots per inch.
POSTER = 150

#: Most passes of the layout.
PASSES = 6


def find_spec(name: str, plots: Mapping[str, FigureSpec] | None = None) -> FigureSpec:
    """Return the specification of a figure: a plot of the study, or an entry of the catalogue.

    Raises ``InputError`` for an unknown name.
    """
    specs = {**FIGURES, **(plots or {})}
    if name not in specs:
        hint = (
            "" if plots is not None else "with --study STUDY.yaml a plot of that study; without, "
        )
        raise InputError.of_value("figure", "name", name, f"{hint}one of {', '.join(specs)}")
    return specs[name]


def render(spec: FigureSpec, dataset_path: Path, folder: Path) -> list[Path]:
    """Draw one figure of a study into files.

    Parameters
    ----------
    spec : FigureSpec
        Its specification.
    dataset_path : Path
        The study's ``dataset.nc``.
    folder : Path
        Folder for the files; made if absent.

    Returns
    -------
    list of Path
        ``<name>.png``, ``.svg``, ``.csv`` (the plotted data) and ``.caption.txt``. An animation has
        ``.gif`` instead of ``.svg``.

    Raises
    ------
    InputError
        For a missing dataset, or one without points for the figure.
    """
    results = load_results(dataset_path)
    require_known_options(results.dataset, dataset_path)
    try:
        data, kind = _data_and_kind(spec, results)
    except KeyError as error:
        raise InputError(f"{dataset_path}: not the dataset of a study: {error}") from None
    if data.rows.empty:
        raise InputError(f"{dataset_path}: figures: no point feeds {spec.name}")
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{spec.name}{suffix}" for suffix in spec.suffixes]
    with ExitStack() as stack:
        still, other, csv, text = (stack.enter_context(atomic_write(file)) for file in files)
        stack.enter_context(mpl.rc_context(SETTINGS))
        drawn = kind.draw(data)
        figure = drawn.figure if isinstance(drawn, Animation) else drawn
        if not data.rows["completed"].any():
            figure.axes[0].text(
                0.5, 0.5, "no point completed", ha="center", transform=figure.axes[0].transAxes
            )
        settle(figure)
        # Without a date, the same data give the same bytes.
        if isinstance(drawn, Animation):
            save_gif(drawn, other)
        else:
            figure.savefig(other, format="svg", metadata={"Title": spec.title, "Date": None})
        figure.savefig(still, format="png", dpi=POSTER if spec.animated else None)
        _save_small(still, spec.title)
        for file, content in zip((csv, text), _texts(data, kind), strict=True):
            file.write_text(content, encoding="utf-8")
    return files


def settle(figure: Figure) -> None:
    """Repeat the layout of a figure until its axes stay in place.

    The first pass does not know the final size of axes with a fixed aspect, and may leave their
    labels beyond the edges.
    """
    bounds = None
    for _ in range(PASSES):
        previous, bounds = bounds, [axes.get_position().bounds for axes in figure.axes]
        if previous is not None and np.allclose(previous, bounds, atol=1e-3):
            break
        figure.draw_without_rendering()


def derive_texts(spec: FigureSpec, results: Results) -> tuple[str, str]:
    """Return the data (CSV) and the caption of a figure as texts, without drawing it."""
    return _texts(*_data_and_kind(spec, results))


def _data_and_kind(spec: FigureSpec, results: Results) -> tuple[FigureData, PlotKind]:
    """Return the selected data of a figure, and its kind."""
    data, kind = figure_data(results, spec), find_kind(spec.kind)
    return data if data.rows.empty else kind.select(data), kind


def _texts(data: FigureData, kind: PlotKind) -> tuple[str, str]:
    """Return the plotted data as CSV, and the caption."""
    table = kind.table(data).to_csv(index=False, float_format="%.10g")
    return table, caption(data, kind.notes(data)) + "\n"


def _save_small(picture: Path, title: str) -> None:
    """Rewrite a PNG with 256 colours, a third of its size, and with its title."""
    with Image.open(picture) as image:
        small = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    metadata = PngInfo()
    metadata.add_itxt("Title", title)
    small.save(picture, format="PNG", optimize=True, pnginfo=metadata, dpi=image.info.get("dpi"))
