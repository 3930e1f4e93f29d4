"""A map over two parameters: regimes and the boundaries between them, or an observable.

Maps of regimes show the boundaries that feed them; those of papers also a line of theory, and flows
that creep.
"""

from collections import Counter
from collections.abc import Sequence
from math import atan, degrees, radians, tan
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
from matplotlib.tri import Triangulation
from scipy.spatial import Delaunay, QhullError

from sim.figures.axes import set_log
from sim.figures.caption import not_drawn
from sim.figures.data import (
    FigureData,
    quantity_table,
    split_curves,
    varying_parameters,
    velocity_table,
)
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
from sim.figures.scatter import draw_points
from sim.figures.style import (
    OPEN_MEANS,
    PALE_MEANS,
    THEORY,
    CurveStyle,
    cycle_style,
    escape_label,
    is_undecided,
    move_aside,
)
from sim.figures.variables import SHADES, Variable, legend, observable, parameter, rows_with_values
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
from sim.study.plot_contents import in_words, parameter_phrase
from sim.study.plottable import CREEP, REGIME

#: Size of the markers of regimes, points of print, and least distance of two in a column, as a
#: share of the range.
_MARKER, _APART = 5.0, 0.03

CREEPING = f"creeps: |V| < {CREEP:g} √(gσ)"

#: Marker, colour and whether it is filled, of regimes and creeping flows as in the legend. The
#: later lie over the earlier where several runs are in one place.
MARKS = {
    "undetermined": ("D", "#666666", False),
    "mixed": ("p", "#666666", False),
    "steady": ("o", "#0072b2", True),
    "accelerating": ("^", "#d55e00", True),
    "arrested": ("s", "#000000", True),
    CREEPING: ("v", "#000000", False),
    "failed": ("x", "#666666", True),
}


def draw(data: FigureData) -> Figure:
    """Draw a marker per point of its regime, or cells or contours of the observable."""
    spec = data.spec
    figure, shown = panels(data)
    if spec.show == REGIME:
        for axes, rows in shown:
            _draw_plane(axes, data, rows)
    else:
        _draw_values(data, figure, shown)
    foreign = draw_foreign_data(data, shown)
    _set_axes(data, shown)
    label_axes(figure, shown, *given_labels(data))
    named = [name for name in spec.by if name not in spec.axes]
    legend(data, figure, shown, named, foreign=foreign)
    return figure


def _draw_plane(axes: Axes, data: FigureData, rows: pd.DataFrame) -> None:
    spec, aside = data.spec, 0.0
    if spec.point != "none":
        rows = rows.assign(lane=_lanes(rows, spec.axes))
        is_slow = creeping(rows) if spec.creep else pd.Series(False, rows.index)
        _draw_regimes(axes, rows, rows["regime"].mask(is_slow, CREEPING), spec.axes)
        # Beside all markers.
        aside = _MARKER * (rows["lane"].max() / 2 + 2)
    _draw_boundaries(axes, data.boundaries, spec.axes, aside=aside)
    if spec.theory:
        _THEORIES[spec.theory](axes, rows)


