"""How a number is distributed over the replicates of each point: a study's own plot.

Options of a figure: those of `sim.figures.plot`.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.plot import (
    above_zero,
    empty_text,
    keys_of,
    label_axes,
    legend,
    look_of_all,
    lost_note,
    named_columns,
    observable_label,
    panels,
    parameter_label,
    replicate_values,
    set_log,
    without_note,
)
from sim.figures.style import PALE
from sim.figures.units import unit_of
from sim.study.plottable import numbers

#: Part of the room of a value of x that its dots fill, and in which those of a curve are spread.
_ROOM, _SPREAD = 0.7, 0.6


def draw(data: FigureData) -> Figure:
    """Draw a dot per replicate, and a bar at their median; the values of x stand evenly apart."""
    spec = data.spec
    (along,), one = spec.axes, numbers(spec.system)[spec.options["show"]]
    values = pd.Series(replicate_values(data, one), data.rows.index)
    figure, shown = panels(data)
    places = {value: place for place, value in enumerate(sorted(set(data.rows[along])))}
    for axes, rows in shown:
        _draw_curves(axes, data, rows, values, places)
        axes.set_xticks(list(places.values()), [f"{value:g}" for value in places])
        if len(places) > 8:
            axes.tick_params(axis="x", labelrotation=90)
        axes.set_xlim(-0.6, len(places) - 0.4)
        axes.grid(visible=False, axis="x")
        if "y" in spec.options["log"]:
            set_log(axes, "y")
    label_axes(figure, shown, parameter_label(spec.system, along), observable_label(data, one))
    empty_text(shown, one.name)
    legend(figure, shown)
    return figure


def _draw_curves(
    axes: Axes, data: FigureData, rows: pd.DataFrame, values: pd.Series, places: dict[float, int]
) -> None:
    """Draw the replicates of points, those of each curve beside those of the others.

    The bar is at the median of all, drawn or not.
    """
    keys = list(keys_of(data))
    look = look_of_all(data, keys)
    curves = [names for names, _ in data.rows.groupby(keys)] if keys else [()]
    width = _ROOM / len(curves)
    named: set[str] = set()
    for index, row in rows.iterrows():
        own = tuple(row[name] for name in keys)
        style, label = look(dict(zip(keys, own, strict=True)), 0)
        place = curves.index(own) - (len(curves) - 1) / 2
        middle = places[row[data.spec.axes[0]]] + width * place
        found = np.sort(values[index])
        if not found.size:
            continue
        aside = width * _SPREAD * (np.arange(found.size) * 0.618 % 1 - 0.5)
        dots: dict[str, Any] = {"color": style.colour, "alpha": 2 * PALE, "markersize": 3.5}
        entry = label if label not in named else None
        axes.plot(middle + aside, found, style.marker, label=entry, zorder=3, **dots)
        ends = [middle - 0.4 * width, middle + 0.4 * width]
        axes.plot(ends, [np.median(found)] * 2, color=style.colour, linewidth=1.8, zorder=4)
        named.add(label)


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per replicate, units in the headings."""
    spec, one = data.spec, numbers(data.spec.system)[data.spec.options["show"]]
    unit = unit_of(one.unit, spec.options["units"], spec.system) or "1"
    held = pd.DataFrame(named_columns(data, data.rows))
    held["regime"] = data.rows["regime"]
    held[f"{one.name} [{unit}]"] = pd.Series(replicate_values(data, one), data.rows.index)
    return held.explode(f"{one.name} [{unit}]")


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of dots and bars."""
    one = numbers(data.spec.system)[data.spec.options["show"]]
    found = replicate_values(data, one)
    completed = data.rows["completed"] > 0
    unknown = sum(not each.size for each, done in zip(found, completed, strict=True) if done)
    values = np.concatenate([np.zeros(0), *found])
    lost = int(np.isnan(above_zero(data, "y", values)).sum())
    return [
        "A dot per completed replicate, spread sideways; bars: medians. x is not to scale.",
        *without_note(unknown),
        *lost_note(lost, "replicates" if lost > 1 else "replicate"),
        unsteady_sentence(data.rows),
    ]


KIND = Kind(draw, table=table, notes=notes)
