"""Curves of mean velocity that differ in parameters, both protocols side by side."""

from collections.abc import Callable, Sequence

import pandas as pd
from matplotlib.axes import Axes

from sim.figures.style import MARKERS, CurveStyle, Unjoined, cycled, draw_curve, name_protocols
from sim.figures.summary import split_curves

#: Gives style and legend entry of a curve from the values that name it and its number.
Look = Callable[[dict[str, object], int], tuple[CurveStyle, str]]


def draw_family(
    axes: Axes,
    rows: pd.DataFrame,
    along: str,
    keys: Sequence[str],
    parameters: Sequence[str],
    look: Look,
    unjoined: Unjoined | None = None,
    pitch: float = 0,
) -> None:
    """Draw one curve per set of parameters.

    A curve of the converged protocol lies, wide and pale, beside the published one with the same
    entry in the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    rows : pandas.DataFrame
        Points, as `sim.figures.summary.summarize` returns them.
    along : str
        Parameter on the horizontal axis.
    keys, parameters : sequence of str
        As for `sim.figures.summary.split_curves`.
    look : callable
        Gives style and legend entry from all values that name a curve but its protocol.
    unjoined : callable, optional
        Says of rows at which of them lines are interrupted.
    pitch : float
        How far each curve is drawn to the right of the one before, in points of print, so that
        points that coincide can be told apart.
    """
    curves = split_curves(rows, along, keys, parameters)
    curves.sort(key=lambda curve: curve[1]["protocol"].iloc[0] != "published")
    styles: dict[str, CurveStyle] = {}
    drawn = []
    for names, curve in curves:
        named = {name: value for name, value in names.items() if name != "protocol"}
        style, label = look(named, len(styles))
        pale = label in styles
        if not pale and style in styles.values():
            # Another parameter tells these curves apart, which the paper's styles do not know.
            style = cycled(len(styles) + len(MARKERS) // 2)
        styles.setdefault(label, style)
        drawn.append((curve, label, pale))
    shifts = {label: pitch * (n - (len(styles) - 1) / 2) for n, label in enumerate(styles)}
    for curve, label, pale in drawn:
        draw_curve(axes, curve, along, styles[label], label, unjoined, pale, shifts[label])
    if any(pale for _, _, pale in drawn):
        name_protocols(axes)
