"""Profiles over height, and the histogram of the overlaps of contacts, as sums over samples.

A particle has an exact share in each slice that it crosses; velocities have moments.
"""

from math import acos, log10, pi, sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.compile import inlined, kernel
from sim.engine.dynamics.spheres import nearest_separation

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
        return _ratio(self.moved, self.weight)

    def temperature(self) -> np.ndarray:
        """Return the granular temperature (m²/s²) per direction, (H, D).

        T = ⟨v²⟩ - ⟨v⟩² of the velocities relative to the mean motion, so that a change of the mean
        velocity between samples does not count as agitation.
        """
        weight = self.weight[:, None]
        return _ratio(self.squared, weight) - _ratio(self.relative, weight) ** 2


def _ratio(sums: np.ndarray, weight: np.ndarray) -> np.ndarray:
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
