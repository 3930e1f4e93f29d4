"""Curves of papers' figures: the velocity of flows, or measures of them, against a parameter."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.axes import mark_cut_bars, set_log, set_plain_ticks, set_ticks
from sim.figures.caption import point_notes
from sim.figures.data import (
    FigureData,
    Quantity,
    point_table,
    quantities,
    quantity_table,
    varying_parameters,
)
from sim.figures.family import draw_family, name_bands
from sim.figures.plot import given_labels, label_axes, nonpositive_note, panels
from sim.figures.style import LEVEL, PATTERNS, legend_title, look_of, place_legend
from sim.measures.belt import speed_along_x
from sim.parameters import SYSTEMS
from sim.study.plot_kinds import WIDEST_INTERVAL, FigureSpec

#: Largest acceleration of the belt that is drawn (g): well within the flow.
_LARGEST = 3.0

#: Room beyond the values on a logarithmic axis, as a factor.
_BEYOND = 1.4

#: Points of print between two curves of the chute.
_PITCH = 3.2

#: Depths of the paper's figures, named on the axis wherever they are.
_OF_PAPER = (0.5, 1.24, 2.5, 5, 10, 20, 40)

#: Length of the horizontal axis, about, inches.
_LENGTH = 4.4


def select(data: FigureData) -> FigureData:
    """Return the points to draw, the belt's acceleration in a column ``acceleration_ratio`` (g).

    With the option ``relative`` of a figure these are the points near the onset of transport.
    """
    if not data.spec.relative:
        return data
    rows = data.rows
    vertical = rows["amplitude"] * rows["diameter"]
    rate = 2 * np.pi * rows["frequency"]
    rows = rows.assign(acceleration_ratio=rate**2 * vertical / rows["gravity"])
    return replace(data, rows=rows[rows["acceleration_ratio"] <= _LARGEST])


def shown_quantities(data: FigureData) -> list[Quantity]:
    """Return the measures of a figure, or the velocity, or its share of the belt's along x."""
    if not data.spec.relative:
        return quantities(data)
    rows, along = data.rows, speed_along_x(data.rows)
    value, half_width = rows["velocity"] / along, rows["half_width"] / along
    label = "velocity over the belt's along x [1]"
    return [Quantity("relative_velocity", label, value, half_width)]


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    if not data.spec.relative:
        return point_table(data)
    along = {"acceleration of the belt [g]": data.rows["acceleration_ratio"]}
    return quantity_table(data, shown_quantities(data), along)


def notes(data: FigureData) -> list[str]:
    """Return the notes on bars, markers, and values that a logarithmic axis omits."""
    log, shown = data.spec.log, shown_quantities(data)
    omitted = sum(int((quantity.value <= 0).sum()) for quantity in shown) if "y" in log else 0
    bars = name_bands(point_notes(data), data.rows[data.spec.axes[0]])
    return [*bars, *nonpositive_note(omitted, "values" if omitted > 1 else "value")]


def draw(data: FigureData) -> Figure:
    """Draw the curves, and limit the axes as the system asks for."""
    spec, shown = data.spec, shown_quantities(data)
    figure, each = panels(data)
    for axes, rows in each:
        (_draw_belt if spec.system == "belt" else _draw_chute)(axes, rows, shown, spec)
    label_axes(figure, each, *given_labels(data))
    names = _telling_parameters(spec)
    named = varying_parameters(data.rows, names)
    place_legend(figure, each[0][0], legend_title(spec.system, named))
    return figure


def _telling_parameters(spec: FigureSpec) -> list[str]:
    """Return the parameters that may tell curves apart."""
    others = {*spec.axes, *spec.alike}
    return [name for name in SYSTEMS[spec.system].model_fields if name not in others]


