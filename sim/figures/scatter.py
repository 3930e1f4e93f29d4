"""Points scattered in several parameters, one against another, and means along each of them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.caption import not_drawn, point_notes
from sim.figures.data import Drawing, FigureData, is_undecided, parameter_unit, quantity_table
from sim.figures.plot import (
    MOST_COLUMNS,
    PANEL_SIZE,
    append_foreign_data,
    draw_foreign_data,
    foreign_values,
    label_axes,
    observed_quantity,
    panels,
    write_no_data,
)
from sim.figures.style import COLOURS, PALE, explain_markers, limit_axis
from sim.figures.variables import Variable, colour, legend, observable, parameter, rows_with_values
from sim.study.plottable import REGIME, numbers

#: Fewest points of a panel that have a running mean.
FEWEST_FOR_MEAN = 12


def draw(data: FigureData) -> Figure:
    """Draw a marker per point with its intervals, and the running mean of many points."""
    x, y = coordinates(data)
    figure, shown = panels(data)
    shade = colour(data)
    for axes, rows in shown:
        points = drawable(data, rows)
        _draw_bars(axes, data, points)
        draw_points(axes, points, x, y, shade)
        moving = averaged(points)
        if has_mean(moving, x):
            draw_running_mean(axes, x.values[moving.index], y.values[moving.index], log=y.log)
    write_no_data(shown, y.name)
    if shade:
        shade.explain_colours(figure, shown)
    foreign = draw_foreign_data(data, shown)
    for axes, _ in shown:
        for axis, variable in (("x", x), ("y", y)):
            variable.scale(axes, axis)
            if not variable.log and not variable.choices:
                values = variable.values[drawable(data, data.rows).index]
                limit_axis(axes, axis, values, foreign_values(data, axis))
    label_axes(figure, shown, x.label, y.label)
    legend(data, figure, shown, foreign=foreign)
    return figure


def coordinates(data: FigureData) -> list[Variable]:
    """Return what is on x and on y."""
    spec = data.spec
    across = [parameter(data, name, log="x" in spec.log) for name in spec.axes[:1]]
    return [*(across or [observable(data, "second", "x")]), observable(data, "show", "y")]


def drawable(data: FigureData, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the completed points that have a value of all that is shown."""
    shown = rows_with_values(data, filter(None, [*coordinates(data), colour(data)]))
    return rows[rows.index.isin(shown.index)]


