"""One profile against another, a marker per slice of the height: a plot that a study file defines.

Options of a figure: those of `sim.figures.plot`, and ``between``, the lowest and highest height
shown in diameters, or nothing.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.axes import has_cut_bars, limit_axis, mark_cut_bars, set_log
from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.foreign_data import (
    append_foreign_data,
    draw_foreign_data,
    foreign_data_notes,
    foreign_values,
)
from sim.figures.plot import (
    Panels,
    groups,
    label_axes,
    legend,
    missing_value_note,
    named_columns,
    nonpositive_note,
    observable_label,
    panels,
    scale_of_point,
    write_no_data,
)
from sim.figures.style import PALE, CurveStyle
from sim.figures.units import unit_of
from sim.study.figure_spec import SHARE
from sim.study.plottable import Observable, profiles

#: Fewest replicates for which the mean has an interval: that of two says little.
MIN_REPLICATES = 3

#: Sizes of the markers of means and of single replicates, points.
_MEAN_SIZE, _REPLICATE_SIZE = 3.8, 2.2


def slices(
    data: FigureData, row: Mapping[str, Any], observable: Observable
) -> tuple[np.ndarray, np.ndarray]:
    """Return a profile of a point (replicate, slice) and the heights (slice,), in the plot's units.

    The slices end at the height below which the share `SHARE` of the particles lies. The option
    ``between`` narrows them further.
    """
    values, height = data.results.profile(row["point"], observable.source)
    packing, _ = data.results.profile(row["point"], "packing_profile")
    filled = np.cumsum(np.nan_to_num(packing.mean(axis=0)))
    chosen = np.arange(height.size) <= np.searchsorted(filled, SHARE * filled[-1])
    if between := data.spec.options["between"]:
        low, high = (limit * row["diameter"] for limit in between)
        chosen &= (low <= height) & (height <= high)
    value_scale, height_scale = (scale_of_point(data, row, unit) for unit in (observable.unit, "m"))
    return values[:, chosen] / value_scale, height[chosen] / height_scale


def pairs(data: FigureData, row: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return heights (slice,), x and y (replicate, slice) of a point, in the units of the plot.

    Only slices in which some replicate has both values are returned. Values are not-a-number where
    a replicate lacks either.
    """
    (x, height), (y, _) = (slices(data, row, observable) for observable in observables(data))
    is_known = np.isfinite(x) & np.isfinite(y)
    is_shown = is_known.any(axis=0)
    x, y = (np.where(is_known, values, np.nan)[:, is_shown] for values in (x, y))
    return height[is_shown], x, y


def observables(data: FigureData) -> tuple[Observable, Observable]:
    """Return the observables on the x and the y axis."""
    by_name, options = profiles(data.spec.system), data.spec.options
    return by_name[options["show"]], by_name[options["second"]]


