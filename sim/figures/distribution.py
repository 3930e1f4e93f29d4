"""Distribution of an observable over the replicates of each point, defined by a study file."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.axes import set_log
from sim.figures.caption import not_drawn
from sim.figures.data import FigureData, unit_of
from sim.figures.plot import (
    above_zero,
    curve_keys,
    label_axes,
    named_columns,
    observable_label,
    panels,
    parameter_label,
    replicate_values,
    write_no_data,
)
from sim.figures.style import PALE
from sim.figures.variables import legend, shared_look
from sim.study.plottable import numbers

#: Share of the room of an x value that its curves fill, and share of that over which dots spread.
_FILLED_SHARE, _SPREAD_SHARE = 0.7, 0.6


def draw(data: FigureData) -> Figure:
    """Draw a dot per replicate and a bar at the median; x values are equally spaced."""
    spec = data.spec
    along, observable = spec.axes[0], numbers(spec.system)[spec.show]
    values = pd.Series(replicate_values(data, observable), data.rows.index)
    figure, shown = panels(data)
    places = {value: place for place, value in enumerate(sorted(set(data.rows[along])))}
    for axes, rows in shown:
        _draw_curves(axes, data, rows, values, places)
        axes.set_xticks(list(places.values()), [f"{value:g}" for value in places])
        if len(places) > 8:
            axes.tick_params(axis="x", labelrotation=90)
        axes.set_xlim(-0.6, len(places) - 0.4)
        axes.grid(visible=False, axis="x")
        if "y" in spec.log:
            set_log(axes, "y")
    label_axes(
        figure, shown, parameter_label(spec.system, along), observable_label(data, observable)
    )
    write_no_data(shown, observable.name)
    legend(data, figure, shown, curve_keys(data))
    return figure


def _draw_curves(
    axes: Axes, data: FigureData, rows: pd.DataFrame, values: pd.Series, places: dict[float, int]
) -> None:
    """Draw the replicates of points, curve next to curve at each x value.

    The bar is at the median of all replicates, including those that a logarithmic axis omits.
    """
    keys = list(curve_keys(data))
    look = shared_look(data, keys)
    curves = [names for names, _ in data.rows.groupby(keys)] if keys else [()]
    width = _FILLED_SHARE / len(curves)
    labelled: set[str] = set()
    for index, row in rows.iterrows():
        key = tuple(row[name] for name in keys)
        style, label = look(dict(zip(keys, key, strict=True)), 0)
        place = curves.index(key) - (len(curves) - 1) / 2
        middle = places[row[data.spec.axes[0]]] + width * place
        replicates = np.sort(values[index])
        if not replicates.size:
            continue
        aside = width * _SPREAD_SHARE * (np.arange(replicates.size) * 0.618 % 1 - 0.5)
        dots: dict[str, Any] = {"color": style.colour, "alpha": 2 * PALE, "markersize": 3.5}
        entry = label if label not in labelled else None
        axes.plot(middle + aside, replicates, style.marker, label=entry, zorder=3, **dots)
        ends = [middle - 0.4 * width, middle + 0.4 * width]
        axes.plot(ends, [np.median(replicates)] * 2, color=style.colour, linewidth=1.8, zorder=4)
        labelled.add(label)


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per replicate, units in the headings."""
    spec, observable = data.spec, numbers(data.spec.system)[data.spec.show]
    unit = unit_of(observable.unit, spec.units, spec.system) or "1"
    rows = pd.DataFrame(named_columns(data, data.rows))
    rows["regime"] = data.rows["regime"]
    rows[f"{observable.name} [{unit}]"] = pd.Series(
        replicate_values(data, observable), data.rows.index
    )
    return rows.explode(f"{observable.name} [{unit}]")


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on dots, bars and omitted values."""
    observable = numbers(data.spec.system)[data.spec.show]
    values_by_point = replicate_values(data, observable)
    completed = data.rows["completed"] > 0
    missing = sum(
        not values.size for values, done in zip(values_by_point, completed, strict=True) if done
    )
    all_values = np.concatenate([np.zeros(0), *values_by_point])
    omitted = int(np.isnan(above_zero(data, "y", all_values)).sum())
    return [
        "A dot per completed replicate, spread sideways; bars: medians. x is not to scale.",
        *not_drawn(missing, "without a value"),
        *not_drawn(omitted, "replicates not above 0 on a logarithmic axis"),
    ]
