"""Maps of the stability of each corrector, with real beds in them at the paper's time step."""

from pathlib import Path as FilePath
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.stability.amplification import SCHEMES, limit
from sim.base.files import atomic_write
from sim.figures.style import COLOURS, DASHES, SETTINGS

#: Frequencies (Hz) that are marked on the paths of beds, and the largest that is written there.
MARKED = (10, 12, 15, 20, 30, 50)
NAMED = 12

#: Largest λΔt of the maps, by corrections.
TOPS = {1: 0.6, 2: 1.9}
WIDEST = 0.7


class Path(NamedTuple):
    """A bed at all frequencies: its ``name``, largest damping ``rate`` and ``frequency`` (1/s)."""

    name: str
    rate: float
    frequency: float


def draw(paths: list[Path]) -> Figure:
    """Return the figure: a map per number of corrections, an edge per order."""
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    for axes, (corrections, top) in zip(figure.subplots(1, 2), TOPS.items(), strict=True):
        own = [one for one in SCHEMES if one.corrections == corrections]
        frequency = np.linspace(0.0, WIDEST, 33)
        for scheme, colour in zip(own, COLOURS[1:], strict=False):
            edge = np.array([limit(scheme, each) for each in frequency])
            axes.plot(frequency, edge, color=colour, label=f"order {scheme.order}")
            axes.fill_between(frequency, edge, color=colour, alpha=0.08, linewidth=0)
        for path, dashes in zip(paths, DASHES[1:], strict=False):
            _draw_path(axes, path, dashes)
        axes.set_title("one correction" if corrections == 1 else "two corrections")
        axes.set_xlim(0, WIDEST)
        axes.set_ylim(0, top)
        axes.set_xlabel("frequency ωΔt")
        axes.set_ylabel("damping rate λΔt")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def _draw_path(axes: Axes, path: Path, dashes: object) -> None:
    """Draw where a bed is under the paper's step from 10 Hz on, with some frequencies marked."""
    step = 1.0 / (2000.0 * np.geomspace(10, 1000, 50))
    style = {"color": COLOURS[0], "linewidth": 1.0}
    axes.plot(path.frequency * step, path.rate * step, linestyle=dashes, label=path.name, **style)
    for frequency in MARKED:
        place = path.frequency / 2000 / frequency, path.rate / 2000 / frequency
        axes.plot(*place, marker="o", markersize=3, color=COLOURS[0])
        if frequency <= NAMED:
            text = f"{frequency} Hz"
            axes.annotate(text, place, (5, -7), textcoords="offset points", fontsize=7)


def write(file: FilePath, paths: list[Path]) -> None:
    """Draw the figure into a PNG file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(SETTINGS), atomic_write(file) as temporary:
        draw(paths).savefig(temporary, format="png")
