"""A map of regimes or of an observable over two parameters: a plot that a study file defines.

Options of a figure: those of `sim.figures.plot`; ``show`` may be ``"regime"``.
"""

from typing import Any

import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from sim.figures.caption import unsteady_sentence
from sim.figures.chute_map import MARKS
from sim.figures.configuration import COLOURS
from sim.figures.data import FigureData, velocity_table
from sim.figures.foreign_data import (
    append_foreign_data,
    draw_foreign_data,
    foreign_data_notes,
    set_run_ticks,
)
from sim.figures.kind import Kind
from sim.figures.plot import (
    PANEL_SIZE,
    SINGLE_SIZE,
    Panels,
    label_axes,
    legend,
    missing_value_note,
    observable_label,
    observed_quantity,
    panels,
    parameter_label,
    set_log,
    width_of,
)
from sim.figures.quantity import quantity_table
from sim.study.plot_file import REGIME
from sim.study.plottable import numbers

#: Size of a square, points.
_MARKER_SIZE = 11.0


def draw(data: FigureData) -> Figure:
    """Draw a marker per point: one of its regime, or a square coloured by the observable."""
    spec = data.spec
    figure, shown = panels(data)
    if spec.options["show"] == REGIME:
        _draw_regimes(data, shown)
    else:
        _draw_values(data, figure, shown)
    foreign = draw_foreign_data(data, shown)
    _set_axes(data, shown)
    label_axes(figure, shown, *(parameter_label(spec.system, name) for name in spec.axes))
    legend(figure, shown, foreign)
    return figure


def _draw_regimes(data: FigureData, shown: Panels) -> None:
    x, y = data.spec.axes
    for axes, rows in shown:
        for regime, (marker, colour, filled) in MARKS.items():
            part = rows[rows["regime"] == regime]
            face = colour if filled else "white"
            look: dict[str, Any] = {"color": colour, "markerfacecolor": face}
            if len(part):
                axes.plot(part[x], part[y], marker, label=regime, markersize=6.0, zorder=3, **look)


def _draw_values(data: FigureData, figure: Figure, shown: Panels) -> None:
    """Draw a square per point, filled with the colour of its value; open without a value."""
    x, y = data.spec.axes
    values = _coloured_values(data)
    scale = LogNorm if "colour" in data.spec.options["log"] else Normalize
    norm = scale(values.min(), values.max()) if len(values) else Normalize()
    for axes, rows in shown:
        empty_points = rows[~rows.index.isin(values.index)]
        axes.plot(
            empty_points[x],
            empty_points[y],
            "s",
            color="#888888",
            markerfacecolor="white",
            zorder=2,
        )
        part = rows[rows.index.isin(values.index)]
        axes.scatter(
            part[x],
            part[y],
            s=_MARKER_SIZE**2,
            c=COLOURS(norm(values[part.index])),
            marker="s",
            edgecolors="#444444",
            linewidths=0.5,
            zorder=3,
        )
    bar = figure.colorbar(ScalarMappable(norm, COLOURS), ax=[axes for axes, _ in shown], pad=0.02)
    bar.set_label(observable_label(data, numbers(data.spec.system)[data.spec.options["show"]]))
    bar.outline.set_visible(False)


def _coloured_values(data: FigureData) -> pd.Series:
    """Return the values that have a colour, by row of the points."""
    value = observed_quantity(data).value
    return value[value > 0] if "colour" in data.spec.options["log"] else value.dropna()


def _set_axes(data: FigureData, shown: Panels) -> None:
    """Set scales, and put ticks at the values that were run."""
    x, y = data.spec.axes
    log = data.spec.options["log"]
    height = SINGLE_SIZE[1] - 1.0 if len(shown) == 1 else PANEL_SIZE[1] - 0.5
    for axes, _ in shown:
        for axis in {"x", "y"} & set(log):
            set_log(axes, axis)
        axes.margins(0.1)
        axes.autoscale_view()
        set_run_ticks(axes, data, x, width_of(shown))
        set_run_ticks(axes, data, y, height, "y")


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    shows_regimes = data.spec.options["show"] == REGIME
    rows = (
        velocity_table(data) if shows_regimes else quantity_table(data, [observed_quantity(data)])
    )
    # Both parameters follow the id of the point.
    _, x, y, *_ = rows.columns
    return append_foreign_data(data, rows, x, y)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on markers."""
    if data.spec.options["show"] == REGIME:
        return ["One marker per point.", *foreign_data_notes(data)]
    missing = len(data.rows) - len(_coloured_values(data))
    value = "a value above 0" if "colour" in data.spec.options["log"] else "a value"
    note = missing_value_note(missing, value, "Open")
    return ["One square per point.", *note, unsteady_sentence(data.rows), *foreign_data_notes(data)]


KIND = Kind(draw, table=table, notes=notes)
