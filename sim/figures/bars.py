"""Limits of axes for error bars that exceed the range of the values, and carets on cut bars."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.markers import CARETDOWN, CARETLEFT, CARETRIGHT, CARETUP

#: Room around the values for their intervals, relative to the range of the values.
_MARGIN = 0.6


def limit_axis(axes: Axes, axis: str, values: pd.Series) -> None:
    """Limit an axis to a margin around the values: intervals of two replicates may be very wide.

    ``axis`` is ``"x"`` or ``"y"`` and must not be logarithmic.
    """
    if values.empty:
        return
    least, most = _axis_limits(values)
    low, high = getattr(axes, f"get_{axis}lim")()
    getattr(axes, f"set_{axis}lim")(max(low, least), min(high, most))


def _axis_limits(values: pd.Series) -> tuple[float, float]:
    """Return the lowest and the highest limit of a linear axis around values."""
    low, high = values.min(), values.max()
    room = _MARGIN * (high - low or abs(high) or 1.0)
    return max(low - room, 0.0) if low >= 0 else low - room, high + room


def has_cut_bars(
    values: pd.Series, half_widths: pd.Series, others: pd.Series, *, logarithmic: bool
) -> bool:
    """Return whether an error bar leaves the axes, where `mark_cut_bars` puts a caret.

    ``others`` are further coordinates on the axis, of foreign data.
    """
    if values.empty:
        return False
    half = half_widths.fillna(0)
    lowest, highest = (values - half).min(), (values + half).max()
    if logarithmic:
        return bool(lowest <= 0)
    least, most = _axis_limits(pd.concat([values, others]))
    return bool(lowest < least or highest > most)


def mark_cut_bars(axes: Axes) -> None:
    """Put a caret on the edge where an error bar leaves the axes; their limits must be final."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    error_bars = (bars.lines for bars in axes.containers if isinstance(bars, ErrorbarContainer))
    for points, _, bars in error_bars:
        for (x, y), (far, high) in (ends for part in bars for ends in part.get_segments()):
            ends = [(y < bottom, x, bottom, CARETDOWN), (high > top, x, top, CARETUP)]
            if far > x:
                ends = [(x < left, left, y, CARETLEFT), (far > right, right, y, CARETRIGHT)]
            for is_cut, *place, caret in ends:
                if is_cut:
                    look: dict[str, Any] = {"marker": caret, "color": points.get_color()}
                    (mark,) = axes.plot(*place, **look, scalex=False, scaley=False)
                    mark.set_transform(points.get_transform())
