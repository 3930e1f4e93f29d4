"""A number of each point against a parameter, with its intervals: a study's own plot.

Options of a figure: those of `sim.figures.plot`.
"""

from dataclasses import replace

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.caption import quantity_notes, velocity_notes
from sim.figures.curves import draw_family, mark_cut_bars
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.plot import (
    Panels,
    empty_text,
    keys_of,
    label_axes,
    legend,
    look_of_all,
    observable_label,
    observed,
    panels,
    parameter_label,
    set_log,
    width_of,
)
from sim.figures.quantity import Quantity, quantity_table
from sim.figures.ticks import set_ticks
from sim.study.plottable import numbers

#: Points of print between two curves.
_PITCH = 2.4

#: Room above and below the values for their intervals, in parts of the range of the values.
_ROOM = 0.6


def draw(data: FigureData) -> Figure:
    """Draw the curves; lines are interrupted at flows that accelerate."""
    spec, quantity = data.spec, observed(data)
    (along,), log = spec.axes, spec.options["log"]
    figure, shown = panels(data)
    look, keys = look_of_all(data), keys_of(data)
    for axes, rows in shown:
        known = rows[quantity.value[rows.index].notna()]
        apart = known["regime"] == "accelerating"
        draw_family(axes, known, quantity, along, keys, (), look=look, unjoined=apart, pitch=_PITCH)
    _set_axes(data, shown, log, quantity)
    for axes, _ in shown:
        mark_cut_bars(axes)
    what = numbers(spec.system)[spec.options["show"]]
    label_axes(figure, shown, parameter_label(spec.system, along), observable_label(data, what))
    empty_text(shown, spec.options["show"])
    legend(figure, shown)
    return figure


def _set_axes(data: FigureData, shown: Panels, log: tuple[str, ...], quantity: Quantity) -> None:
    """Set scales and limits, and a tick at each value that was run."""
    values = data.rows[data.spec.axes[0]]
    for axes, _ in shown:
        for axis in log:
            set_log(axes, axis)
        axes.margins(x=0.07)
        axes.autoscale_view()
        if "y" not in log:
            _end_bars(axes, quantity.value[data.rows["completed"] > 0].dropna())
        set_ticks(axes, values, width_of(shown))


def _end_bars(axes: Axes, values: pd.Series) -> None:
    """Let no interval take more room than the values do: of two replicates it may be very wide."""
    if values.empty:
        return
    least, most = _ends(values)
    low, high = axes.get_ylim()
    axes.set_ylim(max(low, least), min(high, most))


def _ends(values: pd.Series) -> tuple[float, float]:
    """Return how far an axis that is not logarithmic goes at most below and above values."""
    low, high = values.min(), values.max()
    room = _ROOM * (high - low or abs(high) or 1.0)
    return max(low - room, 0.0) if low >= 0 else low - room, high + room


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    return quantity_table(data, [observed(data)])


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of error bars and markers that there are."""
    quantity, keys = observed(data), list(keys_of(data))
    shown = data.rows[(data.rows["completed"] > 0) & quantity.value.notna()]
    own = replace(
        quantity, value=quantity.value[shown.index], half_width=quantity.half_width[shown.index]
    )
    drawn = replace(data, rows=shown)
    of_velocity = data.spec.options["show"] == "velocity"
    aside = keys and len(shown[keys].drop_duplicates()) > 1
    accelerating = (shown["regime"] == "accelerating").any()
    return [
        *(velocity_notes(drawn) if of_velocity else quantity_notes(drawn, [own])),
        *(["Error bars that end in a caret go on beyond the axes."] if _cut(data, own) else []),
        *(["Curves are drawn a little aside of each other."] if aside else []),
        *(["Lines are interrupted at flows that accelerate."] if accelerating else []),
    ]


def _cut(data: FigureData, quantity: Quantity) -> bool:
    """Return whether an error bar leaves the axes, where `mark_cut_bars` puts a caret."""
    if quantity.value.empty:
        return False
    half = quantity.half_width.fillna(0)
    lowest, highest = (quantity.value - half).min(), (quantity.value + half).max()
    if "y" in data.spec.options["log"]:
        return bool(lowest <= 0)
    least, most = _ends(quantity.value)
    return bool(lowest < least or highest > most)


KIND = Kind(draw, table=table, notes=notes)
