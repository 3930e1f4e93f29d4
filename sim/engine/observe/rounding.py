"""Sums and products that round as numpy's do: compiled samples keep the bits of array arithmetic.

numpy adds up several numbers side by side, halves what is longer than a block, and rounds the
squares of an array of complex numbers once less than their other powers.
"""

import numpy as np
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import exact

#: Sums side by side of real numbers, and of the real or imaginary parts of complex ones.
REAL, COMPLEX = 8, 4

#: Longest part, in numbers per sum, that is added up without being halved; most halvings.
LENGTH, DEEPEST = 16, 48


@exact
def total(values, lanes):
    """Return the sum of values (N,) as ``np.sum`` adds them in so many ``lanes``."""
    # The turns taken from the whole to a part, right ones as bits that are set, and for each right
    # turn the sum of the left half.
    turns, depth, left = 0, 0, np.empty(DEEPEST)
    while True:
        first, size, level = 0, values.size, 0
        while level < depth or size > LENGTH * lanes:
            half = size // (2 * lanes) * lanes
            if level < depth and turns >> (depth - level - 1) & 1:
                first, size = first + half, size - half
            else:
                size = half
            level += 1
        turns, depth = turns << (level - depth), level
        if lanes == REAL:
            found = _in_eight_lanes(values, first, size)
        else:
            found = _in_four_lanes(values, first, size)
        while turns & 1:
            found = left[depth] + found
            turns, depth = turns >> 1, depth - 1
        if depth == 0:
            return found
        left[depth], turns = found, turns + 1


@exact
def _in_eight_lanes(values, first, size):
    if size < REAL:
        return _one_by_one(-0.0, values, first, first + size)
    a, b, c, d = values[first], values[first + 1], values[first + 2], values[first + 3]
    e, f, g, h = values[first + 4], values[first + 5], values[first + 6], values[first + 7]
    whole = first + size - size % REAL
    for k in range(first + REAL, whole, REAL):
        a, b, c, d = a + values[k], b + values[k + 1], c + values[k + 2], d + values[k + 3]
        e, f, g, h = e + values[k + 4], f + values[k + 5], g + values[k + 6], h + values[k + 7]
    found = ((a + b) + (c + d)) + ((e + f) + (g + h))
    return _one_by_one(found, values, whole, first + size)


@exact
def _in_four_lanes(values, first, size):
    if size < COMPLEX:
        return _one_by_one(-0.0, values, first, first + size)
    a, b, c, d = values[first], values[first + 1], values[first + 2], values[first + 3]
    whole = first + size - size % COMPLEX
    for k in range(first + COMPLEX, whole, COMPLEX):
        a, b, c, d = a + values[k], b + values[k + 1], c + values[k + 2], d + values[k + 3]
    return _one_by_one((a + b) + (c + d), values, whole, first + size)


@exact
def _one_by_one(found, values, first, last):
    for k in range(first, last):
        found += values[k]
    return found


@intrinsic
def fused(typingctx, one, other, added):
    """Return one · other + added, rounded once."""

    def codegen(context, builder, signature, args):
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), codegen


@exact
def square(one):
    """Return the square of a complex number as numpy rounds it in arrays."""
    real, imaginary = one
    return fused(real, real, -(imaginary * imaginary)), fused(real, imaginary, imaginary * real)


@exact
def product(one, other):
    """Return the product of two complex numbers, given and returned as pairs."""
    return one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]
