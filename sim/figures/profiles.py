"""Profiles of each point: a line over the height, or a marker per slice for one against another."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.caption import label_with_unit, not_drawn, unit_of
from sim.figures.data import FigureData
from sim.figures.plot import (
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
from sim.figures.style import PALE_LINE, CurveStyle, limit_axis, name_protocols, set_log
from sim.figures.variables import groups, is_prescribed, legend
from sim.study.plottable import SHARE, Observable, profiles

#: Fewest replicates for which the mean has an interval: that of two says little.
MIN_REPLICATES = 3

#: Number density (1/⟨d⟩²) of the emptiest slice at the top of a flat profile.
THIN = 0.01


def observables(data: FigureData) -> dict[str, Observable]:
    """Return the observables by axis: ``x``, and ``y`` unless the height is there."""
    by_name, named = profiles(data.spec.system), {"x": data.spec.show, "y": data.spec.second}
    return {axis: by_name[name] for axis, name in named.items() if name}


def slices(data: FigureData, row: Mapping[str, Any]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return heights (slice,) and values by axis (replicate, slice), in the units of the plot.

    The slices end at the height below which the share `SHARE` of the particles lies, and are within
    ``between``. Of two observables, values are not-a-number where a replicate lacks either.
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
    """Draw the mean of each point with its interval."""
    spec, shown_observables = data.spec, observables(data)
    figure, shown = panels(data)
    drawn = [
        _draw_point(axes, data, row, style, label)
        for axes, rows in shown
        for style, label, row in groups(data, rows)
    ]
    names = " and ".join(one.name for one in shown_observables.values())
    write_no_data(shown, names + _height_range_suffix(data))
    foreign = draw_foreign_data(data, shown)
    places = pd.concat([*drawn, pd.DataFrame({name: [np.nan] for name in ("x", "y", "height")})])
    for axes, _ in shown:
        for axis in spec.log:
            set_log(axes, axis)
        axes.autoscale_view()
        for along, name in zip("xy", _columns(data), strict=True):
            limit_axis(axes, along, places[name], foreign_values(data, along))
            if name == "height" and not spec.between:
                # Panels share their axes, and set limits do not follow later data.
                first = min([0.0, *foreign_values(data, along)])
                shown[0][0].set(**{f"{along}lim": (first, None)})
    height = label_with_unit("height z", unit_of("m", spec.units, spec.system))
    labels = {axis: observable_label(data, one) for axis, one in shown_observables.items()}
    x, y = (({"height": height} | labels)[name] for name in _columns(data))
    label_axes(figure, shown, spec.labels.get("x", x), spec.labels.get("y", y))
    if _is_beside(data):
        name_protocols(shown[0][0], spec.system)
    legend(data, figure, shown, spec.by if spec.flat else curve_keys(data), foreign)
    return figure


def _columns(data: FigureData) -> tuple[str, str]:
    """Return the columns of `means` on the axes."""
    if data.spec.second:
        return "x", "y"
    return ("height", "x") if data.spec.flat else ("x", "height")


def _is_beside(data: FigureData) -> bool:
    """Return whether curves of the converged protocol are pale beside the published ones."""
    return is_prescribed(data.spec) and data.rows["protocol"].nunique() > 1


def _draw_point(
    axes: Axes, data: FigureData, row: Mapping[str, Any], style: CurveStyle, label: str
) -> pd.DataFrame:
    """Draw a line with a band over the height, or a marker per slice; return what it shows.

    There are no intervals of few replicates.
    """
    rows, (x, y) = means(data, row), _columns(data)
    rows = rows.where(_is_drawable(data, rows))
    if rows["x"].isna().all():
        return rows
    if row["completed"] < MIN_REPLICATES and not data.spec.flat:
        rows[rows.columns[rows.columns.str.endswith("_half")]] = np.nan
    mean, half = rows["x"], rows["x_half"]
    if data.spec.second:
        look: dict[str, Any] = {"fmt": style.marker, "markersize": 3.8, "elinewidth": 0.6}
        look |= {"color": style.colour, "capsize": 0, "zorder": 3, "label": label}
        axes.errorbar(mean, rows["y"], rows["y_half"], half, **look)
        return rows
    line: dict[str, Any] = {"color": style.colour, "linestyle": style.dashes, "label": label}
    if _is_beside(data) and row["protocol"] == "converged":
        line |= PALE_LINE | {"label": None}
    axes.plot(rows[x], rows[y], **line)
    fill = axes.fill_between if data.spec.flat else axes.fill_betweenx
    band: dict[str, Any] = {"color": style.colour, "alpha": 0.15, "linewidth": 0}
    fill(rows["height"], mean - half, mean + half, **band)
    return rows


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
    few = f" where there are {MIN_REPLICATES} or more"
    extent = f"They end where {100 * SHARE:g} % of the particles are below."
    if data.spec.flat:
        few = " where there are several"
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
