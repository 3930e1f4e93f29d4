"""Profiles of each point: a line over the height, or a marker per slice for one against another."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.axes import NONE, limit_axis, set_log
from sim.figures.caption import not_drawn
from sim.figures.data import FigureData, label_with_unit, unit_of
from sim.figures.plot import (
    Panels,
    above_zero,
    append_foreign_data,
    completed_rows,
    curve_keys,
    draw_foreign_data,
    foreign_values,
    label_axes,
    observable_label,
    panels,
    rows_of_points,
    scale_of_point,
    write_no_data,
)
from sim.figures.style import PALE, PALE_LINE, CurveStyle, name_protocols
from sim.figures.variables import groups, is_prescribed, legend
from sim.study.plottable import SHARE, Observable, profiles

#: Fewest replicates for which the mean has an interval: that of two says little.
MIN_REPLICATES = 3

#: Number density (1/⟨d⟩²) of the emptiest slice at the top of a flat profile.
THIN = 0.01

#: Sizes of the markers of means and of single replicates, points.
_MEAN_SIZE, _REPLICATE_SIZE = 3.8, 2.2


def observables(data: FigureData) -> dict[str, Observable]:
    """Return the observables by axis: ``x``, and ``y`` unless the height is there."""
    by_name, named = profiles(data.spec.system), {"x": data.spec.show, "y": data.spec.second}
    return {axis: by_name[name] for axis, name in named.items() if name}


def slices(data: FigureData, row: Mapping[str, Any]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return heights (slice,) and values by axis (replicate, slice), in the units of the plot.

    The slices end at the height below which the share `SHARE` of the particles lies; the option
    ``between`` narrows them further. Of two observables, slices are left out in which no replicate
    has both, and values are not-a-number where a replicate lacks either.
    """
    if data.spec.flat:
        filling, height = data.results.profile(row["point"], "number_density")
        dense = np.flatnonzero(filling.mean(axis=0) * row["diameter"] ** 2 >= THIN)
        end, unit = dense.max(initial=-1), row["diameter"]
    else:
        filling, height = data.results.profile(row["point"], "packing_profile")
        filled = np.cumsum(np.nan_to_num(filling.mean(axis=0)))
        end, unit = np.searchsorted(filled, SHARE * filled[-1]), scale_of_point(data, row, "m")
    chosen = np.arange(height.size) <= end
    if between := data.spec.between:
        low, high = (limit * row["diameter"] for limit in between)
        chosen &= (low <= height) & (height <= high)
    values = {
        axis: data.results.profile(row["point"], one.source)[0][:, chosen]
        * (1 / scale_of_point(data, row, one.unit))
        for axis, one in observables(data).items()
    }
    height = height[chosen] / unit
    if len(values) == 1:
        return height, values
    is_known = np.isfinite(list(values.values())).all(axis=0)
    is_shown = is_known.any(axis=0)
    pairs = {axis: np.where(is_known, one, np.nan)[:, is_shown] for axis, one in values.items()}
    return height[is_shown], pairs


