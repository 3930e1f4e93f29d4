"""Observables of the bulk of a flow of spheres down a chute, from its profiles over height.

The height of the flow is h = s - b, with base b and surface s where the weight above, on a line
through the heights at which it is 99 % and 1 % of all, would be all and nothing (as Weinhart,
Thornton, Luding and Bokhove, Granular Matter 14 (2012) 531, take it from the stress). The bulk lies
between a fifth and four fifths of it, away from base and surface.
"""

from collections.abc import Mapping
from math import nan
from typing import Any, NamedTuple

import numpy as np

from sim.measures.layers import has_profiles
from sim.parameters.observables import declare_observables, observable

#: Shares of the weight that is left out at base and surface before the line is drawn.
_END = 0.01

#: Bounds of the bulk in heights of the flow above its base; fewest slices that make one.
BULK, MIN_SLICES = (0.2, 0.8), 5

#: Range in which the power of a velocity profile is looked for.
_POWERS = (0.1, 6.0)


class Bulk(NamedTuple):
    """A flow above ``base`` (m), of ``height`` (m), and which slices (H,) are of its bulk."""

    base: float
    height: float
    inside: np.ndarray


def bulk_of(run: Mapping[Any, Any]) -> Bulk | None:
    """Return base, height and bulk of a replicate; None without profiles."""
    if not has_profiles(run):
        return None
    z, packing = np.asarray(run["height"]), np.nan_to_num(np.asarray(run["packing_profile"]))
    below = np.concatenate([[0.0], np.cumsum(packing)]) / packing.sum()
    edges = np.concatenate([[0.0], z + 0.5 * (z[1] - z[0])])
    low, high = np.interp((_END, 1.0 - _END), below, edges)
    margin = _END / (1.0 - 2.0 * _END) * (high - low)
    base, height = low - margin, high - low + 2.0 * margin
    share = (z - base) / height
    return Bulk(float(base), float(height), (share > BULK[0]) & (share < BULK[1]))


def bulk_profiles(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return height, packing fraction and its change, and power of the velocity of a replicate.

    The change is that of the straight line with the least squares over the bulk, upwards, relative
    to the mean.

    What lies in a bulk of fewer than five slices has no value.
    """
    if (bulk := bulk_of(run)) is None:
        return {}
    values = {"flow_height": bulk.height}
    if bulk.inside.sum() >= MIN_SLICES:
        depth = 1.0 - (np.asarray(run["height"])[bulk.inside] - bulk.base) / bulk.height
        velocity = np.asarray(run["velocity_profile"])[bulk.inside]
        packing = np.asarray(run["packing_profile"])[bulk.inside]
        values["bulk_packing"] = float(packing.mean())
        rise = -np.polyfit(depth, packing, 1)[0] * (BULK[1] - BULK[0])
        values["packing_change"] = float(rise / packing.mean())
        values["profile_power"] = profile_power(depth, velocity)
    return values


def profile_power(depth: np.ndarray, velocity: np.ndarray) -> float:
    """Return p of u = a + c (1 - depthᵖ) with the least squares, NaN where none is the best.

    ``depth`` (P,) are depths below the surface in heights of the flow, in (0, 1). Velocities, (P,)
    in m/s, need not vanish at the base.
    """
    # Imported here: it takes a quarter of a second.
    from scipy.optimize import minimize_scalar

    if not np.isfinite(velocity).all() or not np.ptp(velocity) > 0:
        return nan

    def misfit(power: float) -> float:
        design = np.column_stack([np.ones_like(depth), 1.0 - depth**power])
        numbers = np.linalg.lstsq(design, velocity, rcond=None)[0]
        return float(((design @ numbers - velocity) ** 2).sum())

    scale = float(((velocity - velocity.mean()) ** 2).sum())
    found = minimize_scalar(
        lambda power: misfit(power) / scale,
        bounds=_POWERS,
        method="bounded",
        options={"xatol": 1e-6},
    )
    is_inside = _POWERS[0] + 1e-3 < found.x < _POWERS[1] - 1e-3
    return float(found.x) if is_inside else nan


declare_observables(
    bulk_profiles,
    {
        "flow_height": ("m", "height of the flow h"),
        "bulk_packing": ("1", "packing fraction of the bulk"),
        "packing_change": ("1", "relative change of the packing fraction over the bulk, upwards"),
        "profile_power": ("1", "power p of the velocity, 1 - (1 - z/h)^p"),
    },
    system="chute",
)


def bulk_rheology(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return friction, inertial number, stress ratios and the exponent of the shear rate.

    Stresses are those of contacts and motion together. Ratios are those of their sums over the
    bulk; the inertial number is I = γ̇ σ √(ρ/P) with P = σ_zz, its mean over the bulk. The exponent
    is the slope of ln γ̇ over ln σ_xz, 1/2 for Bagnold's law.
    """
    bulk = bulk_of(run)
    if bulk is None or "contact_normal_stress_profile" not in run:
        return {}
    if bulk.inside.sum() < MIN_SLICES:
        return {}

    def inside(name: str) -> np.ndarray:
        return np.asarray(run[f"{name}_profile"], float)[bulk.inside]

    longitudinal, transverse, normal, shear = (
        inside(f"contact_{name}_stress") + inside(f"kinetic_{name}_stress")
        for name in ("longitudinal", "transverse", "normal", "shear")
    )
    total, number = float(normal.sum()), inside("inertial_number")
    if not total > 0:
        return {}
    density = float(run["mass"]) / (np.pi / 6.0 * float(run["diameter"]) ** 3)
    rate = number / float(run["diameter"]) * np.sqrt(normal / density)
    has_slope = bool((rate > 0).all() and (shear > 0).all() and np.ptp(shear) > 0)
    return {
        "bulk_friction": float(shear.sum()) / total,
        "bulk_inertial_number": float(number.mean()),
        "longitudinal_stress_ratio": float(longitudinal.sum()) / total,
        "transverse_stress_ratio": float(transverse.sum()) / total,
        "rate_exponent": float(np.polyfit(np.log(shear), np.log(rate), 1)[0]) if has_slope else nan,
    }


declare_observables(
    bulk_rheology,
    {
        "bulk_friction": ("1", "friction of the bulk, σ_xz/σ_zz"),
        "bulk_inertial_number": ("1", "inertial number of the bulk"),
        "longitudinal_stress_ratio": ("1", "σ_xx/σ_zz of the bulk"),
        "transverse_stress_ratio": ("1", "σ_yy/σ_zz of the bulk"),
        "rate_exponent": ("1", "d ln γ̇/d ln σ_xz of the bulk"),
    },
    system="chute",
    asked_by="stress_profiles",
)


@observable(
    "mean_mass_flux",
    system=("chute", "conveyor"),
    unit="kg m-1 s-1",
    meaning="mean mass flux per unit width",
)
def mean_mass_flux(run: Mapping[Any, Any]) -> float:
    """Return the mean of the mass flux after the transient, NaN without its series."""
    if "mass_flux" not in run:
        return nan
    flux, time = np.asarray(run["mass_flux"], float), np.asarray(run["time"])
    window = flux[(time > float(run["average_start"])) & np.isfinite(flux)]
    return float(window.mean()) if window.size else nan