def averaged(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the points that a mean over points takes: those that do not accelerate."""
    return rows[rows["regime"] != "accelerating"]


def has_mean(rows: pd.DataFrame, x: Variable) -> bool:
    """Return whether points have a running mean along x."""
    return len(rows) >= FEWEST_FOR_MEAN and x.values[rows.index].nunique() > 2


def _draw_bars(axes: Axes, data: FigureData, rows: pd.DataFrame) -> None:
    x, y = coordinates(data)
    for key, quantity in (("xerr", x.quantity), ("yerr", y.quantity)):
        if quantity:
            look: dict[str, Any] = {"ecolor": "#9a9a9a", "elinewidth": 0.6, "capsize": 0}
            look |= {key: quantity.half_width[rows.index], "fmt": "none", "zorder": 1.5}
            axes.errorbar(x.values[rows.index], y.values[rows.index], **look)


def draw_points(
    axes: Axes,
    rows: pd.DataFrame,
    x: Variable,
    y: Variable,
    shade: Variable | None,
    size: float = 22.0,
) -> None:
    """Draw markers in the colours of ``shade``: filled, pale or open, as those of curves.

    ``size`` is their area in square points.
    """
    colours = (
        np.tile(to_rgba(COLOURS[1]), (len(rows), 1))
        if shade is None
        else shade.colours(shade.values[rows.index])
    )
    is_pale = is_undecided(rows).to_numpy()
    is_open = (rows["regime"] != "steady").to_numpy() & ~is_pale
    faces = colours.copy()
    faces[is_pale, 3] = PALE
    faces[is_open] = to_rgba("white")
    if shade is None or shade.name != REGIME:
        explain_markers(axes, rows)
    axes.scatter(
        x.values[rows.index],
        y.values[rows.index],
        s=size,
        facecolors=faces,
        edgecolors=list(map(tuple, colours)),
        linewidths=1.0,
        zorder=3,
        # At the edge, too, a marker is whole.
        clip_on=False,
    )


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    spec = data.spec
    is_observed = spec.colour in numbers(spec.system)
    options = ["second"] * bool(spec.second) + ["show"] + ["colour"] * is_observed
    rows = quantity_table(data, [observed_quantity(data, option) for option in options])
    x = observed_quantity(data, options[0]).label if options[0] == "second" else rows.columns[1]
    return append_foreign_data(data, rows, x, observed_quantity(data).label)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on the running mean, bars, markers and gaps."""
    (x, y), rows = coordinates(data), drawable(data, data.rows)
    quantities = [one.quantity for one in (x, y) if one.quantity]
    panel = data.spec.panels
    parts = [part for _, part in rows.groupby(panel)] if panel else [rows]
    kind = "mean of the logarithm" if y.log else "mean"
    line = (
        f"Line: {kind} over {GROUPS}; band: its 95 % interval (Student). Points that accelerate "
        "take no part."
    )
    completed = int((data.rows["completed"] > 0).sum())
    return [
        *point_notes(replace(data, rows=rows), quantities),
        *([line] if any(has_mean(averaged(part), x) for part in parts) else []),
        *not_drawn(completed - len(rows), "without a value"),
    ]


#: Fewest and most groups, and fewest points of a value of x that is a group of its own.
_FEWEST, _MOST, _OF_ONE_VALUE = 3, 10, 3

#: What captions say of the groups.
GROUPS = "groups of points that are neighbours along x"


def binned_means(x: pd.Series, y: pd.Series, *, log: bool = False) -> pd.DataFrame:
    """Return the mean of ``y`` in groups of points that are neighbours in ``x``.

    There are about as many groups as points in each. Where x has few values, each is a group. A row
    per group has ``from``, ``to`` and the mean ``x``, the ``mean`` (with ``log`` of the logarithm)
    with the ends ``low`` and ``high`` of Student's 95 % interval, not-a-number for one point, and
    the number of ``points``.
    """
    points = pd.DataFrame({"x": x, "y": np.log(y) if log else y}).dropna()
    if points["x"].nunique() * _OF_ONE_VALUE <= len(points):
        groups = points["x"]
    else:
        number = int(np.clip(round(len(points) ** 0.5), _FEWEST, _MOST))
        groups = pd.qcut(points["x"].rank(method="first"), number, labels=False)
    rows = []
    for _, group in points.groupby(groups):
        mean, half = group["y"].mean(), float(student_half_width(group["y"].to_numpy()))
        ends = np.array([mean, mean - half, mean + half])
        values = np.exp(ends) if log else ends
        rows.append([group["x"].min(), group["x"].max(), group["x"].mean(), *values, len(group)])
    return pd.DataFrame(rows, columns=["from", "to", "x", "mean", "low", "high", "points"])


def draw_running_mean(axes: Axes, x: pd.Series, y: pd.Series, *, log: bool) -> None:
    """Draw a line through the means of `binned_means`, and a band of their intervals."""
    means = binned_means(x, y, log=log)
    axes.fill_between(
        means["x"], means["low"], means["high"], color="#000000", alpha=0.13, linewidth=0, zorder=1
    )
    axes.plot(means["x"], means["mean"], color="#333333", linewidth=1.6, zorder=2.5)


# Main effects: means over groups of points along each of several parameters.


def _draw_effects(data: FigureData) -> Figure:
    """Draw a panel per parameter, all with the same vertical axis."""
    y = observable(data, "show", "y")
    variables, rows = (
        [parameter(data, name) for name in data.spec.axes],
        averaged(rows_with_values(data, [y])),
    )
    down = -(-len(variables) // MOST_COLUMNS)
    across = -(-len(variables) // down)
    size = (PANEL_SIZE[0] * across * 0.85 + 0.8, PANEL_SIZE[1] * down + 0.3)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(down, across, sharey=True, squeeze=False)
    for axes, x in zip(grid.flat, variables, strict=False):
        _draw_effect(axes, x, y, rows)
        axes.set_xlabel(x.label)
    for axes in grid.flat[len(variables) :]:
        axes.set_visible(False)
    y.scale(grid[0, 0], "y")
    if not y.log:
        limit_axis(grid[0, 0], "y", y.values[rows.index])
    figure.supylabel(y.label, fontsize=10)
    write_no_data([(grid[0, 0], data.rows)], y.name)
    return figure


def _draw_effect(axes: Axes, x: Variable, y: Variable, rows: pd.DataFrame) -> None:
    at = x.values[rows.index]
    axes.plot(at, y.values[rows.index], ".", color="#bbbbbb", markersize=3, zorder=1)
    means = binned_means(at, y.values[rows.index], log=y.log)
    axes.errorbar(
        means["x"],
        means["mean"],
        yerr=[means["mean"] - means["low"], means["high"] - means["mean"]],
        color=COLOURS[1],
        marker="o",
        linestyle="none" if x.choices else "-",
        elinewidth=1.0,
        zorder=3,
    )
    x.scale(axes, "x")


def _effects_table(data: FigureData) -> pd.DataFrame:
    y = observable(data, "show", "y")
    heading = y.quantity.label if y.quantity else ""
    unit = heading[heading.index("[") :]
    rows, parts = averaged(rows_with_values(data, [y])), []
    for x in [parameter(data, name) for name in data.spec.axes]:
        means = binned_means(x.values[rows.index], y.values[rows.index], log=y.log)
        if x.choices:
            for column in ("from", "to", "x"):
                means[column] = [x.text(value) for value in means[column]]
        means.insert(0, "unit of the parameter", parameter_unit(data.spec.system, x.name))
        means.insert(0, "parameter", x.name)
        parts.append(means)
    headings = {
        "x": "mean of the parameter",
        "mean": heading,
        "low": f"lower end of 95 % interval {unit}",
        "high": f"upper end of 95 % interval {unit}",
    }
    return pd.concat(parts).rename(columns=headings)


def _effects_notes(data: FigureData) -> list[str]:
    y = observable(data, "show", "y")
    rows = rows_with_values(data, [y])
    missing = int((data.rows["completed"] > 0).sum()) - len(rows)
    kind = "mean of the logarithm" if y.log else "mean"
    return [
        f"Markers: {kind} over {GROUPS}, with its 95 % interval (Student); grey dots: the points.",
        "All other parameters are averaged over.",
        *not_drawn(len(rows) - len(averaged(rows)), "without a steady mean, as they accelerate"),
        *not_drawn(missing, "without a value"),
    ]


MAIN_EFFECTS = Drawing(_draw_effects, _effects_table, _effects_notes)
