"""A map over two parameters, whose colours are regimes or a number: a study's own plot.

Options of a figure: those of `sim.figures.plot`; ``show`` may be ``"regime"``.
"""

from typing import Any

import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from sim.figures.beside import beside_notes, draw_beside, set_run_ticks, with_beside
from sim.figures.caption import unsteady_sentence
from sim.figures.configuration import COLOURS
from sim.figures.data import FigureData, velocity_table
from sim.figures.kind import Kind
from sim.figures.plot import (
    SEVERAL,
    SINGLE,
    Panels,
    label_axes,
    legend,
    observable_label,
    observed,
    panels,
    parameter_label,
    set_log,
    width_of,
    without_note,
)
from sim.figures.quantity import quantity_table
from sim.figures.regimes import MARKS
from sim.study.plot_file import REGIME
from sim.study.plottable import numbers

#: Size of a marker of a number, points.
_MARKER = 11.0


def draw(data: FigureData) -> Figure:
    """Draw a marker per point: of its regime, or coloured by a number."""
    spec = data.spec
    figure, shown = panels(data)
    if spec.options["show"] == REGIME:
        _draw_regimes(data, shown)
    else:
        _draw_values(data, figure, shown)
    beside = draw_beside(data, shown)
    _set_axes(data, shown)
    label_axes(figure, shown, *(parameter_label(spec.system, name) for name in spec.axes))
    legend(figure, shown, beside)
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
    """Draw squares filled with the colour of a value; open ones have none."""
    x, y = data.spec.axes
    known = _known(data)
    scale = LogNorm if "colour" in data.spec.options["log"] else Normalize
    norm = scale(known.min(), known.max()) if len(known) else Normalize()
    for axes, rows in shown:
        without = rows[~rows.index.isin(known.index)]
        axes.plot(without[x], without[y], "s", color="#888888", markerfacecolor="white", zorder=2)
        part = rows[rows.index.isin(known.index)]
        axes.scatter(
            part[x],
            part[y],
            s=_MARKER**2,
            c=COLOURS(norm(known[part.index])),
            marker="s",
            edgecolors="#444444",
            linewidths=0.5,
            zorder=3,
        )
    bar = figure.colorbar(ScalarMappable(norm, COLOURS), ax=[axes for axes, _ in shown], pad=0.02)
    bar.set_label(observable_label(data, numbers(data.spec.system)[data.spec.options["show"]]))
    bar.outline.set_visible(False)


def _known(data: FigureData) -> pd.Series:
    """Return the values that a colour can show, of their points."""
    value = observed(data).value
    return value[value > 0] if "colour" in data.spec.options["log"] else value.dropna()


def _set_axes(data: FigureData, shown: Panels) -> None:
    """Set scales, and ticks at the values that were run."""
    x, y = data.spec.axes
    log = data.spec.options["log"]
    height = SINGLE[1] - 1.0 if len(shown) == 1 else SEVERAL[1] - 0.5
    for axes, _ in shown:
        for axis in {"x", "y"} & set(log):
            set_log(axes, axis)
        axes.margins(0.1)
        axes.autoscale_view()
        set_run_ticks(axes, data, x, width_of(shown))
        set_run_ticks(axes, data, y, height, "y")


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the map, one row per point, units in the headings."""
    of_regimes = data.spec.options["show"] == REGIME
    found = velocity_table(data) if of_regimes else quantity_table(data, [observed(data)])
    # Behind the name of the point.
    _, x, y, *_ = found.columns
    return with_beside(data, found, x, y)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of markers."""
    if data.spec.options["show"] == REGIME:
        return ["One marker per point.", *beside_notes(data)]
    unknown = len(data.rows) - len(_known(data))
    value = "a value above 0" if "colour" in data.spec.options["log"] else "a value"
    without = without_note(unknown, value, "Open")
    return ["One square per point.", *without, unsteady_sentence(data.rows), *beside_notes(data)]


KIND = Kind(draw, table=table, notes=notes)
