"""Periodic cells: usual width, least one for a particle to meet one image of another, packed base.

The engine lets two particles meet as the nearest periodic images of each other alone. Particles of
diameters d and d' touch where their centres are closer than (d + d')/2. So one can touch two images
of the other where the period is less than d + d', and nowhere else.
"""

from math import pi

#: Least side of a cell, in diameters.
LEAST_CELL = 3.0

#: What is allowed for both sides of a cell, in words.
SIDES = "a number, or [along the flow, across it] without cell_across"


def least_period(largest: float, fixed: float = 0.0, reach: float = 0.0) -> float:
    """Return the least period in which no particle can touch two images of another one.

    ``largest`` is the largest diameter of those that move, ``fixed`` that of fixed ones, which need
    not keep away from each other; the law acts up to a ``reach`` beyond contact.
    """
    return largest + max(largest, fixed) + 2 * reach


def largest_diameter(spread: float, is_flat: bool) -> float:
    """Return the largest diameter in σ of many spheres, or discs, with diameters within ±spread σ.

    They are scaled so that the mean mass is that of a diameter σ: the mean of (1 + s u)³ is 1 + s²
    for u uniform in (-1, 1), that of (1 + s u)² is 1 + s²/3.
    """
    scale = (1 + spread**2 / 3) ** (1 / 2) if is_flat else (1 + spread**2) ** (1 / 3)
    return (1 + spread) / scale


def wider_cell(cell: float, largest: float, bumps: float, reach: float = 0.0) -> str:
    """Return what a cell may be that is too narrow, in words; an empty text for a wide one.

    ``cell``, the ``largest`` diameter, that of ``bumps`` (0: none) and the law's ``reach`` in σ.
    """
    least = least_period(largest, bumps, reach)
    if cell >= least:
        return ""
    sizes, other = (
        ("bumps + the largest diameter", "a glued one")
        if bumps > largest
        else ("twice the largest diameter", "another one")
    )
    sizes += " + twice the reach of the law" if reach else ""
    return (
        f"at least {sizes} = {least:.12g}: in a narrower cell a particle can touch {other} and its "
        "periodic image at once"
    )


#: Cells of this many diameters are wide enough for a deep flow on bumps not to order in layers.
WIDE_CELL = 8


def usual_cell(depth: float, bumps: float) -> float:
    """Return the side in σ of a cell that is not given: the paper's above its plane without bumps.

    In a cell of 5 a deep flow on bumps turns into layers that glide on each other, several times
    as fast as in wider ones.
    """
    if depth <= 10:
        return 10
    return WIDE_CELL if bumps else 5


#: Of a base that is a slice of a random packing: packing fraction; thickness, the distance of the
#: highest from the lowest centre, in diameters of its spheres, as in Silbert et al., Phys. Rev. E
#: 64, 051302 (2001).
PACKING, SLICE = 0.58, 1.2

#: Height that no slice reaches above its lowest point, and least side of its cell, in these
#: diameters.
TOP, LEAST_SIDE = 2.4, 3.0


def spheres_in_slice(along: float, across: float) -> int:
    """Return the number of spheres in the slice of a cell, whose sides are in their diameters.

    It is that of the packing in a layer with the thickness of the slice.
    """
    return max(1, round(PACKING * SLICE * along * across / (pi / 6.0)))
