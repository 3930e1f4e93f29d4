"""Velocity of chute flows, or measures of them, over their depth.

Options of a figure: ``quantities``, the measures (of the velocity, none); ``axis``, label of the
vertical axis; ``levels`` to compare with; ``log``, the logarithmic axes, y alone.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.bars import mark_cut_bars
from sim.figures.curves import draw_family
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import Look, look_of, look_of_measure
from sim.figures.quantity import Quantity, quantities, velocity
from sim.figures.style import LEVEL, canvas, place_legend
from sim.figures.ticks import set_ticks
from sim.parameters import SYSTEMS
from sim.study.figure_spec import WIDEST_INTERVAL, FigureSpec

#: Room above the highest flow that does not accelerate, and above the markers at the edge.
_HEADROOM, _EDGE = 1.05, 1.02

#: Width of a range of velocities above the axes, as a share of them.
_TEXT_WIDTH = 0.13

#: Points of print between two curves.
_PITCH = 2.4

#: Depths of the paper's figures, named on the axis wherever they are.
_OF_PAPER = (0.5, 1.24, 2.5, 5, 10, 20, 40)

#: Length of the axis of depth, about, inches.
_LENGTH = 4.4


def _unjoined(rows: pd.DataFrame, quantity: Quantity) -> pd.Series:
    """Return which flows no line joins: those that accelerate, and means of different flows."""
    unknown = quantity.half_width > WIDEST_INTERVAL * quantity.value.abs()
    return (rows["regime"] == "accelerating") | unknown


def _varied(rows: pd.DataFrame, spec: FigureSpec) -> tuple[str, ...]:
    """Return the parameters that tell the curves of a figure apart among some points."""
    return tuple(name for name in spec.curves if rows[name].nunique() > 1)


def _set_depth_axis(axes: Axes, depths: Iterable[float]) -> None:
    """Make the horizontal axis one of depth, with a tick at each one that was run.

    Those for which there is no room beside the paper's, or each other, have no number.
    """
    axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.autoscale_view()
    set_ticks(axes, depths, _LENGTH, first=_OF_PAPER)
    axes.set_xlabel("depth n (particles per σ²)")


def draw(data: FigureData) -> Figure:
    """Draw the figure: velocities have a scale in natural units, too."""
    figure, axes = canvas()
    if "quantities" in data.spec.options:
        _draw_measures(axes, data)
    else:
        _draw_velocities(axes, data)
    place_legend(figure, axes)
    return figure


def _draw_measures(axes: Axes, data: FigureData) -> None:
    """Draw measures; curves of one stand aside of each other, those of several do not."""
    spec, shown = data.spec, quantities(data)
    for quantity, option in zip(shown, spec.options["quantities"], strict=True):
        rows, apart = quantity.rows_with_value(data.rows), _unjoined(data.rows, quantity)
        if len(shown) == 1:
            _draw_curves(axes, rows, quantity, spec, apart)
        else:
            look = look_of_measure(spec, _varied(rows, spec), option)
            _draw_curves(axes, rows, quantity, spec, apart, look=look, pitch=0)
    for level in spec.options.get("levels", ()):
        axes.axhline(level, **LEVEL)
    _set_depth_axis(axes, data.rows["depth"])
    if "y" in spec.options.get("log", ()):
        axes.set_yscale("log")
    else:
        # The axis ends where intervals over two replicates may go on.
        highest = max(quantity.value.max() for quantity in shown)
        axes.set_ylim(0, min(axes.get_ylim()[1], 1.5 * highest) if highest > 0 else 1)
    axes.set_ylabel(spec.options["axis"])
    mark_cut_bars(axes)


def _draw_curves(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    spec: FigureSpec,
    apart: pd.Series,
    *,
    look: Look | None = None,
    pitch: float = _PITCH,
) -> None:
    """Draw the curves of a quantity over the depth, interrupted at the flows ``apart``."""
    names, keys = tuple(SYSTEMS["chute"].model_fields), _varied(rows, spec)
    look = look or look_of(spec, keys)
    draw_family(axes, rows, quantity, "depth", keys, names, look=look, unjoined=apart, pitch=pitch)


def _draw_velocities(axes: Axes, data: FigureData) -> None:
    """Draw velocities; flows beyond the scale are markers at its top."""
    rows, quantity = data.rows, velocity(data.rows)
    apart = _unjoined(rows, quantity)
    ceiling = _ceiling(rows, apart)
    above = rows["velocity"] > ceiling
    clipped = replace(
        quantity,
        value=quantity.value.clip(upper=ceiling),
        half_width=quantity.half_width.mask(above),
    )
    _draw_curves(axes, rows, clipped, data.spec, apart | above)
    _set_depth_axis(axes, rows["depth"])
    axes.set_ylim(0, _EDGE * ceiling if above.any() else ceiling)
    mark_cut_bars(axes)
    _name_off_scale(axes, rows[above])
    axes.set_ylabel("mean velocity V (m/s)")
    unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
    right = axes.secondary_yaxis(
        "right", functions=(lambda v: np.divide(v, unit), lambda v: np.multiply(v, unit))
    )
    right.set_ylabel("V / √(gσ)")
    axes.spines["right"].set_visible(True)


def _ceiling(rows: pd.DataFrame, apart: pd.Series) -> float:
    """Return the top of the vertical axis: the flows that do not accelerate fill it."""
    bounded = rows[~apart]
    bounded = bounded[bounded["completed"] > 0]
    if bounded.empty:
        bounded = rows[rows["completed"] > 0]
    top = (bounded["velocity"] + bounded["half_width"].fillna(0)).max()
    return _HEADROOM * top if top > 0 else 1.0


def _name_off_scale(axes: Axes, rows: pd.DataFrame) -> None:
    """Write above the axes, where nothing strikes it, which velocities are off the scale."""
    to_axes, lines = axes.transData + axes.transAxes.inverted(), list[float]()
    for depth, above in rows.groupby("depth"):
        place = float(to_axes.transform((depth, 0.0))[0])
        free = (line for line, last in enumerate(lines) if place - last >= _TEXT_WIDTH)
        line = next(free, len(lines))
        lines[line : line + 1] = [place]
        low, high = (f"{value:.2g}" for value in (above["velocity"].min(), above["velocity"].max()))
        axes.annotate(
            "↑ " + (low if low == high else f"{low} … {high}"),
            (depth, 1),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 2 + 9 * line),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
            color="#444444",
        )


KIND = Kind(draw)
