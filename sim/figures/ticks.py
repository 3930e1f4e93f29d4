"""Ticks at the values of a parameter that were run, with numbers that do not touch."""

from collections.abc import Collection, Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, NullFormatter

#: Width of a digit, height of a line, and least gap between two tick labels, inches.
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
    first : collection of float
        Values whose numbers have priority. If given, numbers always lie along the axis.
    """
    axis: Axis = axes.yaxis if vertical else axes.xaxis
    distinct = sorted(set(values))
    labels = [f"{value:g}" for value in distinct]
    places = length * _fractions(axis, distinct)
    across = 0 if vertical else 90
    layouts = [(vertical, 0, _USUAL), (True, across, _USUAL), (True, across, _SMALL)]
    for layout in layouts[:1] if first else layouts:
        stacked, angle, size = layout
        widths = [(_LINE if stacked else _width(label) + _GAP) * size / _USUAL for label in labels]
        labelled = _readable_labels(
            places, widths, [distinct.index(value) for value in distinct if value in first]
        )
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


def _readable_labels(
    places: np.ndarray, widths: Sequence[float], first: Sequence[int]
) -> list[int]:
    """Return the indices of labels that do not touch.

    Those in ``first`` have priority, then the last, then all from the left.
    """
    chosen: list[int] = []
    for index in dict.fromkeys((*first, len(places) - 1, *range(len(places)))):
        if all(
            abs(places[index] - places[other]) >= (widths[index] + widths[other]) / 2
            for other in chosen
        ):
            chosen.append(index)
    return sorted(chosen)
