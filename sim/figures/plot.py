"""Helpers of the plots that a study file defines: observables, units, panels, labels and looks."""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter

from sim.dataset import replicates
from sim.figures.caption import observable_text, parameter_text, scale_of, unit_of
from sim.figures.data import (
    FigureData,
    Quantity,
    parameter_columns,
    replicate_means,
    varying_parameters,
)
from sim.figures.style import escape_label, settings, with_subscript
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import PROTOCOLS
from sim.study.plot_contents import name_in_words
from sim.study.plottable import Observable, numbers

#: Size (inches) of a plot with one panel, size of each of several, and the most panels in a row.
SINGLE_SIZE, PANEL_SIZE, MOST_COLUMNS = (5.6, 3.9), (2.8, 2.6), 3

#: Pairs of the axes of a panel and the points (rows) that it shows.
Panels = list[tuple[Axes, pd.DataFrame]]

#: Most characters in a line of an axis label, and of a message.
_LABEL_WIDTH, _MESSAGE_WIDTH = 44, 62


def one_panel(size: tuple[float, float] = SINGLE_SIZE) -> tuple[Figure, Axes]:
    """Return a new figure and its only axes."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots()


def message_figure(text: str) -> Figure:
    """Return a figure with a message, where there is nothing else to show."""
    figure, axes = one_panel()
    axes.set_axis_off()
    lines = textwrap.fill(text, _MESSAGE_WIDTH)
    axes.text(0.5, 0.5, lines, ha="center", va="center", transform=axes.transAxes)
    return figure


def observed_quantity(data: FigureData, option: str = "show") -> Quantity:
    """Return the observable that an option names, for every point and in the units of the plot."""
    spec, rows = data.spec, data.rows
    observable = numbers(spec.system)[getattr(spec, option)]
    unit, scale = (unit_of(observable.unit, spec.units, spec.system), _scale(data, observable))
    label = f"{observable.meaning} [{unit or '1'}]"
    if observable.name == "velocity":
        return Quantity(
            observable.name, label, rows["velocity"] / scale, rows["half_width"] / scale
        )
    return replicate_means(observable.name, label, replicate_values(data, observable), rows.index)


def replicate_values(data: FigureData, observable: Observable) -> list[np.ndarray]:
    """Return one array per point: an observable of its replicates, in the units of the plot.

    Replicates without a finite value, such as failed ones, are left out.
    """
    values = replicates.replicate_values(data.results, observable, data.rows["point"].tolist())
    return [row / divisor for row, divisor in zip(values, _scale(data, observable), strict=True)]


def _scale(data: FigureData, observable: Observable) -> pd.Series:
    return scale_of(observable.unit, data.spec.units, data.rows)


def scale_of_point(data: FigureData, row: Mapping[str, Any], unit: str) -> float:
    """Return the divisor from an SI unit to the units of the plot, for the point of a row."""
    return float(scale_of(unit, data.spec.units, pd.DataFrame([row])).iloc[0])


def named_columns(data: FigureData, rows: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the columns of a plot's data that identify its points, units in the headings."""
    spec = data.spec
    names = dict.fromkeys((*spec.axes, *spec.groups, *curve_keys(data)))
    return parameter_columns(rows, spec.system, names)


def completed_rows(data: FigureData) -> list[dict[str, Any]]:
    """Return the columns of each completed point by name."""
    completed = data.rows[data.rows["completed"] > 0].to_dict("records")
    return [{str(name): value for name, value in row.items()} for row in completed]


def rows_of_points(
    data: FigureData,
    headings: Mapping[str, str],
    values: Callable[[Mapping[str, Any]], pd.DataFrame],
    names: Sequence[str] = (),
) -> pd.DataFrame:
    """Return the rows of data that a point has several of, after the columns that identify it.

    ``values`` returns those of a completed point, ``headings`` are those of its columns, and
    ``names`` parameters in place of the usual ones.
    """
    completed = data.rows[data.rows["completed"] > 0]
    id_columns = (
        parameter_columns(completed, data.spec.system, names)
        if names
        else named_columns(data, completed)
    )
    parts = [
        pd.DataFrame({name: column[index] for name, column in id_columns.items()} | {**values(row)})
        for index, row in zip(completed.index, completed_rows(data), strict=True)
    ]
    rows = pd.concat(parts) if parts else pd.DataFrame(columns=[*id_columns, *headings])
    return rows.rename(columns=headings)