def _draw_regimes(axes: Axes, rows: pd.DataFrame, regimes: pd.Series, plane: Sequence[str]) -> None:
    x, y = plane
    for regime, (marker, colour, filled) in MARKS.items():
        face = colour if filled else "white"
        look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "markersize": _MARKER}
        label = regime
        for lane, part in rows[regimes == regime].groupby("lane"):
            drawn = axes.plot(part[x], part[y], marker, label=label, zorder=3, **look)
            move_aside(axes, drawn, x=(-1) ** lane * ((lane + 1) // 2) * (_MARKER + 1.5))
            label = ""


def _lanes(rows: pd.DataFrame, plane: Sequence[str]) -> pd.Series:
    """Return by how many markers each point stands aside, so that it covers none below it."""
    x, y = plane
    apart, lanes = _APART * np.ptp(rows[y]), pd.Series(0, rows.index)
    for _, column in rows.groupby(x):
        highest: list[float] = []
        for index, value in column[y].sort_values().items():
            free = (lane for lane, last in enumerate(highest) if value - last >= apart)
            lanes[index] = lane = next(free, len(highest))
            highest[lane : lane + 1] = [value]
    return lanes


def creeping(rows: pd.DataFrame) -> pd.Series:
    """Return which points of the chute move, but slower than `CREEP`, whatever their trend is."""
    slow = rows["velocity"].abs() < CREEP * np.sqrt(rows["gravity"] * rows["diameter"])
    return slow & ~rows["regime"].isin(("arrested", "failed"))


def _draw_least_friction(axes: Axes, rows: pd.DataFrame) -> None:
    for angle in sorted(set(rows["angle"])):
        label = f"μ = tan θ, slope θ = {angle:g}°"
        axes.axhline(tan(radians(angle)), label=label, **THEORY)


def _draw_largest_angle(axes: Axes, rows: pd.DataFrame) -> None:
    for friction in sorted(set(rows["friction"])):
        label = f"tan θ = μ, friction μ = {friction:g}"
        axes.axhline(degrees(atan(friction)), label=label, **THEORY)


def _draw_lift_off(axes: Axes, rows: pd.DataFrame) -> None:
    smallest, largest = rows["amplitude"][rows["amplitude"] > 0].agg(["min", "max"])
    amplitude = np.linspace(0.9 * smallest, 1.05 * largest, 200)
    for (gravity, diameter), _ in rows.groupby(["gravity", "diameter"]):
        frequency = np.sqrt(gravity / (amplitude * diameter)) / (2 * np.pi)
        axes.plot(amplitude, frequency, label="$Γ = 4π^2 f^2 A_z/g$ = 1", **THEORY)


#: Draws, by name, where friction just holds the weight, or where the belt's acceleration reaches
#: that of gravity.
_THEORIES = {
    "least_friction": _draw_least_friction,
    "largest_angle": _draw_largest_angle,
    "lift_off": _draw_lift_off,
}


def _set_axes(data: FigureData, shown: Panels) -> None:
    x, y = data.spec.axes
    log = data.spec.log
    for axes, _ in shown:
        for axis in {"x", "y"} & set(log):
            set_log(axes, axis)
        if data.spec.show == REGIME:
            axes.margins(0.13)
        axes.autoscale_view()
        mark_runs(axes, data.rows[x])
        mark_runs(axes, data.rows[y], "y")


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
    """Return the sentences of the caption on markers."""
    if data.spec.show == REGIME:
        bars, *others = boundary_sentences(data.boundaries, data.spec.axes)
        return [bars or "One marker per point.", *others]
    return _value_notes(data)


#: Name in legends and style of the bars of each kind of boundary. Further boundaries of a kind get
#: other styles.
BOUNDARIES = {
    "flow": ("limit of arrest", CurveStyle("#009e73", "-", "")),
    "acceleration": ("limit of acceleration", CurveStyle("#cc79a7", "-", "")),
    "transport": ("onset of transport", CurveStyle("#000000", "-", "o")),
}

#: Shift between bars at the same position, points of print.
BAR_PITCH = 5.0


def _draw_boundaries(
    axes: Axes, boundaries: pd.DataFrame, plane: Sequence[str], aside: float = 0
) -> None:
    """Draw the intervals that hold a boundary as bars along its parameter, side by side.

    They stand ``aside`` of their position, in points of print; a marker shows the kind.
    """
    counts: Counter[tuple[str, str, float]] = Counter()
    for label, look, bars in _kinds(boundaries, plane):
        style: dict[str, Any] = {"color": look.colour, "marker": look.marker}
        style |= {"markerfacecolor": "white", "zorder": 4}
        for bar in bars.to_dict("records"):
            upright = bar["along"] == plane[1]
            place = bar[plane[0] if upright else plane[1]]
            middle, half = (bar["low"] + bar["high"]) / 2, (bar["high"] - bar["low"]) / 2
            at = (place, middle, half) if upright else (middle, place, None, half)
            drawn = axes.errorbar(*at, **style, elinewidth=2.2, capsize=3.5, capthick=1.4)
            key = (bar["of"], bar["along"], place)
            # Flat bars need no more room than a marker.
            shift = (aside if upright else min(aside, 1.5 * BAR_PITCH)) + BAR_PITCH * counts[key]
            move_aside(axes, drawn.get_children(), **{"x" if upright else "y": shift})
            counts[key] += 1
        axes.plot([], [], **style, linewidth=2.2, label=escape_label(label))


def _kinds(
    boundaries: pd.DataFrame, plane: Sequence[str]
) -> list[tuple[str, CurveStyle, pd.DataFrame]]:
    """Return legend entry, style and rows of each kind of boundary in a plane."""
    intervals = boundaries[boundaries["along"].isin(plane) & boundaries["low"].notna()]
    if intervals.empty:
        return []
    fields = [name for name in _parameter_names(intervals) if name not in plane]
    kinds: list[tuple[str, CurveStyle, pd.DataFrame]] = []
    for names, bars in split_curves(intervals, "along", ("of",), fields):
        text, look = BOUNDARIES[names.pop("of")]
        if any(look == other for _, other, _ in kinds):
            look = cycle_style(len(kinds))
        label = text + _settings_suffix(bars["system"].iloc[0], names)
        kinds.append((label, look, bars))
    return kinds


def _parameter_names(boundaries: pd.DataFrame) -> list[str]:
    names = (name for system in set(boundaries["system"]) for name in SYSTEMS[system].model_fields)
    return sorted({name for name in names if name in boundaries})


def _settings_suffix(system: str, names: dict[str, Any]) -> str:
    return "".join(f", {setting(system, name, value)}" for name, value in names.items())


def boundary_sentences(boundaries: pd.DataFrame, plane: Sequence[str]) -> list[str]:
    """Return what the bars are, and which boundaries have no interval or exceed the tolerance."""
    in_plane = boundaries[boundaries["along"].isin(plane)]
    if in_plane.empty:
        return [""]
    notes = {
        "wide": "wider than asked for, as undecided or contradictory points lie in between",
        "none": "not within the range searched",
        "several": "not a single one, the same side lying at both ends of the range",
        "open": "unknown, no decided points lying on two sides",
    }
    parts = []
    for verdict, text in notes.items():
        rows = in_plane[in_plane["verdict"] == verdict]
        missing = "; ".join(_missing_names(rows, in_plane))
        if len(rows):
            parts.append(f"{len(rows)} {text}" + (f" ({missing})" if missing else ""))
    found = int(in_plane["low"].notna().sum())
    return [
        f"Bars: intervals that hold a boundary, {found} of {len(in_plane)} looked for.",
        f"Boundaries: {'; '.join(parts)}." if parts else "",
    ]


def _missing_names(rows: pd.DataFrame, boundaries: pd.DataFrame) -> list[str]:
    varied = varying_parameters(boundaries, _parameter_names(boundaries))
    names: dict[str, None] = {}
    for row in rows[rows["low"].isna()].to_dict("records"):
        others = {key: row[key] for key in varied if key != row["along"]}
        names[BOUNDARIES[row["of"]][0] + _settings_suffix(row["system"], others)] = None
    return list(names)


# A map of an observable: cells of a grid, or contours between scattered points.
#
# Flows that are not shown to be steady are hatched.


#: Least share of the places of a grid at which points are.
_FILLED = 0.5

#: Most cells of a panel whose values are written, and contour lines.
MOST_WRITTEN, _LINES = 36, 7

#: Look of contour lines, and areas (square points) of markers alone and between contours.
_LINE: dict[str, Any] = {"colors": "black", "linewidths": 0.6}
_ALONE, _BETWEEN = 60.0, 16.0

#: Hatches of flows that are not steady, and of runs too short to tell, with their entries.
_DENSE, _WIDE = "////", "/"
_HATCHES = {_DENSE: OPEN_MEANS, _WIDE: PALE_MEANS}

#: Digits of the largest value in a cell, and most decimals of all; characters for which there is
#: room along a single panel, and along one of several.
_DIGITS, _DECIMALS, _ROOM = 3, 5, (54, 30)


def _draw_values(data: FigureData, figure: Figure, shown: Panels) -> None:
    shade = observable(data, "show", "colour")
    x, y = data.spec.axes
    for axes, rows in shown:
        axes.grid(visible=False)
        points = rows.loc[rows_with_values(data, [shade]).index.intersection(rows.index)]
        if _is_grid(rows, data.spec.axes):
            _draw_cells(axes, data, rows, shade)
        elif (triangles := _triangles(data, points, shade)) is not None:
            _draw_contours(axes, data, points, shade, triangles)
        else:
            log = data.spec.log
            across = parameter(data, x, log="x" in log)
            draw_points(axes, points, across, parameter(data, y, log="y" in log), shade, _ALONE)
        missing = rows.drop(points.index)
        axes.plot(missing[x], missing[y], "x", color="#888888", zorder=4)
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
        values = rows[name].to_numpy(float)
        along = np.log(values) if axis in data.spec.log else values
        places.append((along - along.min()) / (np.ptp(along) or 1.0))
    try:
        return np.asarray(Delaunay(np.column_stack(places)).simplices)
    except QhullError:
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
    dense = pd.Series(_DENSE, rows.index).where(rows["regime"] != "steady", "")
    return dense.mask(is_undecided(rows), _WIDE)


def _ink(value: float, norm: Normalize) -> tuple[float, float, float]:
    red, green, blue, _ = SHADES(norm(value))
    return (1, 1, 1) if 0.3 * red + 0.59 * green + 0.11 * blue < 0.55 else (0, 0, 0)


def _edges(values: np.ndarray, *, log: bool) -> np.ndarray:
    """Return the edges of cells around sorted values, halfway between them on the axis."""
    places = np.log(values) if log else values
    between = (places[1:] + places[:-1]) / 2
    edges = np.r_[2 * places[0] - between[0], between, 2 * places[-1] - between[-1]]
    return np.exp(edges) if log else edges


def _draw_cells(axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable) -> None:
    norm = shade.norm
    (x, y), log = data.spec.axes, data.spec.log
    both = rows.assign(value=shade.values, mark=_hatches(rows)).pivot(
        index=y, columns=x, values=["value", "mark"]
    )
    table, marks = both["value"], both["mark"].to_numpy()
    values, columns, lines = (one.to_numpy(float) for one in (table, table.columns, table.index))
    edges = _edges(columns, log="x" in log), _edges(lines, log="y" in log)
    axes.pcolormesh(*edges, values, cmap=SHADES, norm=norm, edgecolors="white", linewidth=0.6)
    for (down, across), value in np.ndenumerate(values):
        if np.isfinite(value) and marks[down, across]:
            (left, right), (low, high) = edges[0][across:][:2], edges[1][down:][:2]
            cell = Rectangle((left, low), right - left, high - low)
            _hatch(axes, cell, marks[down, across], _ink(value, norm))
    if values.size <= MOST_WRITTEN:
        _write_values(axes, table, norm, _ROOM[bool(data.spec.panels)])
    elif norm.vmin != norm.vmax:
        finite = np.ma.masked_invalid(values)
        _label_lines(axes, axes.contour(columns, lines, finite, _levels(norm), **_LINE))


def _write_values(axes: Axes, table: pd.DataFrame, norm: Normalize, room: int) -> None:
    """Write each value into its cell, turned where ``room`` characters do not hold a row."""
    values = table.to_numpy(float)
    size = np.nanmax(np.abs(values)) if np.isfinite(values).any() else 0
    decimals = max(0, _DIGITS - 1 - int(np.floor(np.log10(size)))) if size else 0
    is_plain = type(norm) is Normalize and decimals <= _DECIMALS and size < 10**_DECIMALS
    pattern = f"{{:.{decimals}f}}" if is_plain else f"{{:.{_DIGITS}g}}"
    look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8, "zorder": 4}
    for (down, across), value in np.ndenumerate(values):
        if np.isfinite(value):
            text = pattern.format(round(value, decimals) + 0.0 if is_plain else value)
            box = {"facecolor": SHADES(norm(value)), "edgecolor": "none", "pad": 1.0}
            place = float(table.columns[across]), float(table.index[down])
            look |= {"color": _ink(value, norm), "bbox": box}
            look["rotation"] = 90 if len(text) * len(table.columns) > room else 0
            axes.text(*place, text.replace("-", "\N{MINUS SIGN}"), **look)


def _label_lines(axes: Axes, lines: ContourSet) -> None:
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
    low, high = float(norm.vmin or 0), float(norm.vmax or 0)
    if type(norm) is not Normalize and high > 100 * low:
        return np.asarray(LogLocator(subs=(1, 3)).tick_values(low, high))
    return np.asarray(MaxNLocator(_LINES, steps=[1, 2, 5, 10]).tick_values(low, high))


def _draw_contours(
    axes: Axes, data: FigureData, rows: pd.DataFrame, shade: Variable, triangles: np.ndarray
) -> None:
    norm = shade.norm
    names = data.spec.axes
    x, y = (rows[name].to_numpy(float) for name in names)
    value, marks = shade.values[rows.index].to_numpy(float), _hatches(rows).to_numpy()
    plane, look = Triangulation(x, y, triangles), {"cmap": SHADES, "norm": norm, "extend": "both"}
    # So many bounds that the colours look continuous.
    axes.tricontourf(plane, value, np.asarray(norm.inverse(np.linspace(0, 1, 65))), **look)
    _label_lines(axes, axes.tricontour(plane, value, _levels(norm), **_LINE))
    for corners in triangles:
        # The pattern of the least steady corner, which has the longest name.
        if hatch := max(marks[corners], key=len):
            _hatch(axes, Polygon(np.column_stack([x[corners], y[corners]])), hatch, (0, 0, 0))
    colours = shade.colours(shade.values[rows.index])
    axes.scatter(x, y, s=_BETWEEN, c=colours, edgecolors="black", linewidths=0.6, zorder=3)
    axes.use_sticky_edges = False
    axes.margins(0.04)


def _value_notes(data: FigureData) -> list[str]:
    shade = observable(data, "show", "colour")
    complete, panel = rows_with_values(data, [shade]), data.spec.panels
    parts = [part for _, part in data.rows.groupby(panel)] if panel else [data.rows]
    others = [parameter_phrase(data.spec.system, name) for name in _others(data)]
    hatched = "Hatched: not shown to be steady (wide: of runs too short to tell)."
    if all(_is_grid(part, data.spec.axes) for part in parts):
        what = "A cell per point, up to halfway to its neighbours."
    elif _triangles(data, complete, shade) is not None:
        what = "Contours: linear between neighbouring points (triangulation), which are the dots."
    else:
        why = f", without contours: they also differ in {in_words(others)}" if others else ""
        what, hatched = f"A marker per point{why}.", ""
    return [
        what,
        hatched if _hatches(complete).any() else "",
        *not_drawn(len(data.rows) - len(complete), "without a value (crosses)"),
    ]
