"""Histogram of the overlaps of contacts in a flow of spheres, over all samples."""

from math import log10
from typing import NamedTuple

import numpy as np

from sim.engine.compile import inlined, kernel
from sim.engine.dynamics.spheres import nearest_separation

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
