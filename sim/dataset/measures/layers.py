"""Where a flow has its surface, its shear layer and its plug, from profiles over height.

Profiles are arrays (H,) over slices of equal height, heights and diameters in m. Slices are thinner
than a sphere, so neighboring slices of one layer of spheres share their velocity.
"""

from itertools import pairwise
from typing import Any

import numpy as np

#: Share of the mass below what counts as the surface; the rest are a few spheres that fly.
BELOW_SURFACE = 0.99

#: Share of the surface's velocity that ends the shear layer.
SHEARED = 0.9

#: A plug shears less than this over any of its diameters, relative to what is below it.
UNSHEARED = 0.05

#: Least share of the depth that a plug takes.
PLUG = 0.3


def level(height: np.ndarray, density: np.ndarray, share: float) -> float:
    """Return the height (m) below which a share of what a density counts lies."""
    tops = height + 0.5 * (height[1] - height[0])
    return float(np.interp(share, np.cumsum(density) / density.sum(), tops))


def surface(height: np.ndarray, packing: np.ndarray) -> float:
    """Return the height (m) below which 99 % of the mass lies."""
    return level(height, packing, BELOW_SURFACE)


def surface_velocity(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the mean velocity of what lies within a diameter below the surface."""
    top = surface(height, packing)
    return mean_between(height, velocity, packing, top - diameter, top)


def mean_between(
    height: np.ndarray, values: np.ndarray, packing: np.ndarray, low: float, high: float
) -> float:
    """Return the mean of a profile over the mass between two heights, NaN where there is none."""
    inside = (height > low) & (height < high) & (packing > 0)
    return float(np.average(values[inside], weights=packing[inside])) if inside.any() else np.nan


def shear_depth(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return δ_s (m), the lowest height at which the velocity is 90 % of the surface's."""
    threshold = SHEARED * surface_velocity(height, velocity, packing, diameter)
    fast = np.flatnonzero(velocity >= threshold)
    if not fast.size or not threshold > 0:
        return np.nan
    last = fast[0]
    if last == 0:
        return float(height[0])
    rise = velocity[last] - velocity[last - 1]
    share = (threshold - velocity[last - 1]) / rise if np.isfinite(rise) else 1.0
    return float(height[last - 1] + share * (height[last] - height[last - 1]))


def relative_shear(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return heights (P,) in m, and the shear above each over that from the lowest centres to it.

    The shear above is the larger of the mean du/dz up to the surface and of that over any diameter
    there. So a bulge of the velocity does not shear nothing, though its sides cancel.
    """
    top, bottom = surface(height, packing), 0.5 * diameter
    places = height[(height > bottom) & (height < top - diameter) & np.isfinite(velocity)]
    known = np.isfinite(velocity)

    def at(place: Any) -> Any:
        return np.interp(place, height[known], velocity[known])

    below = (at(places) - at(bottom)) / (places - bottom)
    mean = np.abs(at(top) - at(places)) / (top - places)
    local = np.abs(at(places + diameter) - at(places)) / diameter
    # The largest of all diameters from a place on.
    local = np.maximum.accumulate(local[::-1])[::-1]
    shear = np.full(places.size, np.inf)
    np.divide(np.maximum(mean, local), below, out=shear, where=below > 0)
    return places, shear


def plug_base(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the lowest height (m) above which the flow shears less than 5 % of what it does below.

    A plug is at least a diameter thick; without one the surface is returned.
    """
    places, shear = relative_shear(height, velocity, packing, diameter)
    rigid = shear < UNSHEARED
    return float(places[rigid][0]) if rigid.any() else surface(height, packing)


def plug_share(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the share of the depth that is plug, 0 without one."""
    top = surface(height, packing)
    return 1.0 - plug_base(height, velocity, packing, diameter) / top


def packing_by_diameters(
    height: np.ndarray, packing: np.ndarray, diameter: float, layers: int = 1
) -> np.ndarray:
    """Return the packing fraction of layers of some diameters up to the surface, from below.

    A layer that the surface cuts is left out.
    """
    thickness = layers * diameter
    # The margin is lest rounding cut a layer that just fits.
    edges = thickness * np.arange(int(surface(height, packing) / thickness + 1e-9) + 1)
    pairs = pairwise(edges)
    return np.array([packing[(height > low) & (height < high)].mean() for low, high in pairs])
