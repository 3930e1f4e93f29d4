"""One number against another in every slice of the height: a study's own plot of profiles.

Options of a figure: those of `sim.figures.plot`, and ``between``, the heights in diameters that
slices lie between, or nothing.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.bars import cuts, end_bars, mark_cut_bars
from sim.figures.beside import beside_notes, draw_beside, values_beside, with_beside
from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.plot import (
    Panels,
    empty_text,
    groups,
    label_axes,
    legend,
    lost_note,
    named_columns,
    observable_label,
    panels,
    scale_of_point,
    set_log,
    without_note,
)
from sim.figures.style import PALE, CurveStyle
from sim.figures.units import unit_of
from sim.study.catalogue.limits import SHARE
from sim.study.plottable import Observable, profiles

#: Replicates from which their mean is drawn with its interval, which of two says little.
ENOUGH = 3

#: Sizes of markers of means, and of single replicates, points.
_MEAN, _SINGLE = 3.8, 2.2


def slices(
    data: FigureData, row: Mapping[str, Any], one: Observable
) -> tuple[np.ndarray, np.ndarray]:
    """Return a profile of a point (replicate, slice) and the heights, in the units of the plot.

    They go up to the height below which almost all particles are, or where the plot says.
    """
    values, height = data.results.profile(row["point"], one.source)
    packing, _ = data.results.profile(row["point"], "packing_profile")
    filled = np.cumsum(np.nan_to_num(packing.mean(axis=0)))
    chosen = np.arange(height.size) <= np.searchsorted(filled, SHARE * filled[-1])
    if between := data.spec.options["between"]:
        low, high = (each * row["diameter"] for each in between)
        chosen &= (low <= height) & (height <= high)
    by, over = (scale_of_point(data, row, unit) for unit in (one.unit, "m"))
    return values[:, chosen] / by, height[chosen] / over


def pairs(data: FigureData, row: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the heights of the slices of a point in which some replicate knows both numbers.

    Behind them (replicate, slice) the number on the x axis and that on the y axis, in the units of
    the plot, not-a-number where a replicate does not know both.
    """
    (x, height), (y, _) = (slices(data, row, one) for one in observables(data))
    both = np.isfinite(x) & np.isfinite(y)
    some = both.any(axis=0)
    x, y = (np.where(both, each, np.nan)[:, some] for each in (x, y))
    return height[some], x, y


def observables(data: FigureData) -> tuple[Observable, Observable]:
    """Return what is on the x axis, and what is on the y axis."""
    named, options = profiles(data.spec.system), data.spec.options
    return named[options["show"]], named[options["second"]]


