"""Scales, ticks and limits of axes, and carets on the error bars that they cut."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.markers import CARETDOWN, CARETLEFT, CARETRIGHT, CARETUP
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

#: Ratio of the ends of a logarithmic axis from which only powers of ten have ticks.
_DECADES_FROM = 300

#: Width of a digit, height of a line, and least gap between two tick labels, inches.
_DIGIT, _LINE, _GAP = 0.08, 0.125, 0.05

#: Size of small labels, points, and of usual ones.
_SMALL, _USUAL = 7.5, 9.0

#: Room around the values for their intervals, relative to the range of the values.
_MARGIN = 0.6

#: Room beyond the values on a logarithmic axis, how far bars may extend it, and room of a cap, as
#: factors.
_BEYOND, _REACH, _END = 1.4, 10.0, 1.05

#: No values.
NONE = pd.Series(dtype=float)

#: How far bars may extend an axis beyond this room, and the room of a cap, relative to the range.
_EXTENSION, _CAP = 0.4, 0.02


def set_log(axes: Axes, axis: str) -> None:
    """Make the axis ``"x"`` or ``"y"`` logarithmic, with plain numbers at its ticks."""
    getattr(axes, f"set_{axis}scale")("log")
    set_plain_ticks(axes.xaxis if axis == "x" else axes.yaxis)


def set_plain_ticks(axis: Axis) -> None:
    """Put plain numbers at the ticks of a logarithmic axis, powers of ten where they are long."""
    axis.set_major_locator(_Steps())
    axis.set_major_formatter(lambda value, _: _plain(value))
    axis.set_minor_formatter(NullFormatter())


def _plain(value: float) -> str:
    """Write the number at a tick.

    >>> _plain(0.5), _plain(1e-5), _plain(2e6)
    ('0.5', '$10^{-5}$', '$2×10^{6}$')
    """
    mantissa, exponent, power = f"{value:g}".partition("e")
    if not exponent:
        return mantissa
    return f"${'' if mantissa == '1' else mantissa + '×'}10^{{{int(power)}}}$"


class _Steps(LogLocator):
    """Ticks at 1, 2 and 5 times each power of ten; over many powers at the powers alone."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        self.set_params(subs=(1, 2, 5) if vmax < _DECADES_FROM * vmin else (1,))
        return super().tick_values(vmin, vmax)


def set_ticks(
    axes: Axes,
    values: Iterable[float],
    length: float,
    *,
    vertical: bool = False,
) -> None:
    """Put a tick at each value, with a number wherever there is room for one.

    Numbers lie along the axis or, where they would touch, across it. As few ticks as possible have
    no number.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The axes; their scale and their limits must be final.
    values : iterable of float
        The values.
    length : float
        Approximate length of the axis, inches.
    vertical : bool
        Whether it is the vertical axis.
    """
    axis: Axis = axes.yaxis if vertical else axes.xaxis
    distinct = sorted(set(values))
    labels = [f"{value:g}" for value in distinct]
    places = length * _fractions(axis, distinct)
    across = 0 if vertical else 90
    layouts = [(vertical, 0, _USUAL), (True, across, _USUAL), (True, across, _SMALL)]
    for layout in layouts:
        stacked, angle, size = layout
        widths = [(_LINE if stacked else _width(label) + _GAP) * size / _USUAL for label in labels]
        labelled = _readable_labels(places, widths)
        if len(labelled) == len(distinct):
            break
    axis.set_major_locator(FixedLocator([distinct[index] for index in labelled]))
    axis.set_minor_locator(
        FixedLocator(sorted(set(distinct) - {distinct[index] for index in labelled}))
    )
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
    axis.set_tick_params(labelrotation=angle, labelsize=size)


def _width(label: str) -> float:
    """Return the width of a label, inches; a point is half as wide as a digit."""
    return _DIGIT * (len(label) - 0.5 * label.count("."))


