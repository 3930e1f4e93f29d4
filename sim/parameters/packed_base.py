"""A base that is a slice of a random packing: its size, and how many spheres it has."""

from math import pi

#: Packing fraction of the packing; thickness of the slice, the distance of its highest from its
#: lowest centre, in diameters of its spheres, as in Silbert et al., Phys. Rev. E 64, 051302 (2001).
PACKING, SLICE = 0.58, 1.2

#: Height that no slice reaches above its lowest point, in these diameters.
TOP = 2.4

#: Least side of its cell in these diameters.
LEAST_SIDE = 3.0


def spheres_in_slice(along: float, across: float) -> int:
    """Return the number of spheres in the slice of a cell, whose sides are in their diameters.

    It is that of the packing in a layer with the thickness of the slice.
    """
    return max(1, round(PACKING * SLICE * along * across / (pi / 6.0)))
