"""Profiles of both engines side by side, and the ratios of their velocities and contact numbers."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.crosscheck.results import Comparison, Measured
from benchmarks.crosscheck.statistics import TOLERANCE, Estimate
from sim.base.files import atomic_write
from sim.figures.style import COLOURS, DASHES, SETTINGS

#: Colour and dashes of each engine.
STYLES = {"Talus": (COLOURS[1], DASHES[0]), "LAMMPS": (COLOURS[2], DASHES[1])}

#: Limits of the ratios that are shown; longer intervals run out of the picture.
RATIOS = 0.85, 1.15


def draw(profiles: list[Comparison], comparisons: list[Comparison]) -> Figure:
    """Return the figure: a column of profiles per depth, and the ratios of all flows below."""
    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    rows = figure.add_gridspec(3, len(profiles), height_ratios=[1, 1, 0.9])
    for column, c in enumerate(profiles):
        upper, lower = (figure.add_subplot(rows[row, column]) for row in (0, 1))
        upper.set_title(c.flow.name, fontsize=10)
        for name, engine in (("Talus", c.talus), ("LAMMPS", c.lammps)):
            _profile(upper, c, engine, engine.speed, name)
            _profile(lower, c, engine, engine.packing, name)
        upper.set_xlabel("velocity (√(gσ))")
        lower.set_xlabel("packing fraction")
        if column == 0:
            upper.set_ylabel("height (σ)")
            lower.set_ylabel("height (σ)")
            upper.legend(loc="upper left")
    _ratios(figure.add_subplot(rows[2, :]), comparisons)
    return figure


def _profile(axes: Axes, c: Comparison, engine: Measured, profile: Estimate, name: str) -> None:
    """Draw one profile with its band, over the slices that are compared."""
    colour, dashes = STYLES[name]
    height = (np.flatnonzero(c.slices) + 0.5) * c.flow.parameters().slice_height
    mean, width = profile.mean[c.slices], profile.half_width[c.slices]
    axes.fill_betweenx(height, mean - width, mean + width, color=colour, alpha=0.25, linewidth=0)
    axes.plot(mean, height, color=colour, linestyle=dashes, label=name)
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)


def _ratios(axes: Axes, comparisons: list[Comparison]) -> None:
    """Draw the ratios Talus over LAMMPS of all flows with their intervals."""
    place = np.arange(len(comparisons))
    axes.axhspan(1 - TOLERANCE, 1 + TOLERANCE, color="#eeeeee")
    axes.axhline(1, color=COLOURS[0], linewidth=0.8)
    series = (("velocity", "mean velocity", "o", -0.1), ("contacts", "contacts", "s", 0.1))
    for scalar, label, marker, shift in series:
        ratios = [c.ratio(scalar) for c in comparisons]
        axes.errorbar(
            place + shift,
            [r.mean for r in ratios],
            yerr=[r.half_width for r in ratios],
            linestyle="none",
            marker=marker,
            color=COLOURS[0] if marker == "o" else COLOURS[3],
            markerfacecolor=COLOURS[0] if marker == "o" else "white",
            label=label,
        )
    axes.set_xticks(place, [c.flow.name for c in comparisons])
    axes.set_ylabel("Talus / LAMMPS")
    axes.set_ylim(*RATIOS)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    axes.grid(axis="x", visible=False)


def write(path: Path, profiles: list[Comparison], comparisons: list[Comparison]) -> None:
    """Draw the figure into a PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(SETTINGS), atomic_write(path) as temporary:
        draw(profiles, comparisons).savefig(temporary, format="png")
