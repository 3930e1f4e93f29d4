"""A rough base as published chutes have it: a frozen slice of a random packing of spheres.

After Silbert et al., Phys. Rev. E 64, 051302 (2001), whose slice is 1.2 diameters thick.
"""

import numpy as np

from sim.parameters.images import PACKING, SLICE, spheres_in_slice

#: Height of the packing in diameters, in which it is periodic, too.
HEIGHT = 5.0

#: Largest overlap of two spheres, in diameters, and most rounds until it is reached.
MAX_OVERLAP, _ROUNDS = 1e-3, 20_000

#: Share of an overlap by which a pair moves apart in a round: more than all speeds it up.
_PUSH = 1.2


def packed_base(
    along: float, across: float, diameter: float, rng: np.random.Generator
) -> np.ndarray:
    """Return the centres (N, 3) in m of a slice of a random packing, the lowest a radius high.

    ``along`` and ``across`` are the sides of the periodic cell in diameters, ``diameter`` that of
    the spheres in m. The slice has `spheres_in_slice`, with consecutive heights: of all such slices
    the one that comes nearest to its thickness.
    """
    place = random_close_packing(np.array([along, across, HEIGHT]), rng)
    place = place[np.argsort(place[:, 2])]
    number = spheres_in_slice(along, across)
    # The slices that begin at each sphere, some of which go on at the bottom of the next image.
    above = np.concatenate([place, place + np.array([0.0, 0.0, HEIGHT])])
    thickness = above[number - 1 :, 2][: len(place)] - place[:, 2]
    first = int(np.abs(thickness - SLICE).argmin())
    centres = above[first : first + number]
    return diameter * (centres + np.array([0.0, 0.0, 0.5 - centres[0, 2]]))


def random_close_packing(sides: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return centres (N, 3) of spheres of diameter 1 that fill a periodic box with `PACKING`.

    Spheres at random places push each other apart until none overlaps by more than `MAX_OVERLAP`.
    Raises ``ValueError`` where they do not come to that.
    """
    # Imported here: few flows have such a base.
    from scipy.spatial import cKDTree

    number = round(PACKING * sides.prod() / (np.pi / 6.0))
    place = rng.random((number, 3)) * sides
    for _ in range(_ROUNDS):
        first, second = cKDTree(place, boxsize=sides).query_pairs(1.0, output_type="ndarray").T
        apart = place[first] - place[second]
        apart -= sides * np.round(apart / sides)
        distance = np.sqrt((apart**2).sum(axis=1))
        overlap = 1.0 - distance
        if not overlap.size or overlap.max() <= MAX_OVERLAP:
            return place
        push = 0.5 * _PUSH * (overlap / np.maximum(distance, 1e-9))[:, None] * apart
        np.add.at(place, first, push)
        np.add.at(place, second, -push)
        place %= sides
        # A tiny negative number wraps to the side itself.
        place[place >= sides] = 0.0
    raise ValueError(f"spheres of a base still overlap by {overlap.max():.2g} of a diameter")
