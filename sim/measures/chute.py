"""Measures of flows of spheres on chute and conveyor, from one replicate of a run file."""

from collections.abc import Mapping
from math import nan
from typing import Any

import numpy as np

from sim.measures import layers
from sim.parameters.observables import observable

#: A sphere is crystalline if it has at least 8 coherent bonds: neighbors within 1.4 diameters whose
#: normalised q6 vector has a product with its own above 0.7 (similar surroundings, similarly
#: oriented; ten Wolde, Ruiz-Montero and Frenkel, J. Chem. Phys. 104 (1996) 9932).
DEGREE, COHERENCE, MIN_BONDS, BOND_LENGTH = 6, 0.7, 8, 1.4

#: Trial distances between layers, in diameters: those of crystals under their own weight.
SPACINGS = np.linspace(0.7, 1.05, 71)


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
    along = float(run["cell"]) * diameter
    sides = along, float(run.get("cell_across", 0.0)) * diameter or along
    return {
        "crystalline_share": crystalline_share(position, is_above, sides, diameter),
        "layer_order": layer_order(position[is_above, 2], diameter),
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


def coherent_bonds(position: np.ndarray, sides: tuple[float, float], diameter: float) -> np.ndarray:
    """Return the number of coherent q6 bonds of each sphere, (N,).

    ``position`` (N, 3) has their centres (m), and ``sides`` the sides of the cell along x and y
    (m), along which alone it is periodic; ``diameter`` is the mean one (m).
    """
    import freud

    height = position[:, 2] - 0.5 * (position[:, 2].min() + position[:, 2].max())
    box = freud.box.Box(*sides, np.ptp(height) + 4 * BOND_LENGTH * diameter)
    box.periodic = (True, True, False)
    # Positions are wrapped into the cell first, because the library takes single precision.
    centred = box.wrap(np.column_stack([position[:, :2] - 0.5 * np.array(sides), height]))
    order = freud.order.SolidLiquid(l=DEGREE, q_threshold=COHERENCE, solid_threshold=MIN_BONDS)
    # One thread: processes that read run files in parallel share the cores.
    with freud.parallel.NumThreads(1):
        order.compute(
            (box, centred.astype(np.float32)), neighbors={"r_max": BOND_LENGTH * diameter}
        )
    return order.num_connections


def crystalline_share(
    position: np.ndarray, is_selected: np.ndarray, sides: tuple[float, float], diameter: float
) -> float:
    """Return the share of selected spheres with at least 8 coherent bonds, NaN without any.

    The other spheres count as neighbors.
    """
    if not is_selected.any():
        return np.nan
    return float((coherent_bonds(position, sides, diameter)[is_selected] >= MIN_BONDS).mean())


def layer_order(height: np.ndarray, diameter: float) -> float:
    """Return how strongly centres at heights (N,), m, gather in equidistant layers, 0 to 1.

    It is the amplitude A of the wave exp(2πi z/d) in their density, at the distance d with the
    largest amplitude. The density peaks at 1 + 2A times its mean. Perfect layers give 1, and no
    order gives about 1/√N.
    """
    if not height.size:
        return np.nan
    waves = np.exp(2j * np.pi * height[:, None] / (SPACINGS * diameter))
    return float(np.abs(waves.mean(axis=0)).max())
