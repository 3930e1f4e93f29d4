"""Sums and products that round like numpy's, so that compiled code keeps the bits of arrays.

numpy adds several partial sums in parallel and halves arrays longer than a block. It rounds the
squares of an array of complex numbers once less than other powers.
"""

import numpy as np
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import exact

#: Number of parallel partial sums for real numbers, and for real or imaginary parts.
REAL, COMPLEX = 8, 4

#: Longest part, in numbers per partial sum, that is not halved; largest number of halvings.
LENGTH, DEEPEST = 16, 48


@exact
def total(values, lanes):
    """Return the sum of values (N,) as ``np.sum`` adds them in ``lanes`` partial sums."""
    # The path from the whole to a part: a set bit for each turn to the right, and for each of them
    # the sum of the left half.
    turns, depth, left_sums = 0, 0, np.empty(DEEPEST)
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
            part = _sum_eight_lanes(values, first, size)
        else:
            part = _sum_four_lanes(values, first, size)
        while turns & 1:
            part = left_sums[depth] + part
            turns, depth = turns >> 1, depth - 1
        if depth == 0:
            return part
        left_sums[depth], turns = part, turns + 1


@exact
def _sum_eight_lanes(values, first, size):
    if size < REAL:
        return _add_in_order(-0.0, values, first, first + size)
    a, b, c, d = values[first], values[first + 1], values[first + 2], values[first + 3]
    e, f, g, h = values[first + 4], values[first + 5], values[first + 6], values[first + 7]
    whole = first + size - size % REAL
    for k in range(first + REAL, whole, REAL):
        a, b, c, d = a + values[k], b + values[k + 1], c + values[k + 2], d + values[k + 3]
        e, f, g, h = e + values[k + 4], f + values[k + 5], g + values[k + 6], h + values[k + 7]
    part = ((a + b) + (c + d)) + ((e + f) + (g + h))
    return _add_in_order(part, values, whole, first + size)


@exact
def _sum_four_lanes(values, first, size):
    if size < COMPLEX:
        return _add_in_order(-0.0, values, first, first + size)
    a, b, c, d = values[first], values[first + 1], values[first + 2], values[first + 3]
    whole = first + size - size % COMPLEX
    for k in range(first + COMPLEX, whole, COMPLEX):
        a, b, c, d = a + values[k], b + values[k + 1], c + values[k + 2], d + values[k + 3]
    return _add_in_order((a + b) + (c + d), values, whole, first + size)


@exact
def _add_in_order(part, values, first, last):
    for k in range(first, last):
        part += values[k]
    return part


@intrinsic
def fused_multiply_add(typingctx, a, b, c):
    """Return a · b + c, rounded once."""

    def codegen(context, builder, signature, args):
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), codegen


@exact
def square(number):
    """Return the square of a complex number, a pair, as numpy rounds it in arrays."""
    real, imaginary = number
    return fused_multiply_add(real, real, -(imaginary * imaginary)), fused_multiply_add(
        real, imaginary, imaginary * real
    )


@exact
def product(a, b):
    """Return the product of two complex numbers; all three are pairs."""
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]
