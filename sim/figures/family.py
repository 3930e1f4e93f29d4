"""A family of curves: a line, points and intervals of each, beside those of another protocol."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from sim.figures.data import is_undecided, split_curves
from sim.figures.style import (
    PALE_LINE,
    PALE_MARKER_SIZE,
    RING,
    RING_MEANS,
    CurveStyle,
    Look,
    explain_markers,
    faces,
    labels_and_styles,
    name_protocols,
)

#: Columns of what is drawn: places along both axes, half widths of their intervals, and the
#: replicates of a point whose mean they do not tell, as those in several states. None is a
#: parameter's name.
X, Y, X_HALF, Y_HALF, APART = "along x", "along y", "half of x", "half of y", "apart"

#: Look of the replicates of such a point, and of a line through points that are not steady.
_BED: dict[str, Any] = {"markersize": 3.5, "markerfacecolor": "none", "linestyle": "none"}
_THIN_LINE: dict[str, Any] = {"linewidth": 0.7, "alpha": 0.6, "zorder": 1.8}

#: Most points of a line that have bars, which would touch; more have a band, and smaller markers.
MOST_BARS, _CROWDED_MARKER_SIZE = 20, 2.8


def draw_family(
    axes: Axes, rows: pd.DataFrame, keys: Sequence[str], look: Look, *, joins_open: bool
) -> None:
    """Draw one curve per set of parameters.

    A curve of the converged protocol is pale beside the published one of the same entry.
    """
    if rows.empty:
        return
    explain_markers(axes, rows)
    single = rows[rows[Y_HALF].isna() & rows[Y].notna()]
    if len(single) and rows[Y_HALF].notna().any():
        axes.plot(single[X], single[Y], label=RING_MEANS, **RING)
    curves = split_curves(rows, X, keys, ())
    curves.sort(key=lambda curve: curve[1]["protocol"].iloc[0] != "published")
    labels, styles = labels_and_styles([names for names, _ in curves], look)
    drawn: dict[str, pd.DataFrame] = {}
    for (_, curve), label in zip(curves, labels, strict=True):
        style = styles[label]
        _draw_curve(axes, curve, style, drawn.get(label), joins_open=joins_open)
        if label not in drawn:
            entry = {"linestyle": style.dashes, "marker": style.marker, "label": label}
            axes.plot([], [], color=style.colour, **entry)
            drawn[label] = curve
    if len(drawn) < len(curves):
        name_protocols(axes, str(rows["system"].iloc[0]))
    if rows[APART].notna().any():
        axes.plot([], [], color="#666666", marker="o", label="single replicates", **_BED)


def _draw_curve(
    axes: Axes,
    rows: pd.DataFrame,
    style: CurveStyle,
    beside: pd.DataFrame | None,
    *,
    joins_open: bool,
) -> None:
    """Draw the points of a curve with their intervals, and its line.

    It joins steady points, and those of runs too short to tell; a point whose mean its replicates
    do not tell is drawn as these. ``beside`` are the points of the other protocol, if there are
    any: the curve is pale then.
    """
    _draw_replicates_apart(axes, rows, style)
    along, spread, pale = rows[X], rows[X_HALF], beside is not None
    value, half = (rows[name].mask(rows[APART].notna()) for name in (Y, Y_HALF))
    size = PALE_MARKER_SIZE if pale else None
    if style.dashes != "none":
        is_joined = (rows["regime"] == "steady") | is_undecided(rows)
        line, size = value.where(is_joined), None
        wide = PALE_LINE if pale else {}
        path = line.set_axis(along)
        if beside is not None:
            path = _with_gaps(path, beside)
        axes.plot(path.index, path, color=style.colour, linestyle=style.dashes, **wide)
        if joins_open and not pale:
            axes.plot(along, value, color=style.colour, **_THIN_LINE)
        if len(rows) > MOST_BARS:
            size, band = _CROWDED_MARKER_SIZE, (line - half, line + half)
            axes.fill_between(along, *band, color=style.colour, alpha=0.2, linewidth=0, zorder=1.5)
            half = half.mask(line.notna())
    look: dict[str, Any] = {"color": style.colour, "alpha": PALE_LINE["alpha"] if pale else None}
    # Below the markers of all curves.
    bars = None if spread.isna().all() else spread
    axes.errorbar(along, value, half, bars, fmt="none", elinewidth=0.9, zorder=2.6, **look)
    for chosen, face in faces(rows, style.colour):
        look |= {"markerfacecolor": face, "markersize": size, "linestyle": "none"}
        axes.plot(along[chosen], value[chosen], marker=style.marker, zorder=3, **look)


def _draw_replicates_apart(axes: Axes, rows: pd.DataFrame, style: CurveStyle) -> None:
    for place, values in rows[[X, APART]].dropna().itertuples(index=False):
        marker: dict[str, Any] = {"color": style.colour, "marker": style.marker}
        axes.plot(np.full(len(values), place), values, **marker, **_BED)


def _with_gaps(line: pd.Series, beside: pd.DataFrame) -> pd.Series:
    """Return a line over x that breaks where points of the other protocol lie off it."""
    others = beside[~beside[X].isin(line.index)]
    expected = np.interp(others[X], line.index, line)
    off = others[(others[Y] - expected).abs() > others[Y_HALF]]
    return pd.concat([line, pd.Series(np.nan, off[X])]).sort_index()
