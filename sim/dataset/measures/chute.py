"""Measures of chute flows, from one replicate of a run file."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.dataset.measures import layers, order, plug

#: Measures that are quantiles of the overlaps.
_QUANTILES = {"median_overlap": 0.5, "overlap_999": 0.999}


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    base = _spin_measures(run) | base_measures(run) | _force_measures(run)
    return _profile_measures(run) | overlap_measures(run) | base


def _profile_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return shear depth and plug states, and the order of the spheres above that depth."""
    packing = np.asarray(run["packing_profile"]) if "packing_profile" in run else np.zeros(0)
    if not np.nansum(packing) > 0:
        return {}
    diameter = float(run["diameter"])
    height, velocity = np.asarray(run["height"]), np.asarray(run["velocity_profile"])
    depth = layers.shear_depth(height, velocity, packing, diameter)
    values = {"shear_depth": depth} | plug.measure(run)
    if "position" not in run:
        return values
    position = np.asarray(run["position"])[-1]
    is_above = position[:, 2] > depth
    side = float(run["cell"]) * diameter
    return values | {
        "crystalline_share": order.crystalline_share(position, is_above, side, diameter),
        "layer_order": order.layer_order(position[is_above, 2], diameter),
    }


def _spin_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return rolling and slip of the spheres at the plane, from slices below their centres."""
    if "spin_profile" not in run:
        return {}
    radius, height = 0.5 * float(run["diameter"]), np.asarray(run["height"])
    packing = np.asarray(run["packing_profile"])
    names = ("spin_profile", "velocity_profile", "vertical_temperature_profile")
    spin, velocity, temperature = (
        layers.mean_between(height, np.asarray(run[name]), packing, 0.0, radius) for name in names
    )
    slip = velocity - radius * spin
    return {
        "base_rolling": radius * spin / velocity if velocity else np.nan,
        "base_slip_ratio": slip / temperature**0.5 if temperature > 0 else np.nan,
    }


def _force_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the ratio of the forces on the plane."""
    normal = float(run["base_normal"]) if "base_normal" in run else 0.0
    return {"base_stress_ratio": float(run["base_shear"]) / normal} if normal > 0 else {}


def base_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the mean overlap with the plane in the last state, empty if no sphere touches it."""
    if "position" not in run or "radius" not in run:
        return {}
    overlap = np.asarray(run["radius"]) - np.asarray(run["position"])[-1, :, 2]
    is_touching = overlap > 0
    if not is_touching.any():
        return {}
    return {"base_overlap": float(overlap[is_touching].mean() / float(run["diameter"]))}


def overlap_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return quantiles of the overlaps of contacts, empty for a run without their histogram."""
    if "overlap_histogram" not in run:
        return {}
    counts, edges = np.asarray(run["overlap_histogram"]), np.asarray(run["overlap_edges"])
    return {name: quantile(counts, edges, share) for name, share in _QUANTILES.items()}


def quantile(counts: np.ndarray, edges: np.ndarray, share: float) -> float:
    """Return a quantile of a histogram (B,) with edges (B + 1,), log-linear within a bin."""
    total = counts.sum()
    if not total > 0:
        return np.nan
    below = np.concatenate([[0.0], np.cumsum(counts)]) / total
    return float(np.exp(np.interp(share, below, np.log(edges))))
