"""Looks of the curves of plots that a study file defines, and what tells them apart."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sim.figures.data import FigureData
from sim.figures.plot import Panels, curve_keys
from sim.figures.style import (
    MEANINGS,
    CurveStyle,
    Look,
    cycle_style,
    legend_above,
    legend_title,
    settings,
)
from sim.figures.variables import Colours, Variable, is_number, parameter

#: Most entries of a legend, beside those of foreign data.
MOST_ENTRIES = 10


def shared_look(data: FigureData, named: Sequence[str]) -> Look:
    """Return a look that gives a curve, identified by parameters, one style in all panels.

    Where a legend would be too long and one number tells the curves apart, their colours show it.
    """
    system = data.spec.system
    indices: dict[str, int] = {}
    keys, number = _keys(named), number_of_curves(data, named)
    curves = data.rows[keys].drop_duplicates().sort_values(keys) if keys else data.rows[:1]
    for values in curves[keys].to_dict("records"):
        indices[settings(system, values.items())] = len(indices)

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        label = settings(system, ((name, names[name]) for name in keys if name in names))
        if number is None:
            return cycle_style(indices.get(label, index)), label
        (shade,) = Colours(number).of(pd.Series([names[number.name]]))
        return CurveStyle(to_hex(shade), "-"), label

    return look


def number_of_curves(data: FigureData, named: Sequence[str]) -> Variable | None:
    """Return the number that alone tells more curves apart than a legend has entries, if any.

    ``named`` are the parameters that identify curves.
    """
    varied = [name for name in _keys(named) if data.rows[name].nunique() > 1]
    if len(varied) != 1 or not is_number(data.spec.system, varied[0]):
        return None
    is_long = data.rows[varied[0]].nunique() > MOST_ENTRIES
    return parameter(data, varied[0]) if is_long else None


def _keys(named: Sequence[str]) -> list[str]:
    return [name for name in named if name != "protocol"]


def legend(
    data: FigureData,
    figure: Figure,
    shown: Panels,
    named: Sequence[str] = (),
    foreign: Mapping[str, Any] | None = None,
) -> None:
    """Put one legend above all panels, with each label once; none where no curve has a label.

    Parameters
    ----------
    data : FigureData
        The data of the figure.
    figure : matplotlib.figure.Figure
        The figure; it grows where the legend has more than a few lines.
    shown : list
        Its panels. Of more curves than `MOST_ENTRIES`, the legend only gives their number, or a
        colour bar shows the number that tells them apart.
    named : sequence of str
        Parameters that identify curves; the title says what their symbols mean.
    foreign : mapping, optional
        Entries of foreign data, by label, which may equal those of curves.
    """
    entries: dict[str, Any] = {}
    for axes, _ in shown:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    entries.pop("", None)
    marks = [(label, entries.pop(label)) for label in MEANINGS if label in entries]
    if (number := number_of_curves(data, named)) is not None:
        Colours(number).explain(figure, [axes for axes, _ in shown])
        entries = {}
    if len(entries) > MOST_ENTRIES:
        entries = {f"{len(entries):,} curves, which the data names": Line2D([], [], linestyle="")}
    pairs = [*entries.items(), *marks, *(foreign or {}).items()]
    if pairs:
        varied = [name for name in _keys(named) if data.rows[name].nunique() > 1]
        title = legend_title(data.spec.system, varied) if entries else ""
        labels, handles = zip(*pairs, strict=True)
        legend_above(figure, handles, labels, title)


def groups(
    data: FigureData, rows: pd.DataFrame
) -> Iterator[tuple[CurveStyle, str, Mapping[str, Any]]]:
    """Yield style, legend entry and row of each completed point: each is one curve."""
    keys = curve_keys(data)
    look = shared_look(data, keys)
    completed = rows[rows["completed"] > 0].sort_values(list(keys)) if keys else rows
    for index, row in enumerate(completed[completed["completed"] > 0].to_dict("records")):
        names = {str(name): row[name] for name in keys}
        style, label = look(names, index)
        yield style, label, {str(name): value for name, value in row.items()}
