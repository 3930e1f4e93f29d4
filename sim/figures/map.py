"""A map over two parameters: regimes and the boundaries between them, or an observable.

Of an observable there are cells of a grid, or contours between scattered points. Flows that are not
shown to be steady are hatched.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator
from matplotlib.tri import Triangulation

from sim.figures.caption import not_drawn
from sim.figures.data import (
    FigureData,
    is_undecided,
    quantity_table,
    varying_parameters,
    velocity_table,
)
from sim.figures.fit import fit_notes
from sim.figures.plot import (
    Panels,
    append_foreign_data,
    draw_foreign_data,
    given_labels,
    label_axes,
    mark_runs,
    observed_quantity,
    panels,
)
from sim.figures.regimes import boundary_sentences, draw_plane, fit_boundaries
from sim.figures.scatter import draw_points
from sim.figures.style import OPEN_MEANS, PALE_MEANS, set_log
from sim.figures.variables import SHADES, Variable, legend, observable, parameter, rows_with_values
from sim.parameters import SYSTEMS
from sim.study.plot_contents import in_words, parameter_phrase
from sim.study.plottable import REGIME

#: Least share of the places of a grid at which points are.
_FILLED = 0.5

#: Most cells of a panel whose values are written, contour lines, and areas (square points) of
#: markers alone and between contours.
MOST_WRITTEN, _LINES, _ALONE, _BETWEEN = 36, 7, 60.0, 16.0

#: Hatches of flows that are not steady, and of runs too short to tell, with their entries.
_HATCHES = {"////": OPEN_MEANS, "/": PALE_MEANS}


def draw(data: FigureData) -> Figure:
    """Draw a marker per point of its regime, or cells or contours of the observable."""
    spec = data.spec
    figure, shown = panels(data)
    if spec.show == REGIME:
        for axes, rows in shown:
            draw_plane(axes, data, rows)
    else:
        _draw_values(data, figure, shown)
    foreign = draw_foreign_data(data, shown)
    x, y = spec.axes
    for axes, _ in shown:
        for axis in {"x", "y"} & set(spec.log):
            set_log(axes, axis)
        axes.autoscale_view()
        mark_runs(axes, data.rows[x])
        mark_runs(axes, data.rows[y], "y")
    label_axes(figure, shown, *given_labels(data))
    named = [name for name in spec.by if name not in spec.axes]
    legend(data, figure, shown, named, foreign=foreign)
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    shows_regimes = data.spec.show == REGIME
    rows = (
        velocity_table(data) if shows_regimes else quantity_table(data, [observed_quantity(data)])
    )
    # Both parameters follow the id of the point.
    _, x, y, *_ = rows.columns
    return append_foreign_data(data, rows, x, y)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on what is drawn, and what is not."""
    if data.spec.show == REGIME:
        basis = "through the middles of the bars"
        fitted = fit_notes(data, fit_boundaries(data), basis)
        return [*boundary_sentences(data.boundaries, data.spec.axes), *fitted]
    return _value_notes(data)


def _draw_values(data: FigureData, figure: Figure, shown: Panels) -> None:
    shade = observable(data, "show", "colour")
    along = zip("xy", data.spec.axes, strict=True)
    x, y = (parameter(data, name, log=axis in data.spec.log) for axis, name in along)
    for axes, rows in shown:
        axes.grid(visible=False)
        points = rows.loc[rows_with_values(data, [shade]).index.intersection(rows.index)]
        if _is_grid(rows, data.spec.axes):
            _draw_cells(axes, data, rows, shade)
        elif (triangles := _triangles(data, points, shade)) is not None:
            _draw_contours(axes, data, points, shade, triangles)
        else:
            draw_points(axes, points, x, y, shade, _ALONE)
        missing = rows.drop(points.index)
        axes.plot(x.values[missing.index], y.values[missing.index], "x", color="#888888", zorder=4)
    shade.explain_colours(figure, shown)


def _triangles(data: FigureData, rows: pd.DataFrame, shade: Variable) -> np.ndarray | None:
    """Return the triangles (T, 3) between scattered points, ``None`` where there are no contours.

    That is where more parameters vary than those of axes and panels, all values are equal, or all
    points are on one line.
    """
    if len(rows) < 3 or shade.values.nunique() < 2 or _others(data):
        return None
    places = []
    for axis, name in zip("xy", data.spec.axes, strict=True):
        along = np.log(rows[name]) if axis in data.spec.log else rows[name].astype(float)
        places.append((along - along.min()) / (np.ptp(along) or 1.0))
    try:
        return np.asarray(Triangulation(*places).triangles)
    except RuntimeError:
        return None


def _is_grid(rows: pd.DataFrame, plane: tuple[str, ...]) -> bool:
    x, y = (rows[name].nunique() for name in plane)
    return min(x, y) > 1 and len(rows) >= _FILLED * x * y


def _others(data: FigureData) -> list[str]:
    shown = {*data.spec.axes, *data.spec.groups}
    names = [name for name in SYSTEMS[data.spec.system].model_fields if name not in shown]
    return varying_parameters(data.rows, names)