def _fractions(axis: Axis, values: Sequence[float]) -> np.ndarray:
    """Return the positions of values on an axis, from 0 to 1."""
    low, high = axis.get_view_interval()
    transform = axis.get_transform().transform
    start, end = transform(np.array([low, high], float))
    return np.abs((transform(np.asarray(values, float)) - start) / (end - start))


def _readable_labels(places: np.ndarray, widths: Sequence[float]) -> list[int]:
    """Return the indices of labels that do not touch: the last, then all from the left."""
    chosen: list[int] = []
    for index in dict.fromkeys((len(places) - 1, *range(len(places)))):
        if all(
            abs(places[index] - places[other]) >= (widths[index] + widths[other]) / 2
            for other in chosen
        ):
            chosen.append(index)
    return sorted(chosen)


def limit_axis(
    axes: Axes,
    axis: str,
    values: pd.Series,
    half_widths: pd.Series = NONE,
    others: pd.Series = NONE,
    *,
    logarithmic: bool = False,
) -> None:
    """Limit an axis to a margin around the values: intervals of two replicates may be very wide.

    ``axis`` is ``"x"`` or ``"y"``. ``others`` are further coordinates on it, of foreign data.
    """
    if not (values.notna().any() or others.notna().any()):
        return
    least, most = _axis_limits(values, half_widths, others, logarithmic)
    low, high = getattr(axes, f"get_{axis}lim")()
    getattr(axes, f"set_{axis}lim")(max(low, least), min(high, most))


def _axis_limits(
    values: pd.Series, half_widths: pd.Series, others: pd.Series, logarithmic: bool
) -> tuple[float, float]:
    """Return the lowest and the highest limit of an axis.

    It has a margin around values, and bars that go a little beyond it extend it.
    """
    known, half = pd.concat([values, others]), half_widths.fillna(0)
    low, high = known.min(), known.max()
    if logarithmic:
        lowest, highest = values - half, values + half
        lowest, highest = lowest[lowest >= low / _REACH], highest[highest <= high * _REACH]
        return min([low / _BEYOND, *lowest / _END]), max([high * _BEYOND, *highest * _END])
    size = high - low or abs(high) or 1.0
    least, most = low - _MARGIN * size, high + _MARGIN * size
    least = max(least, 0.0) if low >= 0 else least
    lowest, highest, room = values - half, values + half, _EXTENSION * size
    lowest, highest = lowest[lowest >= least - room], highest[highest <= most + room]
    # The cap at the end of a bar is whole.
    return min([least, *lowest - _CAP * size]), max([most, *highest + _CAP * size])


def has_cut_bars(
    values: pd.Series, half_widths: pd.Series, others: pd.Series, *, logarithmic: bool
) -> bool:
    """Return whether an error bar leaves the axes, where `mark_cut_bars` puts a caret.

    The arguments are those of `limit_axis`.
    """
    if values.empty:
        return False
    half = half_widths.fillna(0)
    lowest, highest = (values - half).min(), (values + half).max()
    least, most = _axis_limits(values, half_widths, others, logarithmic)
    return bool(lowest < least or highest > most)


def mark_cut_bars(axes: Axes) -> None:
    """Put a caret on the edge where an error bar leaves the axes; their limits must be final."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    containers = (bars for bars in axes.containers if isinstance(bars, ErrorbarContainer))
    for bars in (part for container in containers for part in container.lines[2]):
        for (x, y), (far, high) in bars.get_segments():
            ends = [(y < bottom, x, bottom, CARETDOWN), (high > top, x, top, CARETUP)]
            if far > x:
                ends = [(x < left, left, y, CARETLEFT), (far > right, right, y, CARETRIGHT)]
            for is_cut, *place, caret in ends:
                if is_cut:
                    look: dict[str, Any] = {
                        "marker": caret,
                        "color": to_hex(np.asarray(bars.get_color())[0]),
                    }
                    (mark,) = axes.plot(*place, **look, scalex=False, scaley=False)
                    mark.set_transform(bars.get_transform())
