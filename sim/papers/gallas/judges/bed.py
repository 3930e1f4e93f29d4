"""Shape of a bed of beads, from its profiles over height.

Profiles are arrays (H,) over slices of equal height, from the belt upwards; heights are the centres
of the slices in m. ``number`` is the number density; shares of the beads count from below.
"""

from math import nan

import numpy as np

#: Largest share of the beads of a mean that may be in slices without a value.
MAX_WITHOUT_VALUE = 0.01


def beads_between(number: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return per slice the share of all beads that lies between two cumulative shares."""
    below = np.concatenate([[0.0], np.cumsum(number)]) / number.sum()
    return np.clip(np.minimum(below[1:], high) - np.maximum(below[:-1], low), 0.0, None)


def mean_between(values: np.ndarray, number: np.ndarray, low: float, high: float) -> float:
    """Return the mean of a profile over the beads between two cumulative shares.

    A slice that few beads ever entered may have no value: one sample has no variance, for example.
    Such a slice is left out. The result is not-a-number where more than `MAX_WITHOUT_VALUE` of
    these beads are in such slices.
    """
    weight = beads_between(number, low, high)
    has_value = (weight > 0) & np.isfinite(values)
    if weight[has_value].sum() < (1 - MAX_WITHOUT_VALUE) * weight.sum():
        return nan
    return float(np.average(values[has_value], weights=weight[has_value]))


def height_spread(height: np.ndarray, number: np.ndarray) -> float:
    """Return the standard deviation (m) of the beads' heights."""
    mean = np.average(height, weights=number)
    return float(np.sqrt(np.average((height - mean) ** 2, weights=number)))


def peak_density(height: np.ndarray, number: np.ndarray) -> float:
    """Return the largest number density (m⁻²)."""
    return float(number.max())


def layer_width(height: np.ndarray, number: np.ndarray) -> float:
    """Return the width (m) of the layer: where the density exceeds half of its largest value.

    If the lowest slice exceeds it, the layer begins at the belt.
    """
    half = 0.5 * number.max()
    inside = np.flatnonzero(number >= half)
    first, last = int(inside[0]), int(inside[-1])
    begin = height[0] - 0.5 * (height[1] - height[0])
    if first:
        begin = np.interp(half, number[first - 1 : first + 1], height[first - 1 : first + 1])
    end = height[-1]
    if last < height.size - 1:
        end = np.interp(-half, -number[last : last + 2], height[last : last + 2])
    return float(end - begin)


def half_height(height: np.ndarray, number: np.ndarray) -> float:
    """Return the height (m) at which the density falls to half of its mean over the bed.

    The mean over the bed is taken between a fifth and four fifths of the beads.
    """
    half = 0.5 * mean_between(number, number, 0.2, 0.8)
    last = int(np.flatnonzero(number >= half)[-1])
    if last == height.size - 1:
        return float(height[-1])
    return float(np.interp(-half, -number[last : last + 2], height[last : last + 2]))
