"""Ticks at the values of a parameter that were run, each with a number that can be read."""

from collections.abc import Collection, Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, NullFormatter

#: Inches that a digit and a line of a tick label take, and the least between two labels.
_DIGIT, _LINE, _GAP = 0.08, 0.125, 0.05

#: Size of small labels, points, and of usual ones.
_SMALL, _USUAL = 7.5, 9.0


def set_ticks(
    axes: Axes,
    values: Iterable[float],
    length: float,
    *,
    vertical: bool = False,
    first: Collection[float] = (),
) -> None:
    """Put a tick at each value, with a number wherever there is room for one.

    Numbers along the axis or, where they would touch, across it. Values too dense even for that
    have ticks without numbers, of which there are as few as can be.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Whose scale is set and whose limits are final.
    values : iterable of float
        The values.
    length : float
        Length of the axis, about, inches.
    vertical : bool
        Whether it is the vertical axis.
    first : collection of float
        Values that have numbers before all others, which are then never across the axis.
    """
    axis: Axis = axes.yaxis if vertical else axes.xaxis
    every = sorted(set(values))
    labels = [f"{value:g}" for value in every]
    places = length * _fractions(axis, every)
    across = 0 if vertical else 90
    ways = [(vertical, 0, _USUAL), (True, across, _USUAL), (True, across, _SMALL)]
    for way in ways[:1] if first else ways:
        stacked, angle, size = way
        wide = [(_LINE if stacked else _width(label) + _GAP) * size / _USUAL for label in labels]
        named = _readable(places, wide, [every.index(one) for one in every if one in first])
        if len(named) == len(every):
            break
    axis.set_major_locator(FixedLocator([every[index] for index in named]))
    axis.set_minor_locator(FixedLocator(sorted(set(every) - {every[index] for index in named})))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
    axis.set_tick_params(labelrotation=angle, labelsize=size)


def _width(label: str) -> float:
    """Return the width of a label, inches; a point takes half of what a digit does."""
    return _DIGIT * (len(label) - 0.5 * label.count("."))


def _fractions(axis: Axis, values: Sequence[float]) -> np.ndarray:
    """Return where values lie between the ends of an axis, from 0 to 1."""
    low, high = axis.get_view_interval()
    transform = axis.get_transform().transform
    start, end = transform(np.array([low, high], float))
    return np.abs((transform(np.asarray(values, float)) - start) / (end - start))


def _readable(places: np.ndarray, widths: Sequence[float], first: Sequence[int]) -> list[int]:
    """Return which labels can stand without touching: some first, the ends, then from the left."""
    found: list[int] = []
    for index in dict.fromkeys((*first, len(places) - 1, *range(len(places)))):
        if all(
            abs(places[index] - places[other]) >= (widths[index] + widths[other]) / 2
            for other in found
        ):
            found.append(index)
    return sorted(found)
