"""Parallel coordinates: a line per point through its parameters, coloured by an observable.

Options of a figure: those of `sim.figures.plot`.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData, quantity_table
from sim.figures.plot import missing_value_note, observed_quantity
from sim.figures.style import OPEN_MEANS, PALE_MEANS, is_undecided, legend_above
from sim.figures.variables import Colours, Variable, known_rows, observable, parameters

#: Width of the figure, and of each axis and least of all, inches.
_HEIGHT, _PER_AXIS, _LEAST = 3.9, 1.15, 5.6

#: Room above and below the axes, relative to their length; opacity of pale lines; dashes.
_BEYOND, _PALE, _DASHES = 0.07, 0.5, (0, (4, 2))


def draw(data: FigureData) -> Figure:
    """Draw a line per point, dashed where it is not steady and pale where the run is too short."""
    shade, _ = observable(data, "show", "y")
    variables, rows = parameters(data), known_rows(data, [shade])
    width = max(_LEAST, _PER_AXIS * len(variables) + 1.5)
    figure = Figure(figsize=(width, _HEIGHT), layout="constrained")
    axes = figure.subplots()
    # What stands out lies above.
    rows = rows.loc[shade.values[rows.index].sort_values().index]
    heights = np.column_stack([_heights(one, rows) for one in variables])
    lines = [np.column_stack([range(len(variables)), line]) for line in heights]
    is_pale = is_undecided(rows).to_numpy()
    steady = (rows["regime"] == "steady").to_numpy() | is_pale
    colours = Colours(shade).of(shade.values[rows.index])
    colours[is_pale, 3] = _PALE
    dashes = ["-" if one else _DASHES for one in steady]
    axes.add_collection(LineCollection(lines, colors=colours, linestyles=dashes, linewidths=1.2))
    for place, variable in enumerate(variables):
        _draw_axis(axes, place, variable, rows)
    axes.set_xlim(-0.35, len(variables) - 0.65)
    axes.set_ylim(-_BEYOND, 1 + _BEYOND)
    axes.set_xticks(range(len(variables)), [_wrapped(one) for one in variables])
    axes.tick_params(axis="x", length=0)
    axes.set_yticks([])
    axes.grid(visible=False)
    axes.spines[["left", "bottom"]].set_visible(False)
    Colours(shade).explain(figure, [axes])
    looks: dict[str, tuple[np.ndarray, dict[str, Any]]] = {
        PALE_MEANS: (is_pale, {"alpha": _PALE}),
        OPEN_MEANS: (~steady, {"linestyle": _DASHES}),
    }
    marks = {
        label: Line2D([], [], color="#444444", **look)
        for label, (mask, look) in looks.items()
        if mask.any()
    }
    if marks:
        legend_above(figure, list(marks.values()), list(marks))
    return figure


def _heights(variable: Variable, rows: pd.DataFrame) -> np.ndarray:
    """Return where points lie between the ends of the axis of a variable, 0 to 1, (N,)."""
    values = variable.values[rows.index].to_numpy(float)
    if not values.size:
        return values
    places = np.log(values) if variable.log else values
    low, high = places.min(), places.max()
    return (places - low) / (high - low) if high > low else np.full(len(places), 0.5)


def _draw_axis(axes: Axes, place: int, variable: Variable, rows: pd.DataFrame) -> None:
    """Draw the axis of a variable with the values at its ends, or each choice."""
    axes.plot([place, place], [0, 1], color="#000000", linewidth=0.9, zorder=3)
    values = variable.values[rows.index]
    shown = sorted(set(values)) if variable.choices else [values.min(), values.max()]
    look: dict[str, Any] = {"ha": "center", "fontsize": 8.5, "zorder": 4}
    for value in dict.fromkeys(shown) if len(values) else ():
        (height,) = set(_heights(variable, rows)[values.to_numpy() == value])
        side = {0.0: ("top", -0.02), 1.0: ("bottom", 0.02)}.get(height, ("center", 0))
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}
        axes.text(place, height + side[1], variable.text(value), va=side[0], bbox=box, **look)


def _wrapped(variable: Variable) -> str:
    """Return the label of an axis, its words below each other, and whether it is logarithmic."""
    return variable.label.replace(" ", "\n") + "\n(log)" * variable.log


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    return quantity_table(data, [observed_quantity(data)])


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on lines and gaps."""
    rows = known_rows(data, [observable(data, "show", "y")[0]])
    missing = int((data.rows["completed"] > 0).sum()) - len(rows)
    return [
        "A line per point; the values at the ends of each axis are its smallest and its largest.",
        unsteady_sentence(rows, "dashed or, of runs too short to tell, pale"),
        *missing_value_note(missing),
    ]
