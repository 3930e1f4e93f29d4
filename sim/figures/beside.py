"""Data beside a plot's own, not simulated: grey markers and dashed lines, told apart everywhere.

Option of a figure: ``beside``, each a label, its points (x, y) in the units of the axes, and
whether a line joins them.
"""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from sim.figures.data import FigureData
from sim.figures.plot import Panels
from sim.figures.style import literal
from sim.figures.ticks import set_ticks

#: Column of the data that tells whose they are; empty for the study's own.
NOT_OWN = "not of this study"

#: As many as there may be labels, and none of them a study's own, of curves or of regimes.
_MARKERS = ("+", (6, 2, 0), "1", "2", "3", "4")
_DASHES = ((2, 1), (9, 3), (9, 2, 2, 2))
_LINES = tuple((colour, (0, dash)) for colour in ("#666666", "#aaaaaa") for dash in _DASHES)


def draw_beside(data: FigureData, shown: Panels) -> dict[str, Line2D]:
    """Draw the data beside a plot's own in all its panels; return the entries of the legend."""
    found = {}
    markers, lines = iter(_MARKERS), iter(_LINES)
    for label, points, joined in data.spec.options["beside"]:
        look = _line(*next(lines)) if joined else _marker(next(markers))
        for axes, _ in shown:
            (found[literal(label)],) = axes.plot(*zip(*points, strict=True), **look)
    return found


def _line(colour: str, dashes: object) -> dict[str, Any]:
    """Return how a line is drawn: beneath the study's own data."""
    return {"color": colour, "linestyle": dashes, "linewidth": 1.8, "zorder": 1.8}


def _marker(marker: object) -> dict[str, Any]:
    """Return how markers are drawn: above all else, with an edge of white."""
    look = {"color": "#555555", "linestyle": "none", "marker": marker, "zorder": 4}
    edge = withStroke(linewidth=3.2, foreground="white")
    return look | {"markersize": 6.5, "markeredgewidth": 1.3, "path_effects": [edge]}


def values_beside(data: FigureData, axis: str) -> pd.Series:
    """Return where the data beside are along an axis, ``"x"`` or ``"y"``."""
    place = "xy".index(axis)
    return pd.Series(
        [point[place] for _, points, _ in data.spec.options["beside"] for point in points],
        dtype=float,
    )


def set_run_ticks(axes: Axes, data: FigureData, name: str, length: float, axis: str = "x") -> None:
    """Put ticks at the values of a parameter that were run, unless data beside go beyond them.

    ``length`` is that of the axis, about, inches.
    """
    values, others = data.rows[name], values_beside(data, axis)
    if others.between(values.min(), values.max()).all():
        set_ticks(axes, values, length, vertical=axis == "y")


def with_beside(data: FigureData, table: pd.DataFrame, x: str, y: str) -> pd.DataFrame:
    """Return the data behind a plot with those beside at its end, in the columns of both axes."""
    rows = [
        {NOT_OWN: label, x: point[0], y: point[1]}
        for label, points, _ in data.spec.options["beside"]
        for point in points
    ]
    if not rows:
        return table
    every = [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]
    return pd.DataFrame([*every, *rows], columns=[NOT_OWN, *table.columns])


def beside_notes(data: FigureData) -> list[str]:
    """Return what a caption says of data beside."""
    named = [
        f"{label} ({'line' if joined else 'markers'})"
        for label, _, joined in data.spec.options["beside"]
    ]
    return [f"In grey, from elsewhere and not simulated here: {'; '.join(named)}."] if named else []
