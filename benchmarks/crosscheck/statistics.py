"""Means, their intervals, and whether two of them agree."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sim.base.statistics import student_half_width

#: Relative difference within which the engines agree whatever the intervals.
TOLERANCE = 0.03

#: Share of the mass that a slice must hold to be compared.
SMALLEST_SHARE = 0.01

#: Replicates below which their scatter says nothing.
FEWEST = 3


class Estimate(NamedTuple):
    """A mean and the half width of its 95 % interval, numbers or arrays alike."""

    mean: np.ndarray
    half_width: np.ndarray


def estimate(blocks: np.ndarray) -> Estimate:
    """Return the mean of block means (R, B, ...) over replicates and blocks.

    The interval is the wider one of those over all blocks and over the means of the replicates: the
    first misses what a replicate keeps for longer than a block, the second is rough with few of
    them, and left out with fewer than three.
    """
    replicates, number = blocks.shape[:2]
    width = student_half_width(blocks.reshape(replicates * number, *blocks.shape[2:]))
    if replicates >= FEWEST:
        width = np.maximum(width, student_half_width(blocks.mean(axis=1)))
    return Estimate(blocks.mean(axis=(0, 1)), width)


def ratio(a: Estimate, b: Estimate) -> Estimate:
    """Return a over b, the intervals combined as independent ones."""
    quotient = a.mean / b.mean
    relative = np.hypot(a.half_width / a.mean, b.half_width / b.mean)
    return Estimate(quotient, abs(quotient) * relative)


def pooled(estimates: Sequence[Estimate]) -> Estimate:
    """Return the mean of independent estimates of one number, weighted by their intervals."""
    mean, width = (np.array(values) for values in zip(*estimates, strict=True))
    weight = width**-2.0
    return Estimate((weight * mean).sum() / weight.sum(), weight.sum() ** -0.5)


def agree(a: Estimate, b: Estimate, scale: float) -> np.ndarray:
    """Return where a and b differ by no more than the tolerance of ``scale`` or their interval."""
    combined = np.hypot(a.half_width, b.half_width)
    return np.abs(a.mean - b.mean) <= np.maximum(TOLERANCE * scale, combined)


def compared(packing: np.ndarray) -> np.ndarray:
    """Return which slices of a mean profile of packing fractions hold enough of the mass."""
    return packing > SMALLEST_SHARE * packing.sum()