def means(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the means over the replicates of a point, a row per slice.

    Columns are ``height``, and by axis ``x`` and the half width of its 95 % interval, ``x_half``.
    Unknown values are not-a-number.
    """
    height, values = slices(data, row)
    columns: dict[str, Any] = {"height": height}
    for axis, of_replicates in values.items():
        if data.spec.flat:
            # A slice that is empty in a replicate has no mean.
            columns[axis] = of_replicates.mean(axis=0)
            columns[f"{axis}_half"] = student_half_width(of_replicates)
            continue
        samples = [sample[np.isfinite(sample)] for sample in of_replicates.T]
        columns[axis] = [sample.mean() if sample.size else np.nan for sample in samples]
        columns[f"{axis}_half"] = [float(student_half_width(sample)) for sample in samples]
    return pd.DataFrame(columns, dtype=float)


def _is_drawable(data: FigureData, rows: pd.DataFrame) -> pd.Series:
    """Return which rows of `means` are above 0 on every logarithmic axis."""
    return (rows[[axis for axis in "xy" if axis in data.spec.log]] > 0).all(axis=1)


def draw(data: FigureData) -> Figure:
    """Draw the mean of each point, and its interval or, for few replicates, all of these."""
    spec, shown_observables = data.spec, observables(data)
    draw_point = _draw_slices if "y" in shown_observables else _draw_line
    figure, shown = panels(data)
    drawn = [
        draw_point(axes, data, row, style, label)
        for axes, rows in shown
        for style, label, row in groups(data, rows)
    ]
    names = " and ".join(one.name for one in shown_observables.values())
    write_no_data(shown, names + _height_range_suffix(data))
    foreign = draw_foreign_data(data, shown)
    for axes, _ in shown:
        for axis in spec.log:
            set_log(axes, axis)
    height = label_with_unit("height z", unit_of("m", spec.units, spec.system))
    labels = [observable_label(data, one) for one in shown_observables.values()]
    usual = [*labels, height][:: -1 if spec.flat else 1][:2]
    x, y = usual
    label_axes(figure, shown, spec.labels.get("x", x), spec.labels.get("y", y))
    if "y" in shown_observables:
        _limit_axes(data, shown, pd.concat(drawn) if drawn else pd.DataFrame())
    elif spec.flat:
        _limit_flat(shown, pd.concat(drawn or [pd.DataFrame({"x": []})])["x"])
    elif not spec.between:
        # Panels share their axes, and set limits do not follow later data.
        shown[0][0].set_ylim(bottom=min([0.0, *foreign_values(data, "y")]))
    if is_prescribed(spec) and data.rows["protocol"].nunique() > 1:
        name_protocols(shown[0][0], spec.system)
    legend(data, figure, shown, spec.by if spec.flat else curve_keys(data), foreign)
    return figure


def _draw_line(
    axes: Axes, data: FigureData, row: Mapping[str, Any], style: CurveStyle, label: str
) -> pd.DataFrame:
    """Draw a line over the height, with a band or pale lines; return what it shows."""
    rows, (_, values) = means(data, row), slices(data, row)
    rows["x"] = rows["x"].where(_is_drawable(data, rows))
    if rows["x"].isna().all():
        return rows
    mean, half, height = rows["x"], rows["x_half"], rows["height"]
    line: dict[str, Any] = {"color": style.colour, "linestyle": style.dashes, "label": label}
    band: dict[str, Any] = {"color": style.colour, "alpha": 0.15, "linewidth": 0}
    if data.spec.flat:
        # The converged protocol is pale beside the published one.
        beside = is_prescribed(data.spec) and data.rows["protocol"].nunique() > 1
        if beside and row["protocol"] == "converged":
            line |= PALE_LINE | {"label": None}
        axes.plot(height, mean, **line)
        axes.fill_between(height, mean - half, mean + half, **band)
        return rows
    axes.plot(mean, height, **line)
    if row["completed"] < MIN_REPLICATES:
        each = above_zero(data, "x", values["x"].T)
        axes.plot(each, height, color=style.colour, alpha=PALE, linewidth=0.7, zorder=1.5)
    else:
        axes.fill_betweenx(height, mean - half, mean + half, **band)
    return rows


def _draw_slices(
    axes: Axes, data: FigureData, row: Mapping[str, Any], style: CurveStyle, label: str
) -> pd.DataFrame:
    """Draw a marker per slice, with bars or pale markers; return what it shows."""
    rows = means(data, row)
    rows = rows[_is_drawable(data, rows)]
    if rows.empty:
        return rows
    has_few = row["completed"] < MIN_REPLICATES
    if has_few:
        _, values = slices(data, row)
        pale: dict[str, Any] = {"color": style.colour, "alpha": PALE, "zorder": 1.5}
        axes.plot(*map(np.ravel, values.values()), style.marker, markersize=_REPLICATE_SIZE, **pale)
    look: dict[str, Any] = {"color": style.colour, "marker": style.marker, "markersize": _MEAN_SIZE}
    look |= {"linestyle": "none", "zorder": 3}
    has_bar = rows["x_half"].notna() & (not has_few)
    barred, others = rows[has_bar], rows[~has_bar]
    ends = {f"{axis}err": barred[f"{axis}_half"] for axis in "xy"}
    axes.errorbar(barred["x"], barred["y"], **ends, elinewidth=0.6, capsize=0, **look)
    axes.plot(others["x"], others["y"], **look)
    axes.plot([], [], style.marker, color=style.colour, label=label)
    return rows


def _limit_flat(shown: Panels, means: pd.Series) -> None:
    """Let axes begin at zero and follow the means, however wide their bands are."""
    low, high = min(0.0, means.min()), max(0.0, means.max())
    room = 0.08 * (high - low) if high > low else 1.0
    for axes, _ in shown:
        axes.set(xlim=(0, None), ylim=(low - room if low else 0.0, high + room))


def _limit_axes(data: FigureData, shown: Panels, drawn: pd.DataFrame) -> None:
    for axes, _ in shown:
        axes.autoscale_view()
        for axis in {"x", "y"} - set(data.spec.log):
            shown_values = drawn.get(axis, NONE), drawn.get(f"{axis}_half", NONE)
            limit_axis(axes, axis, *shown_values, foreign_values(data, axis))


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, a row per point and slice, units in the headings."""
    spec, shown = data.spec, observables(data)
    headings = {"height": f"height [{unit_of('m', spec.units, spec.system)}]"}
    for axis, one in shown.items():
        unit = unit_of(one.unit, spec.units, spec.system) or "1"
        of = f" of {one.name}" if len(shown) > 1 else ""
        headings[axis] = f"{one.name} [{unit}]"
        headings[f"{axis}_half"] = f"half width of 95 % interval{of} [{unit}]"

    names: tuple[str, ...] = ()
    if spec.flat:
        heading = spec.quantities[0].label
        half_width = f"half width of 95 % interval {heading.split()[-1]}"
        headings = {"height": "height above the belt [⟨d⟩]", "x": heading, "x_half": half_width}
        names = (*spec.named, "initial_velocity", "protocol")

    def rows(row: Mapping[str, Any]) -> pd.DataFrame:
        of_point = means(data, row)
        place = 0 if spec.flat else of_point.shape[1]
        of_point.insert(place, "completed replicates", row["completed"])
        return of_point

    y = headings.get("y", headings["height"])
    return append_foreign_data(data, rows_of_points(data, headings, rows, names), headings["x"], y)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on lines or markers, their extent, and omissions."""
    of_points = [means(data, row) for row in completed_rows(data)]
    with_values = [rows[rows["x"].notna()] for rows in of_points]
    omitted = sum(int((~_is_drawable(data, rows)).sum()) for rows in with_values)
    what = "A marker per slice of the height" if data.spec.second else "Lines over the height"
    few = f"; of fewer than {MIN_REPLICATES}, each is pale"
    extent = f"They end where {100 * SHARE:g} % of the particles are below."
    if data.spec.flat:
        few = " where there are several, which may go beyond the axes"
        extent = (
            "z is measured from the present position of the belt, in slices of ⟨d⟩, up to the last "
            f"one with {THIN:g} beads per ⟨d⟩² or more; one that is empty in a replicate has no "
            "velocity."
        )
    if between := data.spec.between:
        low, high = between
        extent += f" Heights shown: {low:g} to {high:g} diameters above the base."
    suffix = _height_range_suffix(data)
    return [
        f"{what}: means over the replicates, with 95 % intervals (Student){few}.",
        extent,
        *not_drawn(sum(rows.empty for rows in with_values), f"without a value{suffix}"),
        *not_drawn(omitted, "slices not above 0 on a logarithmic axis"),
    ]


def _height_range_suffix(data: FigureData) -> str:
    return " at these heights" if data.spec.between else ""
