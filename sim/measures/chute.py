"""Measures of flows of spheres, from one replicate of a run file."""

from collections.abc import Mapping
from math import nan
from typing import Any

import numpy as np

from sim.measures import layers, order
from sim.parameters.observables import observable


@observable(
    "shear_depth",
    system="chute",
    unit="m",
    meaning="height at which the velocity is 90 % of the surface's",
)
def shear_depth(run: Mapping[Any, Any]) -> float:
    """Return δ_s (m), NaN for a run without profiles."""
    if not layers.has_profiles(run):
        return nan
    height, velocity = np.asarray(run["height"]), np.asarray(run["velocity_profile"])
    packing = np.asarray(run["packing_profile"])
    return layers.shear_depth(height, velocity, packing, float(run["diameter"]))


@observable(
    "layer_order",
    system="chute",
    unit="1",
    meaning="amplitude of layers in the density above the shear depth",
)
@observable(
    "crystalline_share",
    system="chute",
    unit="1",
    meaning="share of spheres above the shear depth with 8 coherent q6 bonds",
)
def plug_order(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the order of the spheres above the shear depth in the last state."""
    if not (layers.has_profiles(run) and "position" in run):
        return {}
    diameter, position = float(run["diameter"]), np.asarray(run["position"])[-1]
    is_above = position[:, 2] > shear_depth(run)
    side = float(run["cell"]) * diameter
    return {
        "crystalline_share": order.crystalline_share(position, is_above, side, diameter),
        "layer_order": order.layer_order(position[is_above, 2], diameter),
    }


@observable(
    "overlap_999",
    system=("chute", "conveyor"),
    unit="1",
    meaning="99.9th percentile of the overlaps of the contacts, in diameters",
)
@observable(
    "median_overlap",
    system=("chute", "conveyor"),
    unit="1",
    meaning="median overlap of the contacts, in diameters",
)
def overlap_quantiles(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return quantiles of the overlaps of contacts, empty for a run without their histogram."""
    if "overlap_histogram" not in run:
        return {}
    counts, edges = np.asarray(run["overlap_histogram"]), np.asarray(run["overlap_edges"])
    return {
        "median_overlap": quantile(counts, edges, 0.5),
        "overlap_999": quantile(counts, edges, 0.999),
    }


def quantile(counts: np.ndarray, edges: np.ndarray, share: float) -> float:
    """Return a quantile of a histogram (B,) with edges (B + 1,), log-linear within a bin."""
    total = counts.sum()
    if not total > 0:
        return nan
    below = np.concatenate([[0.0], np.cumsum(counts)]) / total
    return float(np.exp(np.interp(share, below, np.log(edges))))


@observable(
    "base_overlap",
    system=("chute", "conveyor"),
    unit="1",
    meaning="mean overlap of contacts with the plane in the last state, in diameters",
)
def base_overlap(run: Mapping[Any, Any]) -> float:
    """Return the mean overlap with the plane in the last state, NaN if no sphere touches it."""
    if "position" not in run or "radius" not in run:
        return nan
    overlap = np.asarray(run["radius"]) - np.asarray(run["position"])[-1, :, 2]
    is_touching = overlap > 0
    if not is_touching.any():
        return nan
    return float(overlap[is_touching].mean() / float(run["diameter"]))


@observable(
    "base_slip_ratio",
    system="chute",
    unit="1",
    meaning="slip velocity of the spheres at the plane over the root of their vertical temperature",
)
@observable(
    "base_rolling",
    system="chute",
    unit="1",
    meaning="spin times radius over velocity of the spheres at the plane, 1 where they roll",
)
def base_motion(run: Mapping[Any, Any]) -> dict[str, float]:
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
        "base_rolling": radius * spin / velocity if velocity else nan,
        "base_slip_ratio": slip / temperature**0.5 if temperature > 0 else nan,
    }


@observable(
    "base_stress_ratio",
    system="chute",
    unit="1",
    meaning="mean shear over mean normal force on the plane",
)
def base_stress_ratio(run: Mapping[Any, Any]) -> float:
    """Return the ratio of the forces on the plane, NaN where nothing presses on it."""
    normal = float(run["base_normal"]) if "base_normal" in run else 0.0
    return float(run["base_shear"]) / normal if normal > 0 else nan