def _draw_families(
    axes: Axes,
    rows: pd.DataFrame,
    shown: Sequence[Quantity],
    spec: FigureSpec,
    unjoined: Callable[[Quantity], pd.Series | None] = lambda quantity: None,
    pitch: float = 0,
) -> None:
    """Draw the curves of each quantity, named by what the figure names or else by what varies."""
    along = "acceleration_ratio" if spec.relative else spec.axes[0]
    names = _telling_parameters(spec)
    is_named = spec.styles or spec.entry
    keys = [name for name in spec.curves if is_named or rows[name].nunique() > 1]
    measures = spec.quantities or ({},)
    for quantity, measure in zip(shown, measures, strict=True):
        draw_family(
            axes,
            quantity.rows_with_value(rows),
            quantity,
            along,
            keys,
            names,
            look=look_of(spec, keys, measure),
            unjoined=unjoined(quantity),
            pitch=pitch,
        )
    for measure in measures:
        # Dashes alone tell the measures of a curve apart.
        if "dashes" in measure and "colour" not in measure:
            look: dict[str, Any] = {"color": "#666666", "linestyle": PATTERNS[measure["dashes"]]}
            axes.plot([], [], label=measure["entry"], **look)


def _draw_levels(axes: Axes, spec: FigureSpec) -> None:
    for level in spec.levels:
        axes.axhline(level, **LEVEL)
    if spec.level:
        axes.plot([], [], label=spec.level, **LEVEL)


def _draw_belt(axes: Axes, rows: pd.DataFrame, shown: Sequence[Quantity], spec: FigureSpec) -> None:
    """Draw curves of the belt, with a line at zero or at the acceleration of gravity."""
    _draw_families(axes, rows, shown, spec)
    along = rows[spec.axes[0]]
    if spec.relative:
        axes.axvline(1, **LEVEL)
    elif "y" in spec.log:
        axes.set_yscale("log")
    elif len(shown) == 1:
        axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
        axes.set_xlim(left=-0.02 * along.max())
    else:
        axes.set_ylim(bottom=0)
    _draw_levels(axes, spec)
    if "x" in spec.log:
        axes.set_xscale("log")
        axes.set_xlim(0.8 * along.min(), 1.25 * along.max())
        set_ticks(axes, along, _LENGTH)


def _draw_chute(
    axes: Axes, rows: pd.DataFrame, shown: Sequence[Quantity], spec: FigureSpec
) -> None:
    """Draw velocities, with natural units, too, or measures.

    Curves of one quantity stand aside of each other, those of several do not.
    """
    pitch = _PITCH if len(shown) == 1 else 0
    _draw_families(axes, rows, shown, spec, _disagreeing, pitch)
    _draw_levels(axes, spec)
    _set_x_axis(axes, rows, spec)
    # The axis ends where intervals over two replicates may go on.
    values = pd.concat([quantity.value for quantity in shown])
    if "y" in spec.log:
        set_log(axes, "y")
        if not (above := values[values > 0]).empty:
            axes.set_ylim(above.min() / _BEYOND, above.max() * _BEYOND)
    else:
        highest = values.max()
        axes.set_ylim(0, min(axes.get_ylim()[1], 1.5 * highest) if highest > 0 else 1)
    mark_cut_bars(axes)
    if shown[0].name == "velocity":
        _add_natural_units(axes, rows)


def _add_natural_units(axes: Axes, rows: pd.DataFrame) -> None:
    """Add an axis at the right with the velocity in units of √(gσ)."""
    unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
    right = axes.secondary_yaxis(
        "right", functions=(lambda v: np.divide(v, unit), lambda v: np.multiply(v, unit))
    )
    if axes.get_yscale() == "log":
        set_plain_ticks(right.yaxis)
    right.set_ylabel("V/√(gσ)")
    axes.spines["right"].set_visible(True)


def _disagreeing(quantity: Quantity) -> pd.Series:
    """Return which points no line joins, as their replicates are of different flows."""
    return quantity.half_width > WIDEST_INTERVAL * quantity.value.abs()


def _set_x_axis(axes: Axes, rows: pd.DataFrame, spec: FigureSpec) -> None:
    """Put a tick at each value that was run.

    Depths for which there is no room beside the paper's, or each other, have no number.
    """
    if "x" in spec.log:
        axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.autoscale_view()
    first = _OF_PAPER if spec.axes[0] == "depth" else ()
    set_ticks(axes, rows[spec.axes[0]], _LENGTH, first=first)
