"""Curves of a quantity that differ in parameters, with its intervals, regimes and protocols."""

from collections.abc import Sequence
from itertools import compress, product
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from sim.figures.data import split_curves
from sim.figures.looks import Look
from sim.figures.quantity import Quantity
from sim.figures.style import (
    BESIDE,
    LONE_BESIDE,
    MARKERS,
    PALE,
    CurveStyle,
    cycled,
    move_aside,
    name_protocols,
    undecided,
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

    A curve of the converged protocol lies, wide and pale, beside the published one with the same
    entry in the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    rows : pandas.DataFrame
        Points, as `sim.figures.data.summarize` returns them.
    quantity : Quantity
        What is drawn of them.
    along : str
        Column on the horizontal axis.
    keys, parameters : sequence of str
        As for `sim.figures.data.split_curves`.
    look : callable
        Gives style and legend entry from all values that name a curve but its protocol.
    unjoined : pandas.Series, optional
        Says of each row whether lines are interrupted there.
    pitch : float
        How far each curve is drawn to the right of the one before, in points of print, so that
        points that coincide can be told apart.
    spread : pandas.Series, optional
        As for `draw_curve`.
    """
    if rows.empty:
        return
    curves = split_curves(rows, along, keys, parameters)
    curves.sort(key=lambda curve: curve[1]["protocol"].iloc[0] != "published")
    labels, styles = _labelled([names for names, _ in curves], look)
    shifts = {label: pitch * (n - (len(styles) - 1) / 2) for n, label in enumerate(styles)}
    seen: set[str] = set()
    for (_, curve), label in zip(curves, labels, strict=True):
        how: dict[str, Any] = {"pale": label in seen, "shift": shifts[label], "spread": spread}
        draw_curve(axes, curve, quantity, along, styles[label], label, unjoined=unjoined, **how)
        seen.add(label)
    if len(seen) < len(curves):
        name_protocols(axes, str(curves[0][1]["system"].iloc[0]))


def _labelled(
    curves: Sequence[dict[str, Any]], look: Look
) -> tuple[list[str], dict[str, CurveStyle]]:
    """Return the legend entry of each curve, given the values that name it, and their styles."""
    labels: list[str] = []
    styles: dict[str, CurveStyle] = {}
    for names in curves:
        named = {name: value for name, value in names.items() if name != "protocol"}
        style, label = look(named, len(styles))
        if label not in styles and style in styles.values():
            # Another parameter tells these curves apart, which the paper's styles do not know.
            style = cycled(len(styles) + len(MARKERS) // 2)
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
        What is drawn of them.
    along : str
        Column on the horizontal axis.
    style : CurveStyle
        Look of the curve.
    label : str
        Its entry in the legend.
    unjoined : pandas.Series, optional
        Says of each row whether the line is interrupted there.
    pale : bool
        Draw it beside another curve of the same style, which has the entry in the legend.
    shift : float
        How far to the right of its place it is drawn, in points of print.
    spread : pandas.Series, optional
        Half widths of the 95 % intervals of ``along``, where that is no parameter but observed.
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
    beside: dict[str, Any] = BESIDE if pale else {}
    return axes.plot(x, y, color=style.colour, linestyle=style.dashes, **beside)


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
    lone = pale and style.dashes == "none"
    unknown = undecided(rows)
    steady = (rows["regime"] == "steady") & ~unknown
    faces = (
        (steady, style.colour),
        (unknown, (*to_rgb(style.colour), PALE)),
        (~(steady | unknown), "white"),
    )
    widths = {"yerr": quantity.half_width} | ({} if spread is None else {"xerr": spread})
    known = pd.DataFrame({name: each[rows.index].notna() for name, each in widths.items()})
    # Where no interval is known there is no bar, not one of no length.
    for (chosen, face), *has in product(faces, *[(True, False)] * len(widths)):
        part = rows[chosen & (known == has).all(axis=1)]
        bars = axes.errorbar(
            part[along],
            quantity.value[part.index],
            **{name: widths[name][part.index] for name in compress(widths, has)},
            linestyle="none",
            color=style.colour,
            marker=style.marker,
            markerfacecolor=face,
            markersize=LONE_BESIDE if lone else None,
            markeredgewidth=1.0,
            elinewidth=0.9,
            alpha=BESIDE["alpha"] if pale else None,
            zorder=3,
        )
        artists += bars.get_children()
    return artists
