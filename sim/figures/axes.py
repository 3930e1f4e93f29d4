"""Scales and limits of axes."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter

#: Ratio of the ends of a logarithmic axis from which only powers of ten have ticks.
_DECADES_FROM = 300

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
    places, half = pd.concat([values, others]), half_widths.fillna(0)
    low, high = places.min(), places.max()
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
