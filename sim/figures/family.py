"""Curves of a quantity for sets of parameters, with intervals, regimes and protocols."""

from collections.abc import Mapping, Sequence
from itertools import compress, product
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from sim.figures.data import Quantity, split_curves
from sim.figures.style import (
    MARKERS,
    PALE_LINE,
    PALE_MARKER_SIZE,
    RING,
    RING_MEANS,
    CurveStyle,
    Look,
    cycle_style,
    explain_markers,
    faces,
    is_undecided,
    move_aside,
    name_protocols,
)

#: Most points of a line that have bars, which would touch; more have a band, and smaller markers.
MOST_BARS, CROWDED_MARKER_SIZE = 20, 2.8


def draw_family(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    along: str,
    keys: Sequence[str],
    *,
    look: Look,
    unjoined: pd.Series | None = None,
    pitch: float = 0,
    spread: pd.Series | None = None,
) -> None:
    """Draw one curve per set of parameters, with 95 % intervals.

    Lines join filled and pale markers: those of steady points, and of runs too short to tell. A
    curve of the converged protocol is wide and pale and lies beside the published one with the same
    entry in the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    rows : pandas.DataFrame
        Points, as `sim.figures.data.summarize` returns them; those without a completed replicate
        are left out.
    quantity : Quantity
        The quantity to draw.
    along : str
        Column on the horizontal axis.
    keys : sequence of str
        As for `sim.figures.data.split_curves`.
    look : callable
        Returns style and legend entry from the values that name a curve, without its protocol.
    unjoined : pandas.Series, optional
        True in further rows where lines are interrupted.
    pitch : float
        Shift of each curve to the right of the previous one, in points of print. It separates
        points that coincide.
    spread : pandas.Series, optional
        Half widths of the 95 % intervals of ``along``, where that is an observable.
    """
    if rows.empty:
        return
    explain_markers(axes, rows)
    curves = split_curves(rows, along, keys, ())
    curves.sort(key=lambda curve: curve[1]["protocol"].iloc[0] != "published")
    labels, styles = labels_and_styles([names for names, _ in curves], look)
    shifts = {label: pitch * (n - (len(styles) - 1) / 2) for n, label in enumerate(styles)}
    drawn_labels: set[str] = set()
    for (_, curve), label in zip(curves, labels, strict=True):
        pale, style = label in drawn_labels, styles[label]
        artists = _draw_curve(axes, curve, quantity, along, style, unjoined, spread, pale=pale)
        move_aside(axes, artists, x=shifts[label])
        if artists and not pale:
            look_of_entry = {"linestyle": style.dashes, "marker": style.marker}
            axes.plot([], [], color=style.colour, label=label, **look_of_entry)
        drawn_labels.add(label)
    if any(one.get_markersize() == RING["markersize"] for one in axes.get_lines()):
        axes.plot([], [], label=RING_MEANS, **RING)
    if len(drawn_labels) < len(curves):
        name_protocols(axes, str(curves[0][1]["system"].iloc[0]))


def labels_and_styles(
    curves: Sequence[dict[str, Any]], look: Look
) -> tuple[list[str], dict[str, CurveStyle]]:
    """Return the legend entry of each curve, and the style of each entry.

    ``curves`` are the values that name each curve.
    """
    labels: list[str] = []
    styles: dict[str, CurveStyle] = {}
    for names in curves:
        parameters = {name: value for name, value in names.items() if name != "protocol"}
        style, label = look(parameters, len(styles))
        if label not in styles and style in styles.values():
            # These curves differ in a parameter that the paper's styles do not distinguish.
            style = cycle_style(len(styles) + len(MARKERS) // 2)
        styles.setdefault(label, style)
        labels.append(label)
    return labels, styles


def _draw_curve(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    along: str,
    style: CurveStyle,
    unjoined: pd.Series | None,
    spread: pd.Series | None,
    *,
    pale: bool,
) -> list[Artist]:
    """Draw the points of a curve, and its line; ``pale`` beside another one of the same style."""
    completed = rows[rows["completed"] > 0]
    artists: list[Artist] = []
    if completed.empty:
        return artists
    value, half = quantity.value[completed.index], quantity.half_width[completed.index]
    size = PALE_MARKER_SIZE if pale else None
    if style.dashes != "none":
        is_joined = (completed["regime"] == "steady") | is_undecided(completed)
        if unjoined is not None:
            is_joined &= ~unjoined[completed.index]
        line, wide = value.where(is_joined), PALE_LINE if pale else {}
        look: dict[str, Any] = {"color": style.colour, "linestyle": style.dashes} | wide
        artists += axes.plot(completed[along], line, **look)
        size = None
        if len(completed) > MOST_BARS:
            size = CROWDED_MARKER_SIZE
            band, is_banded = _draw_band(axes, completed[along], line, half, style)
            half = half.mask(is_banded)
            artists.append(band)
    widths = {"yerr": half} | ({} if spread is None else {"xerr": spread[completed.index]})
    alpha = PALE_LINE["alpha"] if pale else None
    artists += _draw_points(axes, completed, value, along, style, widths, size=size, alpha=alpha)
    is_single = value.notna() & quantity.half_width[completed.index].isna()
    if is_single.any() and quantity.half_width.notna().any():
        artists += axes.plot(completed[along][is_single], value[is_single], **RING)
    return artists


def _draw_band(
    axes: Axes, x: pd.Series, y: pd.Series, half: pd.Series, style: CurveStyle
) -> tuple[Artist, pd.Series]:
    """Draw a band of intervals where ``y`` and its neighbour are joined; return where that is."""
    is_known = y.notna() & half.notna()
    has_neighbour = is_known.shift(fill_value=False) | is_known.shift(-1, fill_value=False)
    where = is_known & has_neighbour
    look: dict[str, Any] = {"color": style.colour, "alpha": 0.2, "linewidth": 0, "zorder": 1.5}
    return axes.fill_between(x, y - half, y + half, where=where, **look), where


def _draw_points(
    axes: Axes,
    rows: pd.DataFrame,
    value: pd.Series,
    along: str,
    style: CurveStyle,
    widths: Mapping[str, pd.Series],
    *,
    size: float | None = None,
    alpha: float | None = None,
) -> list[Artist]:
    """Draw the markers of a curve, filled, pale or open, over their error bars; return them.

    ``widths`` are the half widths of the bars by the direction, ``yerr`` and ``xerr``.
    """
    artists: list[Artist] = []
    has_width = pd.DataFrame({name: width.notna() for name, width in widths.items()})
    # Points without an interval get no bar, instead of one of zero length.
    choices = product(faces(rows, style.colour), *[(True, False)] * len(widths))
    for (chosen, face), *has_widths in choices:
        part = rows[chosen & (has_width == has_widths).all(axis=1)]
        bars = axes.errorbar(
            part[along],
            value[part.index],
            **{name: widths[name][part.index] for name in compress(widths, has_widths)},
            linestyle="none",
            color=style.colour,
            marker=style.marker,
            markerfacecolor=face,
            markersize=size,
            markeredgewidth=1.0,
            elinewidth=0.9,
            alpha=alpha,
            zorder=3,
        )
        for part_of_bar in (*bars.lines[1], *bars.lines[2]):
            # Below the markers of all curves.
            part_of_bar.set_zorder(2.6)
        artists += bars.get_children()
    return artists
