"""What all plots of a study's own share: observables in their units, panels, labels, looks.

Options of a figure: ``show``, name of the observable, and ``second``, of that on the other axis, or
nothing where a parameter is there; ``curves``, parameters that tell curves
apart, and ``panels``, one that tells panels apart, or nothing; ``units``, ``"si"`` or
``"natural"``; ``log``, axes that are logarithmic.
"""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from sim.dataset.results import Results
from sim.figures.caption import points_text
from sim.figures.data import FigureData, parameter_columns, varying
from sim.figures.looks import Look, settings
from sim.figures.quantity import Quantity, of_replicates
from sim.figures.style import LOOKS, CurveStyle, cycled, legend_above, literal
from sim.figures.units import headed, scale_of, unit_of
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import setting
from sim.study.plot_words import described, plain
from sim.study.plottable import Observable, numbers

#: Size of a plot with one panel, of each of several, and the most side by side, inches.
SINGLE, SEVERAL, ACROSS = (5.6, 3.9), (3.1, 2.7), 3

#: The axes of a figure, each with the points that it shows.
Panels = list[tuple[Axes, pd.DataFrame]]

#: Characters of the label of an axis in a line.
_LINE = 44

#: From how many times the lowest value on a logarithmic axis are there powers of ten alone.
_MANY = 300


def observed(data: FigureData, option: str = "show") -> Quantity:
    """Return the observable that an option of a plot names, in its units, of every point."""
    spec, rows = data.spec, data.rows
    one = numbers(spec.system)[spec.options[option]]
    unit, scale = unit_of(one.unit, spec.options["units"], spec.system), _scale(data, one)
    label = f"{one.meaning} [{unit or '1'}]"
    if one.name == "velocity":
        return Quantity(one.name, label, rows["velocity"] / scale, rows["half_width"] / scale)
    return of_replicates(one.name, label, replicate_values(data, one), rows.index)


def replicate_values(data: FigureData, one: Observable) -> list[np.ndarray]:
    """Return the values of an observable in the units of the plot, of each point its replicates.

    Those that failed, or do not know it, are left out.
    """
    points, scale = data.rows["point"], _scale(data, one)
    if one.is_mean:
        found = [_means(data.results, point, one.source) for point in points]
    else:
        held = data.results.dataset
        table = held[one.source].sel(point=points.values).values if one.source in held else None
        found = [np.zeros(0)] * len(points) if table is None else list(table)
    return [each[np.isfinite(each)] / by for each, by in zip(found, scale, strict=True)]


def _scale(data: FigureData, one: Observable) -> pd.Series:
    return scale_of(one.unit, data.spec.options["units"], data.rows)


def scale_of_point(data: FigureData, row: Mapping[str, Any], unit: str) -> float:
    """Return what the values of a point in an SI unit are to be divided by in a plot."""
    return float(scale_of(unit, data.spec.options["units"], pd.DataFrame([row])).iloc[0])