def _hatches(rows: pd.DataFrame) -> pd.Series:
    """Return the hatches of points: dense where not steady, wide where too short to tell."""
    dense, wide = _HATCHES
    hatches = pd.Series(dense, rows.index).where(rows["regime"] != "steady", "")
    return hatches.mask(is_undecided(rows), wide)


def _edges(values: np.ndarray, *, log: bool) -> np.ndarray:
    """Return the edges of cells around sorted values, halfway between them on the axis."""
    places = np.log(values) if log else values
    between = (places[1:] + places[:-1]) / 2
    edges = np.r_[2 * places[0] - between[0], between, 2 * places[-1] - between[-1]]
    return np.exp(edges) if log else edges


def _draw_cells(axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable) -> None:
    (x, y), log = data.spec.axes, data.spec.log
    both = rows.assign(value=shade.values, mark=_hatches(rows)).pivot(
        index=y, columns=x, values=["value", "mark"]
    )
    table, marks = both["value"], both["mark"].to_numpy()
    values, columns, lines = (one.to_numpy(float) for one in (table, table.columns, table.index))
    across, up = _edges(columns, log="x" in log), _edges(lines, log="y" in log)
    look: dict[str, Any] = {"cmap": SHADES, "norm": shade.norm, "edgecolors": "white"}
    axes.pcolormesh(across, up, values, linewidth=0.6, **look)
    size = min(8.0, (30.0 if data.spec.panels else 54.0) / len(columns))
    cells: list[tuple[str, str, np.ndarray]] = []
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            red, green, blue, _ = SHADES(shade.norm(value))
            is_dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.55
            ink = "white" if is_dark else "black"
            (left, right), (low, high) = across[column:][:2], up[row:][:2]
            corners = np.array([(left, low), (right, low), (right, high), (left, high)])
            cells.append((marks[row, column], ink, corners))
            if values.size <= MOST_WRITTEN:
                at, text = (columns[column], lines[row]), f"{value:.3g}"
                axes.text(*at, text, ha="center", va="center", fontsize=size, color=ink, zorder=4)
    _draw_hatches(axes, cells)


def _draw_hatches(axes: Axes, areas: Sequence[tuple[str, str, np.ndarray]]) -> None:
    """Hatch areas, each given by hatch (empty for none), colour and corners (C, 2)."""
    for hatch, ink in sorted({(hatch, ink) for hatch, ink, _ in areas if hatch}):
        corners = [one for *look, one in areas if look == [hatch, ink]]
        look: dict[str, Any] = {"hatch": hatch, "edgecolors": ink, "linewidths": 0, "zorder": 1.5}
        label = _HATCHES[hatch]
        axes.add_collection(
            PolyCollection(corners, facecolors="none", alpha=0.55, label=label, **look),
            autolim=False,
        )


def _draw_contours(
    axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable, triangles: np.ndarray
) -> None:
    norm = shade.norm
    low, high = float(norm.vmin or 0), float(norm.vmax or 0)
    is_wide = type(norm) is not Normalize and high > 100 * low
    ticks = LogLocator(subs=(1, 3)) if is_wide else MaxNLocator(_LINES, steps=[1, 2, 5, 10])
    x, y = (rows[name].to_numpy(float) for name in data.spec.axes)
    value, marks = shade.values[rows.index].to_numpy(float), _hatches(rows).to_numpy()
    plane, look = Triangulation(x, y, triangles), {"cmap": SHADES, "norm": norm, "extend": "both"}
    # So many bounds that the colours look continuous.
    axes.tricontourf(plane, value, np.asarray(norm.inverse(np.linspace(0, 1, 65))), **look)
    line: dict[str, Any] = {"colors": "black", "linewidths": 0.6}
    lines = axes.tricontour(plane, value, ticks.tick_values(low, high), **line)
    axes.clabel(lines, fontsize=7.5, fmt="%.3g")
    # The pattern of the least steady corner, which has the longest name.
    areas = [
        (max(marks[corners], key=len), "black", np.column_stack([x[corners], y[corners]]))
        for corners in triangles
    ]
    _draw_hatches(axes, areas)
    colours = shade.colours(shade.values[rows.index])
    axes.scatter(x, y, s=_BETWEEN, c=colours, edgecolors="black", linewidths=0.6, zorder=3)
    axes.use_sticky_edges = False
    axes.margins(0.04)


def _value_notes(data: FigureData) -> list[str]:
    shade = observable(data, "show", "colour")
    complete, panel = rows_with_values(data, [shade]), data.spec.panels
    parts = [part for _, part in data.rows.groupby(panel)] if panel else [data.rows]
    if all(_is_grid(part, data.spec.axes) for part in parts):
        what = "A cell per point, up to halfway to its neighbours."
    elif _triangles(data, complete, shade) is not None:
        what = "Contours: linear between neighbouring points (triangulation), which are the dots."
    else:
        others = in_words(parameter_phrase(data.spec.system, name) for name in _others(data))
        why = f", without contours: they also differ in {others}" if others else ""
        what = f"A marker per point{why}."
    return [what, *not_drawn(len(data.rows) - len(complete), "without a value (crosses)")]
