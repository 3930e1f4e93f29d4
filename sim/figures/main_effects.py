"""Main effects: the mean of an observable in groups of points along each of several parameters."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.axes import limit_axis
from sim.figures.caption import not_drawn
from sim.figures.data import FigureData, parameter_unit
from sim.figures.plot import MOST_COLUMNS, PANEL_SIZE, write_no_data
from sim.figures.scatter import GROUPS, averaged, binned_means
from sim.figures.style import COLOURS
from sim.figures.variables import Variable, known_rows, observable, parameter


def draw(data: FigureData) -> Figure:
    """Draw a panel per parameter, all with the same vertical axis."""
    y = observable(data, "show", "y")
    variables, rows = (
        [parameter(data, name) for name in data.spec.axes],
        averaged(known_rows(data, [y])),
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
    """Draw the points of a panel, and the means over groups of them with intervals."""
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


def table(data: FigureData) -> pd.DataFrame:
    """Return the means, one row per parameter and group, units in the headings."""
    y = observable(data, "show", "y")
    heading = y.quantity.label if y.quantity else ""
    unit = heading[heading.index("[") :]
    rows, parts = averaged(known_rows(data, [y])), []
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


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on means and points."""
    y = observable(data, "show", "y")
    rows = known_rows(data, [y])
    missing = int((data.rows["completed"] > 0).sum()) - len(rows)
    kind = "mean of the logarithm" if y.log else "mean"
    return [
        f"Markers: {kind} over {GROUPS}, with its 95 % interval (Student); grey dots: the points.",
        "All other parameters are averaged over.",
        *not_drawn(len(rows) - len(averaged(rows)), "without a steady mean, as they accelerate"),
        *not_drawn(missing, "without a value"),
    ]
