"""Profiles over height, and the histogram of the overlaps of contacts, as sums over samples.

A particle has an exact share in each slice that it crosses; velocities have moments.
"""

from math import acos, ceil, cos, log10, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import exact, inlined, kernel
from sim.engine.dynamics.spheres import Spheres, nearest_separation

# The share of a particle in a slice: of its volume, of its area, or all of it by its centre.
VOLUME, AREA, CENTRE = range(3)


class Profile(NamedTuple):
    """Sums over samples, one row per slice.

    ``samples`` (1,) number of samples; ``weight`` (H,) volume (m³), area (m²) or number;
    ``moved`` (H,) weight times velocity along x (m/s); ``relative`` and ``squared`` (H, D) weight
    times velocity relative to the mean of all particles, and its square.
    """

    samples: np.ndarray
    weight: np.ndarray
    moved: np.ndarray
    relative: np.ndarray
    squared: np.ndarray

    def velocity(self) -> np.ndarray:
        """Return the mean velocity along x (m/s), not-a-number in empty slices."""
        return ratio(self.moved, self.weight)

    def temperature(self) -> np.ndarray:
        """Return the granular temperature (m²/s²) per direction, (H, D).

        T = ⟨v²⟩ - ⟨v⟩² of the velocities relative to the mean motion, so that a change of the mean
        velocity between samples does not count as agitation.
        """
        weight = self.weight[:, None]
        return ratio(self.squared, weight) - ratio(self.relative, weight) ** 2


