"""A scatter matrix of several parameters and an observable, which is also the colour.

Options of a figure: those of `sim.figures.plot`.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.caption import regime_sentence
from sim.figures.data import FigureData, quantity_table
from sim.figures.plot import missing_value_note, observed_quantity
from sim.figures.scatter import draw_points
from sim.figures.variables import Colours, Variable, known_rows, observable, parameters

#: Size of a panel, and room for labels, inches; most ticks of an axis; bins of a histogram.
_PANEL, _ROOM, _TICKS, _BINS = 1.45, 0.9, 4, 10

#: Area of a marker, square points.
_MARKER_SIZE = 9.0


def draw(data: FigureData) -> Figure:
    """Draw each pair of variables below the diagonal, and a histogram of each on it."""
    shade, _ = observable(data, "show", "y")
    variables = [*parameters(data), shade]
    rows, number = known_rows(data, [shade]), len(variables)
    side = _PANEL * number + _ROOM
    figure = Figure(figsize=(side, side - 0.3), layout="constrained")
    grid = figure.subplots(number, number, squeeze=False, sharex="col")
    for (down, across), axes in np.ndenumerate(grid):
        x, y = variables[across], variables[down]
        if across > down:
            axes.set_visible(False)
            continue
        if across == down:
            _draw_histogram(axes, x, rows)
        else:
            draw_points(axes, rows, x, y, shade, _MARKER_SIZE)
            y.scale(axes, "y", _TICKS)
        x.scale(axes, "x", _TICKS)
        _label(axes, x, y, is_lowest=down == number - 1, is_first=across == 0)
    beside = [axes for axes in grid.flat if axes.get_visible()]
    Colours(shade).explain(figure, beside, shrink=0.5, aspect=30, anchor=(0.0, 1.0))
    if number > 1:
        handles, labels = grid[1, 0].get_legend_handles_labels()
        # Where no panel is.
        figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.6, 0.97))
    figure.align_labels()
    return figure


def _draw_histogram(axes: Axes, variable: Variable, rows: pd.DataFrame) -> None:
    """Draw how many points a variable has in equal parts of its axis, or of each choice."""
    values = variable.values[rows.index]
    if variable.choices:
        bins = np.arange(len(variable.choices) + 1) - 0.5
    elif variable.log and len(values):
        bins = np.geomspace(values.min(), values.max(), _BINS + 1)
    else:
        bins = np.histogram_bin_edges(values, _BINS)
    axes.hist(values, list(bins), color="#bbbbbb", edgecolor="white", linewidth=0.5)
    axes.set_yticks([])
    axes.grid(visible=False)


def _label(axes: Axes, x: Variable, y: Variable, *, is_lowest: bool, is_first: bool) -> None:
    """Label the panels of the lowest row and of the first column; others have no tick labels."""
    axes.tick_params(labelsize=7, labelbottom=is_lowest, labelleft=is_first)
    if is_lowest:
        axes.set_xlabel(x.label, fontsize=8)
    if is_first:
        axes.set_ylabel("points" if x is y else y.label, fontsize=8)


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    return quantity_table(data, [observed_quantity(data)])


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on panels and markers."""
    rows = known_rows(data, [observable(data, "show", "y")[0]])
    missing = int((data.rows["completed"] > 0).sum()) - len(rows)
    return [
        "Diagonal: numbers of points. Other panels: a marker per point, coloured by its value.",
        regime_sentence(rows, has_bars=False),
        *missing_value_note(missing),
    ]