def means(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the means over the replicates of a point, a row per slice of `pairs`.

    Columns are ``height``, ``x`` and ``y``, and the half widths of their 95 % intervals, ``x_half``
    and ``y_half``.
    """
    height, *axis_values = pairs(data, row)
    columns = {"height": height}
    for axis, values in zip("xy", axis_values, strict=True):
        samples = [sample[np.isfinite(sample)] for sample in values.T]
        columns[axis] = np.array([sample.mean() for sample in samples])
        columns[f"{axis}_half"] = np.array(
            [float(student_half_width(sample)) for sample in samples]
        )
    return pd.DataFrame(columns, dtype=float)


def drop_nonpositive(data: FigureData, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of `means` that are above 0 on every logarithmic axis."""
    log = [axis for axis in "xy" if axis in data.spec.options["log"]]
    return rows[(rows[log] > 0).all(axis=1)]


def draw(data: FigureData) -> Figure:
    """Draw a marker per slice, with its interval or, for few replicates, a pale marker of each."""
    figure, shown = panels(data)
    drawn = []
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            slice_means = drop_nonpositive(data, means(data, row))
            drawn.append(slice_means)
            if slice_means.empty:
                continue
            if row["completed"] < MIN_REPLICATES:
                _, *replicates = pairs(data, row)
                look: dict[str, Any] = {"color": style.colour, "alpha": PALE, "zorder": 1.5}
                axes.plot(
                    *map(np.ravel, replicates), style.marker, markersize=_REPLICATE_SIZE, **look
                )
            _draw_means(axes, slice_means, style, row["completed"] >= MIN_REPLICATES)
            axes.plot([], [], style.marker, color=style.colour, label=label)
    x, y = observables(data)
    write_no_data(shown, f"{x.name} and {y.name}{height_range_suffix(data)}")
    foreign = draw_foreign_data(data, shown)
    _set_axes(data, shown, pd.concat(drawn) if drawn else pd.DataFrame())
    label_axes(figure, shown, observable_label(data, x), observable_label(data, y))
    legend(figure, shown, foreign)
    return figure


def _draw_means(axes: Axes, slice_means: pd.DataFrame, style: CurveStyle, bars: bool) -> None:
    """Draw a marker per slice, with error bars where ``bars`` is set and an interval is known."""
    look: dict[str, Any] = {"color": style.colour, "marker": style.marker, "markersize": _MEAN_SIZE}
    look |= {"linestyle": "none", "zorder": 3}
    has_bar = slice_means["x_half"].notna() & bars
    ends = {f"{axis}err": slice_means[f"{axis}_half"][has_bar] for axis in "xy"}
    axes.errorbar(
        slice_means["x"][has_bar],
        slice_means["y"][has_bar],
        **ends,
        elinewidth=0.6,
        capsize=0,
        **look,
    )
    axes.plot(slice_means["x"][~has_bar], slice_means["y"][~has_bar], **look)


def _set_axes(data: FigureData, shown: Panels, drawn: pd.DataFrame) -> None:
    """Set scales and limits; limits follow the means, and carets mark bars that they cut."""
    for axes, _ in shown:
        for axis in data.spec.options["log"]:
            set_log(axes, axis)
        axes.autoscale_view()
        for axis in {"x", "y"} - set(data.spec.options["log"]):
            means_on_axis = drawn.get(axis, pd.Series(dtype=float))
            limit_axis(axes, axis, pd.concat([means_on_axis, foreign_values(data, axis)]))
    for axes, _ in shown:
        mark_cut_bars(axes)


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, a row per point and slice, units in the headings."""
    spec, headings = data.spec, {}
    for axis, observable in zip("xy", observables(data), strict=True):
        unit = unit_of(observable.unit, spec.options["units"], spec.system) or "1"
        headings[axis] = f"{observable.name} [{unit}]"
        headings[f"{axis}_half"] = f"half width of 95 % interval of {observable.name} [{unit}]"
    headings["height"] = f"height [{unit_of('m', spec.options['units'], spec.system)}]"
    completed = data.rows[data.rows["completed"] > 0]
    id_columns = named_columns(data, completed)
    parts = []
    for (index, row), slice_means in zip(completed.iterrows(), _means_of_points(data), strict=True):
        point_columns = {name: column[index] for name, column in id_columns.items()}
        columns = {headings[str(name)]: slice_means[name] for name in slice_means}
        parts.append(
            pd.DataFrame(point_columns | columns | {"completed replicates": row["completed"]})
        )
    slice_means = (
        pd.concat(parts) if parts else pd.DataFrame(columns=[*id_columns, *headings.values()])
    )
    return append_foreign_data(data, slice_means, headings["x"], headings["y"])


def _means_of_points(data: FigureData) -> list[pd.DataFrame]:
    """Return the `means` of each completed point."""
    completed = data.rows[data.rows["completed"] > 0].to_dict("records")
    return [means(data, {str(name): value for name, value in row.items()}) for row in completed]


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on markers, bars and omitted slices."""
    completed = data.rows["completed"]
    many, few = (
        (completed >= MIN_REPLICATES).any(),
        ((completed > 1) & (completed < MIN_REPLICATES)).any(),
    )
    bars = "Bars: Student's 95 % interval of the mean over replicates"
    pale = f"of fewer than {MIN_REPLICATES} replicates, each is a pale marker"
    points = [
        (slice_means, drop_nonpositive(data, slice_means)) for slice_means in _means_of_points(data)
    ]
    omitted = sum(len(slice_means) - len(drawable) for slice_means, drawable in points)
    drawn = pd.concat([drawable for _, drawable in points]) if points else pd.DataFrame()
    log = data.spec.options["log"]
    is_cut = many and any(
        has_cut_bars(
            drawn[axis], drawn[f"{axis}_half"], foreign_values(data, axis), logarithmic=axis in log
        )
        for axis in "xy"
    )
    return [
        "A marker per slice of the height, the mean over the replicates.",
        extent_sentence(data, "Slices"),
        *([f"{bars}; {pale}." if few else f"{bars}."] if many else []),
        *([f"{pale[0].upper()}{pale[1:]}."] if few and not many else []),
        *(["Bars that end in a caret go on beyond the axes."] if is_cut else []),
        *missing_value_note(
            sum(slice_means.empty for slice_means, _ in points),
            f"a value{height_range_suffix(data)}",
        ),
        *nonpositive_note(omitted, "slices"),
        unsteady_sentence(data.rows),
        *foreign_data_notes(data),
    ]


def height_range_suffix(data: FigureData) -> str:
    """Return a suffix that names the height range for messages about missing data."""
    return " at these heights" if data.spec.options["between"] else ""


def extent_sentence(data: FigureData, noun: str) -> str:
    """Write where slices end and, with the option ``between``, which heights are shown.

    ``noun`` is the subject: slices or lines.
    """
    text = f"{noun} end where {100 * SHARE:g} % of the particles are below."
    if between := data.spec.options["between"]:
        low, high = between
        text += f" Heights shown: {low:g} to {high:g} diameters above the base."
    return text
