"""Sums that round like numpy's, so that compiled code keeps the bits of arrays; energies of all.

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


@exact
def bed_energies(taylor, mass, time_step, amplitude):
    """Return kinetic energy, height and share near the belt of all beads at one moment.

    Parameters
    ----------
    taylor : (6, 2, N) array
        Taylor terms of the positions, see ``Disks``.
    mass : (N,) array
        Masses of the beads (kg).
    time_step : float
        Time step of the Taylor terms (s).
    amplitude : float
        Vertical amplitude of the belt (m).

    Returns
    -------
    tuple of 3 floats
        Kinetic energy (J), height of the centre of mass (m), share of beads whose centres are
        within an amplitude of the mean belt position.
    """
    near, terms, sums = 0, np.empty((3, mass.size)), np.empty(3)
    for i in range(mass.size):
        vx, vz, z = taylor[1, 0, i] / time_step, taylor[1, 1, i] / time_step, taylor[0, 1, i]
        terms[0, i], terms[1, i] = mass[i] * (vx * vx + vz * vz), z * mass[i]
        terms[2, i] = mass[i]
        near += abs(z) < amplitude
    for k in range(3):
        sums[k] = total(terms[k], REAL)
    return 0.5 * sums[0], sums[1] / sums[2], near / mass.size


@exact
def flow_energies(position, velocity, rim, mass):
    """Return kinetic energies and height of all spheres at one moment.

    Parameters
    ----------
    position, velocity, rim : (3, N) arrays
        See ``Spheres`` (m, m/s).
    mass : (N,) array
        Masses of the spheres (kg).

    Returns
    -------
    tuple of 3 floats
        Twice the kinetic energy of translation (J), the sum of mass times the square of ``rim``
        (J), height of the centre of mass (m).
    """
    terms, sums = np.empty((4, mass.size)), np.empty(4)
    for i in range(mass.size):
        vx, vy, vz = velocity[0, i], velocity[1, i], velocity[2, i]
        wx, wy, wz = rim[0, i], rim[1, i], rim[2, i]
        terms[0, i] = mass[i] * (vx * vx + vy * vy + vz * vz)
        terms[1, i] = mass[i] * (wx * wx + wy * wy + wz * wz)
        terms[2, i], terms[3, i] = position[2, i] * mass[i], mass[i]
    for k in range(4):
        sums[k] = total(terms[k], REAL)
    return sums[0], sums[1], sums[2] / sums[3]