def means(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return means over the replicates of a point, a row per slice of `pairs`.

    Columns ``height``, ``x`` and ``y`` and half widths of their 95 % intervals, ``x_half`` and
    ``y_half``.
    """
    height, *both = pairs(data, row)
    found = {"height": height}
    for axis, values in zip("xy", both, strict=True):
        known = [each[np.isfinite(each)] for each in values.T]
        found[axis] = np.array([each.mean() for each in known])
        found[f"{axis}_half"] = np.array([float(student_half_width(each)) for each in known])
    return pd.DataFrame(found, dtype=float)


def placed(data: FigureData, found: pd.DataFrame) -> pd.DataFrame:
    """Return the `means` that have a place on logarithmic axes, which have none for 0 and below."""
    log = [axis for axis in "xy" if axis in data.spec.options["log"]]
    return found[(found[log] > 0).all(axis=1)]


def draw(data: FigureData) -> Figure:
    """Draw a marker per slice of each point, with its intervals or, of few, its replicates."""
    figure, shown = panels(data)
    drawn = []
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            found = placed(data, means(data, row))
            drawn.append(found)
            if found.empty:
                continue
            if row["completed"] < ENOUGH:
                _, *both = pairs(data, row)
                look: dict[str, Any] = {"color": style.colour, "alpha": PALE, "zorder": 1.5}
                axes.plot(*map(np.ravel, both), style.marker, markersize=_SINGLE, **look)
            _draw_means(axes, found, style, row["completed"] >= ENOUGH)
            axes.plot([], [], style.marker, color=style.colour, label=label)
    x, y = observables(data)
    empty_text(shown, f"{x.name} and {y.name}{there(data)}")
    beside = draw_beside(data, shown)
    _set_axes(data, shown, pd.concat(drawn) if drawn else pd.DataFrame())
    label_axes(figure, shown, observable_label(data, x), observable_label(data, y))
    legend(figure, shown, beside)
    return figure


def _draw_means(axes: Axes, found: pd.DataFrame, style: CurveStyle, bars: bool) -> None:
    """Draw a marker per slice, with bars where intervals are known and wanted."""
    look: dict[str, Any] = {"color": style.colour, "marker": style.marker, "markersize": _MEAN}
    look |= {"linestyle": "none", "zorder": 3}
    has = found["x_half"].notna() & bars
    ends = {f"{axis}err": found[f"{axis}_half"][has] for axis in "xy"}
    axes.errorbar(found["x"][has], found["y"][has], **ends, elinewidth=0.6, capsize=0, **look)
    axes.plot(found["x"][~has], found["y"][~has], **look)


def _set_axes(data: FigureData, shown: Panels, drawn: pd.DataFrame) -> None:
    """Set scales and limits; intervals and replicates take no more room than the means do."""
    for axes, _ in shown:
        for axis in data.spec.options["log"]:
            set_log(axes, axis)
        axes.autoscale_view()
        for axis in {"x", "y"} - set(data.spec.options["log"]):
            own = drawn.get(axis, pd.Series(dtype=float))
            end_bars(axes, axis, pd.concat([own, values_beside(data, axis)]))
    for axes, _ in shown:
        mark_cut_bars(axes)


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the markers, a row per point and slice, units in the headings."""
    spec, headings = data.spec, {}
    for axis, one in zip("xy", observables(data), strict=True):
        unit = unit_of(one.unit, spec.options["units"], spec.system) or "1"
        headings[axis] = f"{one.name} [{unit}]"
        headings[f"{axis}_half"] = f"half width of 95 % interval of {one.name} [{unit}]"
    headings["height"] = f"height [{unit_of('m', spec.options['units'], spec.system)}]"
    known = data.rows[data.rows["completed"] > 0]
    named = named_columns(data, known)
    parts = []
    for (index, row), found in zip(known.iterrows(), _each(data), strict=True):
        own = {name: column[index] for name, column in named.items()}
        columns = {headings[str(name)]: found[name] for name in found}
        parts.append(pd.DataFrame(own | columns | {"completed replicates": row["completed"]}))
    found = pd.concat(parts) if parts else pd.DataFrame(columns=[*named, *headings.values()])
    return with_beside(data, found, headings["x"], headings["y"])


def _each(data: FigureData) -> list[pd.DataFrame]:
    """Return the `means` of each completed point."""
    known = data.rows[data.rows["completed"] > 0].to_dict("records")
    return [means(data, {str(name): value for name, value in row.items()}) for row in known]


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of markers, bars, and slices that are left out."""
    completed = data.rows["completed"]
    many, few = (completed >= ENOUGH).any(), ((completed > 1) & (completed < ENOUGH)).any()
    bars = "Bars: Student's 95 % interval of the mean over replicates"
    pale = f"of fewer than {ENOUGH} replicates, each is a pale marker"
    found = [(one, placed(data, one)) for one in _each(data)]
    lost = sum(len(every) - len(kept) for every, kept in found)
    drawn = pd.concat([kept for _, kept in found]) if found else pd.DataFrame()
    log = data.spec.options["log"]
    cut = many and any(
        cuts(drawn[axis], drawn[f"{axis}_half"], values_beside(data, axis), logarithmic=axis in log)
        for axis in "xy"
    )
    return [
        "A marker per slice of the height, the mean over the replicates.",
        extent_sentence(data, "Slices"),
        *([f"{bars}; {pale}." if few else f"{bars}."] if many else []),
        *([f"{pale[0].upper()}{pale[1:]}."] if few and not many else []),
        *(["Bars that end in a caret go on beyond the axes."] if cut else []),
        *without_note(sum(every.empty for every, _ in found), f"a value{there(data)}"),
        *lost_note(lost, "slices"),
        unsteady_sentence(data.rows),
        *beside_notes(data),
    ]


def there(data: FigureData) -> str:
    """Return what names the heights that a plot shows behind what no run has there."""
    return " at these heights" if data.spec.options["between"] else ""


def extent_sentence(data: FigureData, what: str) -> str:
    """Say up to where slices are shown and, where the plot says so, between which heights."""
    text = f"{what} end where {100 * SHARE:g} % of the particles are below."
    if between := data.spec.options["between"]:
        low, high = between
        text += f" Heights shown: {low:g} to {high:g} diameters above the base."
    return text