def named_columns(data: FigureData, rows: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the columns of a plot's data that name its points, units in the headings."""
    spec = data.spec
    names = dict.fromkeys((*spec.axes, *spec.curves, *keys_of(data)))
    return parameter_columns(rows, spec.system, names)


def _means(results: Results, point: str, profile: str) -> np.ndarray:
    """Return the means of a profile over the particles of each completed replicate, (R,)."""
    values, _ = results.profile(point, profile)
    packing, _ = results.profile(point, "packing_profile")
    weight = np.where(np.isfinite(values), packing, 0.0)
    total = weight.sum(axis=1)
    sums = (np.nan_to_num(values) * weight).sum(axis=1)
    return np.divide(sums, total, out=np.full(len(total), np.nan), where=total > 0)


def observable_label(data: FigureData, one: Observable) -> str:
    """Return the label of the axis of an observable: its name; the caption says what it means."""
    unit = unit_of(one.unit, data.spec.options["units"], data.spec.system)
    return wrapped(headed(plain(one.name), unit))


def parameter_label(system: str, name: str) -> str:
    """Return the label of the axis of a parameter, in the unit of study files."""
    row = field_info(SYSTEMS[system])[name]
    return wrapped(headed(described(system, name), row.scale or row.unit_text.strip()))


def wrapped(text: str) -> str:
    """Return a label in lines that fit along an axis, to be drawn as it is written."""
    return literal("\n".join(textwrap.wrap(text, _LINE)))


def panels(data: FigureData) -> tuple[Figure, Panels]:
    """Return a figure and its axes, each with the points that it shows."""
    rows, name = data.rows, data.spec.options["panels"]
    if not name:
        figure = Figure(figsize=SINGLE, layout="constrained")
        return figure, [(figure.subplots(), rows)]
    values = sorted(set(rows[name]))
    down = -(-len(values) // ACROSS)
    across = -(-len(values) // down)
    size = (SEVERAL[0] * across + 0.6, SEVERAL[1] * down + 0.8)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    found = []
    for axes, value in zip(grid.flat, values, strict=False):
        axes.set_title(literal(setting(data.spec.system, name, value)), fontsize=9)
        found.append((axes, rows[rows[name] == value]))
    for axes in grid.flat[len(values) :]:
        axes.set_visible(False)
        # What is above has no axis below it then.
        grid[down - 2, list(grid[-1]).index(axes)].tick_params(labelbottom=True)
    return figure, found


def label_axes(figure: Figure, shown: Panels, x: str, y: str) -> None:
    """Name the axes, those of several panels once for all of them."""
    if len(shown) == 1:
        shown[0][0].set_xlabel(x)
        shown[0][0].set_ylabel(y)
    else:
        figure.supxlabel(x, fontsize=10)
        figure.supylabel(y, fontsize=10)


def set_log(axes: Axes, axis: str) -> None:
    """Make an axis logarithmic, ``"x"`` or ``"y"``, with plain numbers at its ticks."""
    getattr(axes, f"set_{axis}scale")("log")
    ticks = axes.xaxis if axis == "x" else axes.yaxis
    ticks.set_major_locator(_Steps())
    ticks.set_major_formatter("{x:g}")
    ticks.set_minor_formatter(NullFormatter())


class _Steps(LogLocator):
    """Ticks at 1, 2 and 5 of each power of ten or, of many powers, at 1 alone."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        self.set_params(subs=(1, 2, 5) if vmax < _MANY * vmin else (1,))
        return super().tick_values(vmin, vmax)


def above_zero(data: FigureData, axis: str, values: np.ndarray) -> np.ndarray:
    """Return values with not-a-number for what has no place on an axis that is logarithmic."""
    return np.where(values > 0, values, np.nan) if axis in data.spec.options["log"] else values


def lost_note(lost: int, what: str) -> list[str]:
    """Return what the caption says of so many ``what`` that a logarithmic axis has no place for."""
    return [f"Not above 0, and so not on a logarithmic axis: {lost} {what}."] if lost else []


def without_note(count: int, what: str = "a value", mark: str = "Not drawn") -> list[str]:
    """Return what the caption says of so many points that no run knows ``what`` of."""
    return [f"{mark}: {points_text(count)} without {what}."] if count else []


def width_of(shown: Panels) -> float:
    """Return the length of the horizontal axis of a panel, about, inches."""
    return SINGLE[0] - 1.0 if len(shown) == 1 else SEVERAL[0] - 0.5


def keys_of(data: FigureData) -> tuple[str, ...]:
    """Return the parameters that name curves: those asked for, and others that vary besides."""
    spec, rows = data.spec, data.rows
    apart = {*spec.axes, *spec.curves}
    parameters = [name for name in SYSTEMS[spec.system].model_fields if name not in apart]
    return *spec.options["curves"], *varying(rows, parameters)


def look_of_all(data: FigureData, named: Sequence[str]) -> Look:
    """Return a look that is the same in all panels for the same curve, which parameters name."""
    system = data.spec.system
    places: dict[str, int] = {}
    keys = [name for name in named if name != "protocol"]
    every = data.rows[keys].drop_duplicates().sort_values(keys) if keys else data.rows[:1]
    for values in every[keys].to_dict("records"):
        places[settings(system, values.items())] = len(places)

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        label = settings(system, ((name, names[name]) for name in keys if name in names))
        return cycled(places.get(label, index)), label

    return look


def legend(figure: Figure, shown: Panels, beside: Mapping[str, Any] | None = None) -> None:
    """Put one legend for all panels above them, each entry once; none for one nameless curve.

    The figure grows by what it needs of more than a few lines. Of more curves than there are looks
    it tells how many there are. ``beside`` are entries of data beside the study's own, which may be
    called the same.
    """
    entries: dict[str, Any] = {}
    for axes, _ in shown:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    entries.pop("", None)
    if len(entries) > LOOKS:
        entries = {f"{len(entries):,} curves, which the data names": Line2D([], [], linestyle="")}
    handles = [*entries.values(), *(beside or {}).values()]
    if labels := [*entries, *(beside or {})]:
        legend_above(figure, handles, labels)


def groups(
    data: FigureData, rows: pd.DataFrame
) -> Iterator[tuple[CurveStyle, str, Mapping[str, Any]]]:
    """Yield style, legend entry and row of each completed point that is a curve of its own."""
    keys = keys_of(data)
    look = look_of_all(data, keys)
    known = rows[rows["completed"] > 0].sort_values(list(keys)) if keys else rows
    for index, row in enumerate(known[known["completed"] > 0].to_dict("records")):
        names = {str(name): row[name] for name in keys}
        style, label = look(names, index)
        yield style, label, {str(name): value for name, value in row.items()}


def empty_text(shown: Panels, what: str) -> None:
    """Say on the axes that no run knows what is shown, where nothing is drawn.

    That no point has completed is said of all figures.
    """
    for axes, _ in shown if any(rows["completed"].any() for _, rows in shown) else ():
        if not axes.has_data():
            text = f"no run has {plain(what)}"
            axes.text(0.5, 0.5, text, ha="center", transform=axes.transAxes)