def ratio(sums: Any, weight: np.ndarray) -> np.ndarray:
    """Return sums over weights, not-a-number where there is no weight."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(weight > 0, sums / weight, np.nan)


def empty_profile(slices: int, dimension: int) -> Profile:
    """Return sums of zero."""
    moments = [np.zeros((slices, dimension)) for _ in range(2)]
    return Profile(np.zeros(1), np.zeros(slices), np.zeros(slices), *moments)


@inlined
def _share_below(kind, radius, depth):
    """Return the part of a particle below a level that is ``depth`` above its lowest point."""
    if kind == CENTRE:
        return 1.0 if depth > radius else 0.0
    depth = min(max(depth, 0.0), 2.0 * radius)
    if kind == VOLUME:
        return pi * depth * depth * (radius - depth / 3.0)
    above = radius - depth
    return radius * radius * acos(above / radius) - above * sqrt(
        max(0.0, depth * (2.0 * radius - depth))
    )


@kernel
def add_sample(profile, kind, slice_height, height, radius, velocity):
    """Add one state: heights (N,), radii (N,) and velocities (D, N) of the particles."""
    slices, dimension = profile.relative.shape
    mean = np.zeros(dimension)
    for d in range(dimension):
        mean[d] = velocity[d].mean()
    profile.samples[0] += 1.0
    for i in range(height.size):
        lowest = height[i] - radius[i]
        first = max(0, int(np.floor(lowest / slice_height)))
        last = min(slices - 1, int(np.floor((height[i] + radius[i]) / slice_height)))
        for s in range(first, last + 1):
            weight = _share_below(kind, radius[i], (s + 1) * slice_height - lowest) - _share_below(
                kind, radius[i], s * slice_height - lowest
            )
            profile.weight[s] += weight
            profile.moved[s] += weight * velocity[0, i]
            for d in range(dimension):
                relative = velocity[d, i] - mean[d]
                profile.relative[s, d] += weight * relative
                profile.squared[s, d] += weight * relative * relative


#: Decades of the histogram: the smallest edge is 10⁻⁷ diameters, the largest one diameter.
DECADES = 7
BINS_PER_DECADE = 40
BINS = DECADES * BINS_PER_DECADE

#: Edges of the intervals, in diameters; smaller and larger overlaps count in the outermost.
EDGES = np.logspace(-DECADES, 0, BINS + 1)


class Overlaps(NamedTuple):
    """``counts`` (B,) of contacts per interval of overlap."""

    counts: np.ndarray


def no_overlaps() -> Overlaps:
    """Return counts of zero."""
    return Overlaps(np.zeros(BINS))


@inlined
def _count(counts, overlap):
    if overlap > 0.0:
        index = int((log10(overlap) + DECADES) * BINS_PER_DECADE)
        counts[min(max(index, 0), BINS - 1)] += 1.0


@kernel
def count_overlaps(counts, spheres, pairs):
    """Count the overlaps of all contacts of the present state.

    Overlaps between spheres are relative to the sum of the radii, those with the plane to the
    diameter.
    """
    for p in range(pairs.start[-1]):
        dx, dy, dz = nearest_separation(
            spheres.position, pairs.box, pairs.first[p], pairs.second[p]
        )
        distance = (dx * dx + dy * dy + dz * dz) ** 0.5
        _count(counts, 1.0 - distance / pairs.reach[p])
    for i in range(spheres.radius.size):
        if spheres.inverse_mass[i] > 0.0:
            gap = spheres.position[2, i] - spheres.radius[i]
            _count(counts, -0.5 * gap / spheres.radius[i])


#: Number of levels of squares, one mean diameter each, from below the belt's lowest position.
LEVELS = 60

#: Number of the longest density waves along the belt whose power is added.
WAVES = 5


class Field(NamedTuple):
    """Sums over samples in squares of the laboratory.

    ``samples`` (1,); ``count`` (X, Z) beads; ``moved`` (X, Z) sum of their velocities along x.
    """

    samples: np.ndarray
    # This field hides the method of tuples with the same name, which is never called.
    count: np.ndarray  # type: ignore[assignment]
    moved: np.ndarray


class Squares(NamedTuple):
    """The squares: ``columns`` of ``width`` (m) along the belt, levels of ``height`` (m).

    ``lowest`` (m) is the lower edge of the first level.
    """

    columns: int
    width: float
    height: float
    lowest: float

    def coordinates(self) -> dict[str, tuple[str, str, np.ndarray]]:
        """Return the centres of columns and levels: name -> (unit, long name, values)."""
        column = (np.arange(self.columns) + 0.5) * self.width
        level = self.lowest + (np.arange(LEVELS) + 0.5) * self.height
        return {
            "column": ("m", "centre of the column along the belt", column),
            "level": ("m", "height of the level above the mean belt position", level),
        }

    def empty(self) -> Field:
        """Return sums of zero."""
        shape = (self.columns, LEVELS)
        return Field(np.zeros(1), np.zeros(shape), np.zeros(shape))

    def tables(self, field: Field) -> dict[str, np.ndarray]:
        """Return mean velocity along x (m/s), not-a-number without beads, and density (m⁻²)."""
        with np.errstate(invalid="ignore"):
            density = field.count / (field.samples[0] * self.width * self.height)
        return {"field_velocity": ratio(field.moved, field.count), "field_density": density}


def squares(width: float, diameter: float, amplitude: float) -> Squares:
    """Return squares of about a mean diameter (m) for a belt of a width (m).

    ``amplitude`` is the amplitude of the vertical vibration in mean diameters.
    """
    columns = max(1, round(width / diameter))
    return Squares(columns, width / columns, diameter, -ceil(amplitude) * diameter)


@exact
def count_beads(field, squares, taylor, time_step):
    """Add one state of the beads, see ``Disks``; beads outside the levels are omitted."""
    field.samples[0] += 1.0
    for i in range(taylor.shape[2]):
        level = int(np.floor((taylor[0, 1, i] - squares.lowest) / squares.height))
        if 0 <= level < LEVELS:
            column = int(np.floor(taylor[0, 0, i] / squares.width)) % squares.columns
            field.count[column, level] += 1.0
            field.moved[column, level] += taylor[1, 0, i] / time_step


@exact
def waves(x, width, sums):
    """Set ``sums`` (5, 2) to the real and imaginary parts of Σ exp(2πikx/L) over all beads.

    The wave number k goes from 1 to 5; L is the width of the belt (m).
    """
    parts = np.empty((WAVES, 2, x.size))
    for i in range(x.size):
        angle = 2.0 * pi / width * x[i]
        wave = cos(angle), sin(angle)
        second = product(wave, wave)
        fourth = product(second, second)
        powers = wave, square(wave), product(wave, second), fourth, product(wave, fourth)
        for k in range(WAVES):
            parts[k, 0, i], parts[k, 1, i] = powers[k]
    for k in range(WAVES):
        for part in range(2):
            sums[k, part] = total(parts[k, part], COMPLEX)


def wave_power(sums: np.ndarray, beads: int) -> np.ndarray:
    """Return the power of the longest density waves along the belt; 1 for random beads.

    ``sums`` (K, 5, 2) are those of ``waves`` in K states.
    """
    # The square of Python's numbers, which is not always the product.
    size = np.hypot(sums[..., 0], sums[..., 1]).tolist()
    power = [a**2 + b**2 + c**2 + d**2 + e**2 for a, b, c, d, e in size]
    return np.array(power) / (WAVES * beads)


# Sums that round like numpy's, so that compiled code keeps the bits of arrays; energies of all.
#
# numpy adds several partial sums in parallel and halves arrays longer than a block. It rounds the
# squares of an array of complex numbers once less than other powers.

#: Number of parallel partial sums for real numbers, and for real or imaginary parts.
REAL, COMPLEX = 8, 4

#: Longest part, in numbers per partial sum, that is not halved.
LENGTH = 16


@exact
def total(values, lanes):
    """Return the sum of values (N,) as ``np.sum`` adds them in ``lanes`` partial sums."""
    if values.size <= LENGTH * lanes:
        return _sum_in_lanes(values, lanes)
    half = values.size // (2 * lanes) * lanes
    return total(values[:half], lanes) + total(values[half:], lanes)


@exact
def _sum_in_lanes(values, lanes):
    part, whole = -0.0, values.size - values.size % lanes
    if whole > 0:
        parts = values[:lanes].copy()
        for k in range(lanes, whole, lanes):
            for lane in range(lanes):
                parts[lane] += values[k + lane]
        while parts.size > 1:
            parts = parts[::2] + parts[1::2]
        part = parts[0]
    for k in range(whole, values.size):
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
    """Return kinetic energy (J), height (m) and share near the belt of all beads at one moment.

    The height is that of the centre of mass; near are beads whose centres are within an
    ``amplitude`` (m) of the mean belt position. For ``taylor`` (6, 2, N) see ``Disks``, whose
    ``time_step`` is in s; ``mass`` (N,) in kg.
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


def flow_energies(spheres: Spheres) -> dict[str, float]:
    """Return kinetic energies and height of all spheres at one moment.

    These are ``translation``, twice the kinetic energy (J), ``rotation``, the sum of mass times the
    square of the velocity of the rim (J), and the ``height`` of the centre of mass (m).
    """
    mass, (vx, vy, vz), (wx, wy, wz) = spheres.mass, spheres.velocity, spheres.rim
    return {
        "translation": (mass * (vx * vx + vy * vy + vz * vz)).sum(),
        "rotation": (mass * (wx * wx + wy * wy + wz * wz)).sum(),
        "height": (spheres.position[2] * mass).sum() / mass.sum(),
    }