def observable_label(data: FigureData, observable: Observable) -> str:
    """Return the axis label of an observable: its name and unit."""
    units, system = data.spec.units, data.spec.system
    return wrap_label(observable_text(observable.name, observable.unit, units, system))


def units_of_parameters(data: FigureData) -> str:
    """Return ``natural`` where that is the unit of a figure and numbers of parameters have it."""
    are_one = (data.rows[["diameter", "mass", "gravity"]] == 1).all(axis=None)
    return data.spec.units if are_one else "si"


def parameter_label(system: str, name: str, units: str = "si") -> str:
    """Return the axis label of a parameter, in the unit of study files."""
    text = wrap_label(parameter_text(system, name, units))
    return with_subscript(text, field_info(SYSTEMS[system])[name].symbol)


def wrap_label(text: str) -> str:
    """Break a label into lines that fit along an axis, and escape it for matplotlib."""
    return escape_label("\n".join(textwrap.wrap(text, _LABEL_WIDTH)))


def panels(data: FigureData) -> tuple[Figure, Panels]:
    """Return a new figure and its panels: axes, each with the points that it shows."""
    rows, name = data.rows, data.spec.panels
    if not name:
        figure, axes = one_panel()
        return figure, [(axes, rows)]
    protocols = PROTOCOLS[data.spec.system] if name == "protocol" else {}
    values = sorted(set(rows[name]), key=list(protocols).index if protocols else None)
    down = -(-len(values) // MOST_COLUMNS)
    across = -(-len(values) // down)
    size = (PANEL_SIZE[0] * across + 0.6, PANEL_SIZE[1] * down + 0.8)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    shown = []
    for axes, value in zip(grid.flat, values, strict=False):
        title = protocols.get(value) or settings(data.spec.system, [(name, value)])
        axes.set_title(title, fontsize=9)
        shown.append((axes, rows[rows[name] == value]))
    for axes in grid.flat[len(values) :]:
        axes.set_visible(False)
        # The panel above has no neighbour below, so it shows its own tick labels.
        grid[down - 2, list(grid[-1]).index(axes)].tick_params(labelbottom=True)
    return figure, shown


def label_axes(figure: Figure, shown: Panels, x: str, y: str) -> None:
    """Label the axes of a single panel, or the whole figure once where it has several."""
    if len(shown) == 1:
        shown[0][0].set_xlabel(x)
        shown[0][0].set_ylabel(y)
    else:
        figure.supxlabel(x, fontsize=10)
        figure.supylabel(y, fontsize=10)


def given_labels(data: FigureData) -> tuple[str, str]:
    """Return the labels of both axes of a figure, by default names and units of what is there."""
    spec, labels = data.spec, data.spec.labels
    observables = spec.keys.shows(spec.system)
    if spec.second:
        usual = [observable_label(data, observables[spec.second])]
    else:
        units = units_of_parameters(data)
        usual = [parameter_label(spec.system, name, units) for name in spec.axes[:2]]
    if measures := spec.quantities:
        usual[1:] = [measures[0].label]
    elif spec.show in observables and not spec.keys.is_map:
        usual[1:] = [observable_label(data, observables[spec.show])]
    return labels.get("x", usual[0]), labels.get("y", usual[1])


def above_zero(data: FigureData, axis: str, values: np.ndarray) -> np.ndarray:
    """Return values, with not-a-number for those ≤ 0 where the axis is logarithmic."""
    return np.where(values > 0, values, np.nan) if axis in data.spec.log else values


def curve_keys(data: FigureData) -> tuple[str, ...]:
    """Return the parameters that name curves: those of the option, then all others that vary."""
    spec, rows = data.spec, data.rows
    apart = {*spec.axes, *spec.groups, *spec.by, *spec.alike}
    parameters = [name for name in SYSTEMS[spec.system].model_fields if name not in apart]
    return *spec.by, *varying_parameters(rows, parameters)


def write_no_data(shown: Panels, noun: str) -> None:
    """Write on each empty panel that no run has the observable ``noun``.

    Nothing is written where no point has completed: `sim.figures.render` does that for all figures.
    """
    for axes, _ in shown if any(rows["completed"].any() for _, rows in shown) else ():
        if not axes.has_data():
            text = f"no run has {name_in_words(noun)}"
            axes.text(0.5, 0.5, text, ha="center", transform=axes.transAxes)


# Foreign data in a plot, not simulated by the study: grey markers and dashed lines.

#: Columns of the plotted data with the label of foreign rows (empty for those of the study), and
#: with their errors.
FOREIGN_COLUMN, ERROR_COLUMN = "not of this study", "error, not of this study"

#: Bars of errors; markers and lines, one per label; no curve or regime of a study has the same.
_MARKERS = ("+", (6, 2, 0), "1", "2", "3", "4")
_DASHES = ((2, 1), (9, 3), (9, 2, 2, 2))
_BARS: dict[str, Any] = {"color": "#555555", "linewidth": 0.9, "zorder": 1.9}
_MARK: dict[str, Any] = {"markersize": 6.5, "markeredgewidth": 1.3, "zorder": 4}
_LINES = tuple((colour, (0, dash)) for colour in ("#666666", "#aaaaaa") for dash in _DASHES)


def draw_foreign_data(data: FigureData, shown: Panels) -> dict[str, Line2D]:
    """Draw the foreign data in all panels; return the legend entries by label."""
    entries = {}
    markers, lines = iter(_MARKERS), iter(_LINES)
    for label, points, joined in data.spec.foreign:
        colour, dashes = next(lines) if joined else ("#555555", "none")
        look: dict[str, Any] = {"color": colour, "linestyle": dashes, "linewidth": 1.8}
        look |= {"zorder": 1.8} if joined else _MARK | {"marker": next(markers)}
        x, y, *errors = zip(*points, strict=True)
        for axes, _ in shown:
            (entries[escape_label(label)],) = axes.plot(x, y, **look)
            if errors:
                axes.vlines(x, *np.add(y, [[-1], [1]] * np.array(errors)), **_BARS)
    return entries


def foreign_values(data: FigureData, axis: str) -> pd.Series:
    """Return the coordinates of the foreign data, and ends of bars, along ``"x"`` or ``"y"``."""
    points = [point for _, points, _ in data.spec.foreign for point in points]
    if axis == "x":
        return pd.Series([x for x, *_ in points], dtype=float)
    ends = [y + sign * error for _, y, *errors in points for error in errors for sign in (-1, 1)]
    return pd.Series([*(y for _, y, *_ in points), *ends], dtype=float)


def mark_runs(axes: Axes, values: pd.Series, axis: str = "x") -> None:
    """Put a small tick, without a number, at each value of a parameter that was run."""
    along = axes.xaxis if axis == "x" else axes.yaxis
    along.set_minor_locator(FixedLocator(sorted(set(values))))
    along.set_minor_formatter(NullFormatter())


def append_foreign_data(data: FigureData, table: pd.DataFrame, x: str, y: str) -> pd.DataFrame:
    """Append the foreign data to the plotted data; ``x`` and ``y`` are the columns of the axes."""
    rows = [
        dict(zip((FOREIGN_COLUMN, x, y, ERROR_COLUMN), (label, *point), strict=False))
        for label, points, _ in data.spec.foreign
        for point in points
    ]
    if not rows:
        return table
    errors = [ERROR_COLUMN] if any(ERROR_COLUMN in row for row in rows) else []
    columns = [FOREIGN_COLUMN, *table.columns, *errors]
    return pd.DataFrame([*table.to_dict("records"), *rows], columns=columns)
