"""Curves of a quantity for sets of parameters, with intervals, regimes and protocols."""

from collections.abc import Sequence
from itertools import compress, product
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from sim.figures.data import split_curves
from sim.figures.quantity import Quantity
from sim.figures.style import (
    MARKERS,
    PALE,
    PALE_LINE,
    PALE_MARKER_SIZE,
    CurveStyle,
    Look,
    cycle_style,
    is_undecided,
    move_aside,
    name_protocols,
)


def draw_family(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    along: str,
    keys: Sequence[str],
    parameters: Sequence[str],
    *,
    look: Look,
    unjoined: pd.Series | None = None,
    pitch: float = 0,
    spread: pd.Series | None = None,
) -> None:
    """Draw one curve per set of parameters.

    A curve of the converged protocol is wide and pale and lies beside the published one with the
    same entry in the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    rows : pandas.DataFrame
        Points, as `sim.figures.data.summarize` returns them.
    quantity : Quantity
        The quantity to draw.
    along : str
        Column on the horizontal axis.
    keys, parameters : sequence of str
        As for `sim.figures.data.split_curves`.
    look : callable
        Returns style and legend entry from the values that name a curve, without its protocol.
    unjoined : pandas.Series, optional
        True in rows where lines are interrupted.
    pitch : float
        Shift of each curve to the right of the previous one, in points of print. It separates
        points that coincide.
    spread : pandas.Series, optional
        As for `draw_curve`.
    """
    if rows.empty:
        return
    curves = split_curves(rows, along, keys, parameters)
    curves.sort(key=lambda curve: curve[1]["protocol"].iloc[0] != "published")
    labels, styles = labels_and_styles([names for names, _ in curves], look)
    shifts = {label: pitch * (n - (len(styles) - 1) / 2) for n, label in enumerate(styles)}
    drawn_labels: set[str] = set()
    for (_, curve), label in zip(curves, labels, strict=True):
        options: dict[str, Any] = {
            "pale": label in drawn_labels,
            "shift": shifts[label],
            "spread": spread,
        }
        draw_curve(axes, curve, quantity, along, styles[label], label, unjoined=unjoined, **options)
        drawn_labels.add(label)
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


def draw_curve(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    along: str,
    style: CurveStyle,
    label: str,
    *,
    unjoined: pd.Series | None = None,
    pale: bool = False,
    shift: float = 0,
    spread: pd.Series | None = None,
) -> None:
    """Draw a quantity against a parameter, with 95 % intervals.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    rows : pandas.DataFrame
        Points of the curve, as `sim.figures.data.summarize` returns them. Points without a
        completed replicate are left out; markers of steady points are filled, those of runs too
        short to tell are pale, and all others are open.
    quantity : Quantity
        The quantity to draw.
    along : str
        Column on the horizontal axis.
    style : CurveStyle
        Look of the curve.
    label : str
        Its entry in the legend.
    unjoined : pandas.Series, optional
        True in rows where the line is interrupted.
    pale : bool
        Draw the curve pale, without an entry: another curve of the same style has the entry.
    shift : float
        Shift of the curve to the right, in points of print.
    spread : pandas.Series, optional
        Half widths of the 95 % intervals of ``along``, where that is an observable.
    """
    completed = rows[rows["completed"] > 0]
    if completed.empty:
        return
    artists: list[Artist] = []
    if style.dashes != "none":
        line = quantity.value[completed.index]
        if unjoined is not None:
            line = line.mask(unjoined[completed.index])
        artists += _draw_line(axes, completed[along], line, style, pale)
    artists += _draw_points(axes, completed, quantity, along, style, pale, spread)
    move_aside(axes, artists, x=shift)
    if not pale:
        _add_entry(axes, style, label)


def _draw_line(
    axes: Axes, x: pd.Series, y: pd.Series, style: CurveStyle, pale: bool
) -> Sequence[Artist]:
    """Draw the line of a curve, interrupted where ``y`` is not a number."""
    pale_look: dict[str, Any] = PALE_LINE if pale else {}
    return axes.plot(x, y, color=style.colour, linestyle=style.dashes, **pale_look)


def _add_entry(axes: Axes, style: CurveStyle, label: str) -> None:
    """Add an entry to the legend without drawing a curve."""
    axes.plot([], [], color=style.colour, linestyle=style.dashes, marker=style.marker, label=label)


def _draw_points(
    axes: Axes,
    rows: pd.DataFrame,
    quantity: Quantity,
    along: str,
    style: CurveStyle,
    pale: bool,
    spread: pd.Series | None = None,
) -> list[Artist]:
    """Draw the markers of a curve, filled, pale or open, with their error bars; return them."""
    artists: list[Artist] = []
    is_unjoined = pale and style.dashes == "none"
    is_open = is_undecided(rows)
    steady = (rows["regime"] == "steady") & ~is_open
    faces = (
        (steady, style.colour),
        (is_open, (*to_rgb(style.colour), PALE)),
        (~(steady | is_open), "white"),
    )
    widths = {"yerr": quantity.half_width} | ({} if spread is None else {"xerr": spread})
    has_width = pd.DataFrame({name: width[rows.index].notna() for name, width in widths.items()})
    # Points without an interval get no bar, instead of one of zero length.
    for (chosen, face), *has_widths in product(faces, *[(True, False)] * len(widths)):
        part = rows[chosen & (has_width == has_widths).all(axis=1)]
        bars = axes.errorbar(
            part[along],
            quantity.value[part.index],
            **{name: widths[name][part.index] for name in compress(widths, has_widths)},
            linestyle="none",
            color=style.colour,
            marker=style.marker,
            markerfacecolor=face,
            markersize=PALE_MARKER_SIZE if is_unjoined else None,
            markeredgewidth=1.0,
            elinewidth=0.9,
            alpha=PALE_LINE["alpha"] if pale else None,
            zorder=3,
        )
        artists += bars.get_children()
    return artists
