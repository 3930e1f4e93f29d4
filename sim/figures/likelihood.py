"""How likely a curve of single runs rises, defined by a study file.

A study has several replicates of each point. The curve of a paper that has one may be any choice of
one replicate per point.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.statistics import MANY, share_of_rises, student
from sim.figures.data import FigureData, split_curves
from sim.figures.plot import (
    curve_keys,
    label_axes,
    panels,
    parameter_label,
    replicate_values,
    wrap_label,
    write_no_data,
)
from sim.figures.style import PALE
from sim.figures.variables import legend, shared_look
from sim.parameters import SYSTEMS
from sim.study.plottable import numbers

#: Columns of the data: probability and its interval.
_COLUMNS = "probability [1]", "interval, low [1]", "interval, high [1]"


def draw(data: FigureData) -> Figure:
    """Draw the probability to rise from each x on, with 95 % bands."""
    spec = data.spec
    figure, shown = panels(data)
    look = shared_look(data, curve_keys(data))
    for axes, rows in shown:
        for index, (names, points, values) in enumerate(_curves(data, rows)):
            style, label = look(names, index)
            x = points[spec.axes[0]].to_numpy(float)
            axes.plot(x, values[:, 0], style.marker, color=style.colour, label=label, linestyle="-")
            axes.fill_between(x, values[:, 1], values[:, 2], color=style.colour, alpha=PALE)
        axes.set_ylim(-0.03, 1.03)
    name = numbers(spec.system)[spec.show].name
    along = parameter_label(spec.system, spec.axes[0])
    label_axes(figure, shown, along, wrap_label("probability to rise from here on"))
    write_no_data(shown, name)
    legend(data, figure, shown, curve_keys(data))
    return figure


def _curves(
    data: FigureData, rows: pd.DataFrame
) -> Iterator[tuple[dict[str, Any], pd.DataFrame, np.ndarray]]:
    """Yield the names of each curve, its points, and probability and interval (X, 3) at each.

    At each x it is that one replicate of this and of each further point, drawn at random, rises
    from point to point. The last point has none.
    """
    spec = data.spec
    observable = numbers(spec.system)[spec.show]
    fields = tuple(SYSTEMS[spec.system].model_fields)
    for names, points in split_curves(rows, spec.axes[0], curve_keys(data), fields):
        own = FigureData(spec, points, data.boundaries, data.results)
        groups = [values[np.isfinite(values)] for values in replicate_values(own, observable)]
        has_values = [bool(group.size) for group in groups]
        known = [group for group in groups if group.size]
        kept = points[has_values][:-1]
        values = np.array([_interval(known[first:]) for first in range(len(kept))])
        yield names, kept, values.reshape(-1, 3)


def _interval(groups: list[np.ndarray]) -> tuple[float, float, float]:
    share, error = share_of_rises(groups)
    half_width = float(student(MANY)) * error
    return share, max(0.0, share - half_width), min(1.0, share + half_width)


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point of a curve but its last."""
    along, parts = data.spec.axes[0], []
    for names, points, values in _curves(data, data.rows):
        named = points[[along]].assign(**names, protocol=points["protocol"])
        parts.append(named.assign(**dict(zip(_COLUMNS, values.T, strict=True))))
    return pd.concat(parts) if parts else pd.DataFrame(columns=[along, *_COLUMNS])


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on what the probability is."""
    return [
        "The probability is that a curve of single runs, one replicate per point drawn at random, "
        "rises from each point to the next from this x on. Bands: 95 % (jackknife)."
    ]
