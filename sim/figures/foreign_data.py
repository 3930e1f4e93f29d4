"""Foreign data in a plot, not simulated by the study: grey markers and dashed lines.

Option of a figure: ``beside``, a list of data sets. Each is a label, its points (x, y) or (x, y,
error of y) in the units of the axes, and whether a line joins them.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from sim.figures.axes import set_ticks
from sim.figures.data import FigureData
from sim.figures.plot import Panels
from sim.figures.style import escape_label

#: Column of the plotted data with the label of foreign rows; empty for rows of the study.
FOREIGN_COLUMN = "not of this study"

#: Column of the plotted data with the errors of foreign rows.
ERROR_COLUMN = "error, not of this study"

#: Bars of errors; markers and lines, one per label; no curve or regime of a study has the same.
_MARKERS = ("+", (6, 2, 0), "1", "2", "3", "4")
_DASHES = ((2, 1), (9, 3), (9, 2, 2, 2))
_BARS: dict[str, Any] = {"color": "#555555", "linewidth": 0.9, "zorder": 1.9}
_LINES = tuple((colour, (0, dash)) for colour in ("#666666", "#aaaaaa") for dash in _DASHES)


#: Most values of a parameter that have a tick each.
MOST_TICKS = 12


def draw_foreign_data(data: FigureData, shown: Panels) -> dict[str, Line2D]:
    """Draw the foreign data in all panels; return the legend entries by label."""
    entries = {}
    markers, lines = iter(_MARKERS), iter(_LINES)
    for label, points, joined in data.spec.options["beside"]:
        look = _line(*next(lines)) if joined else _marker(next(markers))
        x, y, *errors = zip(*points, strict=True)
        for axes, _ in shown:
            (entries[escape_label(label)],) = axes.plot(x, y, **look)
            if errors:
                axes.vlines(x, *np.add(y, [[-1], [1]] * np.array(errors)), **_BARS)
    return entries


def _line(colour: str, dashes: object) -> dict[str, Any]:
    """Return the style of a line, which lies beneath the data of the study."""
    return {"color": colour, "linestyle": dashes, "linewidth": 1.8, "zorder": 1.8}


def _marker(marker: object) -> dict[str, Any]:
    """Return the style of markers, which lie above all else and have a white edge."""
    look = {"color": "#555555", "linestyle": "none", "marker": marker, "zorder": 4}
    edge = withStroke(linewidth=3.2, foreground="white")
    return look | {"markersize": 6.5, "markeredgewidth": 1.3, "path_effects": [edge]}


def foreign_values(data: FigureData, axis: str) -> pd.Series:
    """Return the coordinates of the foreign data, and ends of bars, along ``"x"`` or ``"y"``."""
    points = [point for _, points, _ in data.spec.options["beside"] for point in points]
    if axis == "x":
        return pd.Series([x for x, *_ in points], dtype=float)
    ends = [y + sign * error for _, y, *errors in points for error in errors for sign in (-1, 1)]
    return pd.Series([*(y for _, y, *_ in points), *ends], dtype=float)


def set_run_ticks(axes: Axes, data: FigureData, name: str, length: float, axis: str = "x") -> None:
    """Put ticks at the values of a parameter that were run, unless there are many.

    Nor where foreign data exceed their range. ``length`` is the approximate length of the axis,
    inches.
    """
    values, others = data.rows[name], foreign_values(data, axis)
    if values.nunique() <= MOST_TICKS and others.between(values.min(), values.max()).all():
        set_ticks(axes, values, length, vertical=axis == "y")


def append_foreign_data(data: FigureData, table: pd.DataFrame, x: str, y: str) -> pd.DataFrame:
    """Append the foreign data to the plotted data; ``x`` and ``y`` are the columns of the axes."""
    rows = [
        dict(zip((FOREIGN_COLUMN, x, y, ERROR_COLUMN), (label, *point), strict=False))
        for label, points, _ in data.spec.options["beside"]
        for point in points
    ]
    if not rows:
        return table
    errors = [ERROR_COLUMN] if any(ERROR_COLUMN in row for row in rows) else []
    study_rows = [
        {str(name): value for name, value in row.items()} for row in table.to_dict("records")
    ]
    return pd.DataFrame([*study_rows, *rows], columns=[FOREIGN_COLUMN, *table.columns, *errors])


def foreign_data_notes(data: FigureData) -> list[str]:
    """Return the sentence of the caption on foreign data; empty without any."""
    labels = [
        f"{label} ({'line' if joined else 'markers'}{', bars: its errors' * (len(points[0]) > 2)})"
        for label, points, joined in data.spec.options["beside"]
    ]
    return (
        [f"In grey, from elsewhere and not simulated here: {'; '.join(labels)}."] if labels else []
    )
