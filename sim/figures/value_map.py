"""A map of an observable: cells of a grid, or contours between scattered points.

Flows that are not shown to be steady are hatched.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator
from matplotlib.tri import LinearTriInterpolator, Triangulation, UniformTriRefiner
from scipy.spatial import Delaunay, QhullError

from sim.figures.caption import regime_sentence, unsteady_sentence
from sim.figures.data import FigureData, varying_parameters
from sim.figures.plot import PANEL_SIZE, SINGLE_SIZE, Panels, missing_value_note
from sim.figures.scatter import draw_points
from sim.figures.style import OPEN_MEANS, PALE_MEANS, is_undecided
from sim.figures.variables import SHADES, Colours, Variable, known_rows, observable, parameter
from sim.parameters import SYSTEMS
from sim.study.plot_contents import in_words, parameter_phrase

#: Least share of the places of a grid at which points are.
_FILLED = 0.5

#: Most cells of a panel whose values are written, and contour lines.
MOST_WRITTEN, _LINES = 36, 7

#: Look of contour lines, and areas (square points) of markers alone and between contours.
_LINE: dict[str, Any] = {"colors": "black", "linewidths": 0.6}
_ALONE, _BETWEEN = 60.0, 16.0

#: How often triangles are halved where an axis is logarithmic.
_DIVISIONS = 3

#: Hatches of flows that are not steady, and of runs too short to tell, with their entries.
_DENSE, _WIDE = "////", "/"
_HATCHES = {_DENSE: OPEN_MEANS, _WIDE: PALE_MEANS}

#: Digits of the largest value in a cell, most decimals of all, and width of a character, inches.
_DIGITS, _DECIMALS, _CHARACTER = 3, 5, 0.075


def draw_values(data: FigureData, figure: Figure, shown: Panels) -> None:
    """Draw cells, contours or markers in all panels, and a colour bar."""
    shade, _ = observable(data, "show", "colour")
    x, y = data.spec.axes
    for axes, rows in shown:
        axes.grid(visible=False)
        points = rows.loc[known_rows(data, [shade]).index.intersection(rows.index)]
        if is_grid(rows, data.spec.axes):
            _draw_cells(axes, data, rows, shade)
        elif (triangles := _triangles(data, points, shade)) is not None:
            _draw_contours(axes, data, points, shade, triangles)
        else:
            log = data.spec.options["log"]
            across = parameter(data, x, log="x" in log)
            draw_points(axes, points, across, parameter(data, y, log="y" in log), shade, _ALONE)
        missing = rows.drop(points.index)
        axes.plot(missing[x], missing[y], "x", color="#888888", zorder=4)
    Colours(shade).explain(figure, [axes for axes, _ in shown])


def _triangles(data: FigureData, rows: pd.DataFrame, shade: Variable) -> np.ndarray | None:
    """Return the triangles (T, 3) between scattered points, ``None`` where there are no contours.

    That is where more parameters vary than those of axes and panels, all values are equal, or all
    points are on one line.
    """
    if len(rows) < 3 or shade.values.nunique() < 2 or _others(data):
        return None
    places = []
    for axis, name in zip("xy", data.spec.axes, strict=True):
        values = rows[name].to_numpy(float)
        along = np.log(values) if axis in data.spec.options["log"] else values
        places.append((along - along.min()) / (np.ptp(along) or 1.0))
    try:
        return np.asarray(Delaunay(np.column_stack(places)).simplices)
    except QhullError:
        return None


def is_grid(rows: pd.DataFrame, plane: tuple[str, ...]) -> bool:
    """Return whether points fill most places of a grid."""
    x, y = (rows[name].nunique() for name in plane)
    return min(x, y) > 1 and len(rows) >= _FILLED * x * y


def _others(data: FigureData) -> list[str]:
    """Return the parameters that vary besides those of axes and panels."""
    shown = {*data.spec.axes, *data.spec.curves}
    names = [name for name in SYSTEMS[data.spec.system].model_fields if name not in shown]
    return varying_parameters(data.rows, names)


def _hatches(rows: pd.DataFrame) -> pd.Series:
    """Return the hatches of points: dense where not steady, wide where too short to tell."""
    dense = pd.Series(_DENSE, rows.index).where(rows["regime"] != "steady", "")
    return dense.mask(is_undecided(rows), _WIDE)


def _ink(value: float, norm: Normalize) -> tuple[float, float, float]:
    """Return the colour, black or white, that stands out from that of a value."""
    red, green, blue, _ = SHADES(norm(value))
    return (1, 1, 1) if 0.3 * red + 0.59 * green + 0.11 * blue < 0.55 else (0, 0, 0)


def _edges(values: np.ndarray, *, log: bool) -> np.ndarray:
    """Return the edges of cells around sorted values, halfway between them on the axis."""
    places = np.log(values) if log else values
    between = (places[1:] + places[:-1]) / 2
    edges = np.r_[2 * places[0] - between[0], between, 2 * places[-1] - between[-1]]
    return np.exp(edges) if log else edges


def _draw_cells(axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable) -> None:
    """Draw a cell per point, with its value where there are few, else with contour lines."""
    norm = Colours(shade).norm
    (x, y), log = data.spec.axes, data.spec.options["log"]
    table = rows.assign(value=shade.values, mark=_hatches(rows)).pivot(
        index=y, columns=x, values=["value", "mark"]
    )
    values = table["value"].to_numpy(float)
    columns, lines = (np.array(sorted(set(rows[name])), float) for name in (x, y))
    edges = _edges(columns, log="x" in log), _edges(lines, log="y" in log)
    axes.pcolormesh(*edges, values, cmap=SHADES, norm=norm, edgecolors="white", linewidth=0.6)
    marks = table["mark"].to_numpy()
    for (down, across), value in np.ndenumerate(values):
        if np.isfinite(value) and marks[down, across]:
            (left, right), (low, high) = edges[0][across:][:2], edges[1][down:][:2]
            cell = Rectangle((left, low), right - left, high - low)
            _hatch(axes, cell, marks[down, across], _ink(value, norm))
    if values.size <= MOST_WRITTEN:
        _write_values(axes, columns, lines, values, norm)
        axes.set_xlim(edges[0][0], edges[0][-1])
        _turn_wide_texts(axes, data, edges[0])
    elif norm.vmin != norm.vmax:
        known = np.ma.masked_invalid(values)
        _label_lines(axes, axes.contour(columns, lines, known, _levels(norm), **_LINE))


def _write_values(
    axes: Axes, columns: np.ndarray, lines: np.ndarray, values: np.ndarray, norm: Normalize
) -> None:
    """Write each value into its cell, in the colour that stands out, all with as many decimals."""
    size = np.nanmax(np.abs(values)) if np.isfinite(values).any() else 0
    decimals = max(0, _DIGITS - 1 - int(np.floor(np.log10(size)))) if size else 0
    is_plain = type(norm) is Normalize and decimals <= _DECIMALS and size < 10**_DECIMALS
    for (down, across), value in np.ndenumerate(values):
        if np.isfinite(value):
            text = (
                f"{round(value, decimals) + 0.0:.{decimals}f}"
                if is_plain
                else f"{value:.{_DIGITS}g}"
            )
            box = {"facecolor": SHADES(norm(value)), "edgecolor": "none", "pad": 1.0}
            axes.text(
                float(columns[across]),
                float(lines[down]),
                text.replace("-", "\N{MINUS SIGN}"),
                color=_ink(value, norm),
                ha="center",
                va="center",
                fontsize=8,
                bbox=box,
                zorder=4,
            )


def _turn_wide_texts(axes: Axes, data: FigureData, edges: np.ndarray) -> None:
    """Turn the values of cells for which they are too wide; ``edges`` are those of the columns."""
    places = np.log(edges) if "x" in data.spec.options["log"] else edges
    length = SINGLE_SIZE[0] - 1.5 if not data.spec.options["panels"] else PANEL_SIZE[0] - 0.5
    widths = length * np.diff(places) / np.ptp(places)
    for text in axes.texts:
        column = int(np.searchsorted(edges, text.get_position()[0])) - 1
        if len(text.get_text()) * _CHARACTER > widths[column]:
            text.set_rotation(90)


def _label_lines(axes: Axes, lines: ContourSet) -> None:
    """Write the values of contour lines on them."""
    for text in axes.clabel(lines, fontsize=7.5, fmt=lambda level: f"{level:.3g}") or ():
        text.set_path_effects([withStroke(linewidth=1.6, foreground="white", alpha=0.75)])


def _hatch(axes: Axes, patch: Patch, hatch: str, colour: tuple[float, float, float]) -> None:
    """Add a patch that is a hatch alone, and an entry of the legend for the hatch."""
    patch.set(fill=False, linewidth=0, hatch=hatch, edgecolor=(*colour, 0.55), zorder=1.5)
    patch.set_hatch_linewidth(0.6)
    axes.add_patch(patch)
    look: dict[str, Any] = {"fill": False, "hatch": 2 * hatch, "edgecolor": "#666666"}
    # Outside the axes, whose limits it does not change.
    entry = Rectangle((-1, -1), 0, 0, transform=axes.transAxes, label=_HATCHES[hatch], **look)
    if entry.get_label() not in axes.get_legend_handles_labels()[1]:
        axes.add_artist(entry)


def _levels(norm: Normalize) -> np.ndarray:
    """Return round values of contour lines that divide the range of the colours."""
    low, high = float(norm.vmin or 0), float(norm.vmax or 0)
    if type(norm) is not Normalize and high > 100 * low:
        return np.asarray(LogLocator(subs=(1, 3)).tick_values(low, high))
    return np.asarray(MaxNLocator(_LINES, steps=[1, 2, 5, 10]).tick_values(low, high))


def _draw_contours(
    axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable, triangles: np.ndarray
) -> None:
    """Draw filled contours over a triangulation of the points, their lines, and the points."""
    norm = Colours(shade).norm
    names = data.spec.axes
    x, y = (rows[name].to_numpy(float) for name in names)
    value, marks = shade.values[rows.index].to_numpy(float), _hatches(rows).to_numpy()
    plane, between = _refined(data, Triangulation(x, y, triangles), value)
    axes.tricontourf(plane, between, _shades(norm), cmap=SHADES, norm=norm, extend="both")
    _label_lines(axes, axes.tricontour(plane, between, _levels(norm), **_LINE))
    for corners in triangles:
        # The pattern of the least steady corner, which has the longest name.
        if hatch := max(marks[corners], key=len):
            _hatch(axes, Polygon(np.column_stack([x[corners], y[corners]])), hatch, (0, 0, 0))
    colours = Colours(shade).of(shade.values[rows.index])
    axes.scatter(x, y, s=_BETWEEN, c=colours, edgecolors="black", linewidths=0.6, zorder=3)
    axes.use_sticky_edges = False
    axes.margins(0.04)


def _refined(
    data: FigureData, plane: Triangulation, values: np.ndarray
) -> tuple[Triangulation, np.ndarray]:
    """Divide triangles, so that values are linear along logarithmic axes as they are drawn."""
    log = data.spec.options["log"]
    if not {"x", "y"} & set(log):
        return plane, values
    x, y = (np.log(one) if axis in log else one for axis, one in (("x", plane.x), ("y", plane.y)))
    drawn = Triangulation(x, y, plane.triangles)
    linear = LinearTriInterpolator(drawn, values)
    fine, between = UniformTriRefiner(drawn).refine_field(values, linear, subdiv=_DIVISIONS)
    x, y = (np.exp(one) if axis in log else one for axis, one in (("x", fine.x), ("y", fine.y)))
    return Triangulation(x, y, fine.triangles), np.asarray(between)


def _shades(norm: Normalize) -> np.ndarray:
    """Return the bounds of the filled contours, so many that they look continuous."""
    return np.asarray(norm.inverse(np.linspace(0, 1, 65)))


def value_notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on cells, contours, hatching and gaps."""
    shade, _ = observable(data, "show", "colour")
    known, panel = known_rows(data, [shade]), data.spec.options["panels"]
    parts = [part for _, part in data.rows.groupby(panel)] if panel else [data.rows]
    others = [parameter_phrase(data.spec.system, name) for name in _others(data)]
    marks = unsteady_sentence(known, "hatched (wide: of runs too short to tell)")
    if all(is_grid(part, data.spec.axes) for part in parts):
        what = "A cell per point, up to halfway to its neighbours."
    elif _triangles(data, known, shade) is not None:
        what = "Contours: linear between neighbouring points (triangulation), which are the dots."
    else:
        why = f", without contours: they also differ in {in_words(others)}" if others else ""
        what, marks = f"A marker per point{why}.", regime_sentence(known, has_bars=False)
    value = "a value above 0" if shade.log else "a value"
    return [
        what,
        marks,
        *missing_value_note(len(data.rows) - len(known), value, "Crosses"),
    ]
