"""Surface, shear layer and plug of a flow, from profiles over height.

Profiles are arrays (H,) over slices of equal height, heights and diameters in m. Slices are thinner
than a sphere, so neighboring slices within one layer of spheres have the same velocity.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

#: Share of the mass below the surface; the rest are a few flying spheres.
SURFACE_SHARE = 0.99

#: The shear layer ends at this share of the velocity of the surface.
SHEAR_SHARE = 0.9

#: A plug shears less than this, over any diameter in it, relative to the flow below it.
PLUG_SHEAR = 0.05

#: Smallest share of the depth that a plug takes.
MIN_PLUG_SHARE = 0.3


def has_profiles(run: Mapping[Any, Any]) -> bool:
    """Return whether a replicate has profiles of a flow."""
    return "packing_profile" in run and bool(np.nansum(np.asarray(run["packing_profile"])) > 0)


def level(height: np.ndarray, density: np.ndarray, share: float) -> float:
    """Return the height (m) below which a share of the total of a density lies."""
    tops = height + 0.5 * (height[1] - height[0])
    return float(np.interp(share, np.cumsum(density) / density.sum(), tops))


def surface(height: np.ndarray, packing: np.ndarray) -> float:
    """Return the height (m) below which 99 % of the mass lies."""
    return level(height, packing, SURFACE_SHARE)


def surface_velocity(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the mean velocity of the mass within a diameter below the surface."""
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
    threshold = SHEAR_SHARE * surface_velocity(height, velocity, packing, diameter)
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
    """Return heights (P,) in m, and for each the shear above it over the shear below it.

    The shear below is the mean du/dz from the lowest centres to this height. The shear above is the
    larger of two: the mean du/dz up to the surface, and the largest over any diameter there. So a
    bulge of the velocity counts as shear, although its sides cancel in the mean.
    """
    top, bottom = surface(height, packing), 0.5 * diameter
    levels = height[(height > bottom) & (height < top - diameter) & np.isfinite(velocity)]
    is_known = np.isfinite(velocity)

    def velocity_at(level: Any) -> Any:
        return np.interp(level, height[is_known], velocity[is_known])

    below = (velocity_at(levels) - velocity_at(bottom)) / (levels - bottom)
    mean = np.abs(velocity_at(top) - velocity_at(levels)) / (top - levels)
    local = np.abs(velocity_at(levels + diameter) - velocity_at(levels)) / diameter
    # The largest shear over any diameter from a height on.
    local = np.maximum.accumulate(local[::-1])[::-1]
    shear = np.full(levels.size, np.inf)
    np.divide(np.maximum(mean, local), below, out=shear, where=below > 0)
    return levels, shear


def plug_base(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the lowest height (m) above which the flow shears less than 5 % of the shear below.

    A plug is at least a diameter thick. Without a plug this returns the surface.
    """
    levels, shear = relative_shear(height, velocity, packing, diameter)
    is_rigid = shear < PLUG_SHEAR
    return float(levels[is_rigid][0]) if is_rigid.any() else surface(height, packing)


def plug_share(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the share of the depth that is plug, 0 without a plug."""
    top = surface(height, packing)
    return 1.0 - plug_base(height, velocity, packing, diameter) / top


def packing_by_diameters(
    height: np.ndarray, packing: np.ndarray, diameter: float, layers: int = 1
) -> np.ndarray:
    """Return packing fractions of layers ``layers`` diameters thick, from below up to the surface.

    A layer that the surface cuts is left out.
    """
    thickness = layers * diameter
    # The margin keeps rounding from cutting a layer that just fits.
    edges = thickness * np.arange(int(surface(height, packing) / thickness + 1e-9) + 1)
    pairs = pairwise(edges)
    return np.array([packing[(height > low) & (height < high)].mean() for low, high in pairs])
