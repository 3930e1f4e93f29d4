"""Error bars that need more room than the values do: where axes end, and carets on their edges."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.markers import CARETDOWN, CARETLEFT, CARETRIGHT, CARETUP

#: Room around the values for their intervals, in parts of the range of the values.
_ROOM = 0.6


def end_bars(axes: Axes, axis: str, values: pd.Series) -> None:
    """Let no interval take more room than the values do: of two replicates it may be very wide.

    ``axis``, ``"x"`` or ``"y"``, is the one that the values are on, which is not logarithmic.
    """
    if values.empty:
        return
    least, most = _ends(values)
    low, high = getattr(axes, f"get_{axis}lim")()
    getattr(axes, f"set_{axis}lim")(max(low, least), min(high, most))


def _ends(values: pd.Series) -> tuple[float, float]:
    """Return how far an axis that is not logarithmic goes at most below and above values."""
    low, high = values.min(), values.max()
    room = _ROOM * (high - low or abs(high) or 1.0)
    return max(low - room, 0.0) if low >= 0 else low - room, high + room


def cuts(
    values: pd.Series, half_widths: pd.Series, others: pd.Series, *, logarithmic: bool
) -> bool:
    """Return whether an error bar leaves the axes, where `mark_cut_bars` puts a caret.

    ``others`` are what else has its place on the axis.
    """
    if values.empty:
        return False
    half = half_widths.fillna(0)
    lowest, highest = (values - half).min(), (values + half).max()
    if logarithmic:
        return bool(lowest <= 0)
    least, most = _ends(pd.concat([values, others]))
    return bool(lowest < least or highest > most)


def mark_cut_bars(axes: Axes) -> None:
    """Put a caret on the edge where an error bar leaves the axes, whose limits are then final."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    drawn = (bars.lines for bars in axes.containers if isinstance(bars, ErrorbarContainer))
    for points, _, bars in drawn:
        for (x, y), (far, high) in (ends for part in bars for ends in part.get_segments()):
            ends = [(y < bottom, x, bottom, CARETDOWN), (high > top, x, top, CARETUP)]
            if far > x:
                ends = [(x < left, left, y, CARETLEFT), (far > right, right, y, CARETRIGHT)]
            for cut, *place, caret in ends:
                if cut:
                    look: dict[str, Any] = {"marker": caret, "color": points.get_color()}
                    (mark,) = axes.plot(*place, **look, scalex=False, scaley=False)
                    mark.set_transform(points.get_transform())
