"""Tests of single impacts."""

from collections.abc import Mapping
from math import pi, sqrt
from typing import Any

import numpy as np

from sim.engine.impact import impact
from sim.verify.exact import RIM, hertz_impact, mindlin_rebound, pull_of_dashpot

#: What a test gives: by check, what is measured and what it should be.
Found = dict[str, tuple[float, float]]

#: Chung and Ooi's speed (m/s), and the materials: Young's modulus (Pa), Poisson's ratio, density
#: (kg/m³) and radius (m).
SPEED = 3.9
ALUMINA = (3.8e11, 0.23, 4000.0, 2.5e-3)
ALUMINIUM, MAGNESIUM = (7e10, 0.3, 2699.0, 0.1), (4e10, 0.35, 1800.0, 0.1)

#: Friction and restitution of alumina, and the angles (degree) at which it meets the plane.
FRICTION, RESTITUTION = 0.092, 0.98
ANGLES = np.arange(5.0, 90.0, 5.0)

#: Spins (1/s) that peers have published, over angles (degree).
CURVES: Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    # benchmark4_graph2_ref.dat of Kratos, the paper's curve.
    "paper (Chung and Ooi)": (
        (4.95, 10.08, 14.97, 19.94, 24.91, 29.96, 34.93, 39.98, 50, 60.02, 69.96, 80.06, 85.03),
        (
            *(19.266, 212.997, 377.829, 510.550, 599.388, 616.514, 582.263, 544.801, 457.034),
            *(357.492, 246.177, 126.300, 63.150),
        ),
    ),
    # benchmark4_dt_2e-08_final_angular_vel_list_data.dat of Kratos.
    "Kratos": (
        tuple(ANGLES),
        (
            *(49.462, 194.627, 369.109, 502.955, 592.395, 611.056, 578.406, 540.969, 499.420),
            *(454.054, 405.231, 353.309, 298.688, 241.774, 182.999, 122.808, 61.656),
        ),
    ),
    # DEM05/AUTOTEST/POST_OMEGA.dat of MFiX: Hertzian, particle and wall; and the experiment there.
    "MFiX": (
        tuple(np.arange(5.0, 70.0, 5.0)),
        (
            *(20.2515, 208.3846, 377.6207, 510.5268, 599.5303, 618.3861, 585.0427, 547.2487),
            *(505.2858, 459.4671, 410.1343, 357.6565, 302.4259),
        ),
    ),
    "experiment (Kharaz et al.)": (
        (6.0025, 10.9840, 21.1931, 31.0947, 39.0283, 50.2214, 60.2460),
        (135.5703, 264.5493, 577.0096, 612.6481, 595.4843, 452.9444, 381.3185),
    ),
}


def of_material(young: float, poisson: float, density: float, radius: float) -> dict[str, Any]:
    """Return the parameters of spheres of a material that meet a rigid plane."""
    diameter = 2 * radius
    return {
        "stiffness": young / (1 - poisson**2) * diameter / 15,
        "tangential_ratio": 2 * (1 - poisson) / (2 - poisson),
        "diameter": diameter,
        "mass": density * pi / 6 * diameter**3,
        "steps_per_collision": 200,
    }


def chung_ooi_2() -> Found:
    """Elastic impacts of two alloys on a plane."""
    found = {}
    for material in (ALUMINIUM, MAGNESIUM):
        values = of_material(*material)
        met = impact("hertz", speed=0.2, restitution=1, friction=0, **values)
        exact = hertz_impact(
            values["mass"], 15 * values["stiffness"] / values["diameter"], material[-1], 0.2
        )
        found[material] = {
            "overlap": (float(met.largest_overlap), exact["overlap"]),
            "force": (float(met.largest_force), exact["force"]),
            "duration": (float(met.duration), exact["duration"]),
        }
    return found[ALUMINIUM] | {"magnesium": found[MAGNESIUM]["overlap"]}


def chung_ooi_3() -> Found:
    """Restitutions of all laws, asked for and measured."""
    found = {}
    for law in ("walton_braun", "spring_dashpot", "hertz", "drag"):
        worst = 0.0
        for asked in (0.2, 0.4, 0.6, 0.8, 1.0):
            met = impact(law, speed=[0.05, 0.2], restitution=asked, steps_per_collision=200)
            worst = max(worst, float(np.abs(met.normal_restitution - asked).max()))
        found[law] = worst, 0.0
    return found


def spins() -> np.ndarray:
    """Return the spins (1/s) of alumina spheres after they met the plane at `ANGLES`."""
    met = impact(
        "hertz",
        speed=SPEED,
        angle=ANGLES,
        restitution=RESTITUTION,
        friction=FRICTION,
        **of_material(*ALUMINA),
    )
    return met.rebound_spin.values


def full_spins(angles: np.ndarray) -> np.ndarray:
    """Return the spins (1/s) with micro-slip, elastic, at angles (degree)."""
    _, poisson, _, radius = ALUMINA
    share, slope = 2 * (1 - poisson) / (2 - poisson), np.tan(np.radians(angles))
    lost = slope - mindlin_rebound(share, FRICTION, slope)
    return RIM / (1 + RIM) * lost * SPEED * np.cos(np.radians(angles)) / radius


def chung_ooi_4() -> Found:
    """Oblique impacts of alumina from sticking to sliding."""
    measured, full = spins(), full_spins(ANGLES)
    normal = SPEED * np.cos(np.radians(ANGLES))
    sliding = RIM * FRICTION * (1 + RESTITUTION) * normal / ALUMINA[-1]
    excess = (measured / sliding)[ANGLES >= 35]
    angles, paper = map(np.array, CURVES["paper (Chung and Ooi)"])
    there = measured[np.searchsorted(ANGLES, np.round(angles / 5) * 5)]
    return {
        "spin_10": (measured[1], full[1]),
        "spin_20": (measured[3], full[3]),
        "sliding": (float(excess[np.abs(excess - 1).argmax()]), 1.0),
        "curve": (float(np.sqrt(((there - paper) ** 2).sum() / (paper**2).sum())), 0.0),
    }


def lammps_formulas() -> Found:
    """Impacts that slide throughout: one that spins, and one of a pair."""
    density, radius, stiffness, e, friction, speed, spin = 2700, 0.1, 1.2e8, 0.5, 0.4, 0.2, 22.86
    shared: dict[str, Any] = {
        "diameter": 2 * radius,
        "mass": density * pi / 6 * (2 * radius) ** 3,
        "stiffness": stiffness,
        "tangential_ratio": 3.4e7 / stiffness,
        "steps_per_collision": 400,
    }
    met = impact(
        "spring_dashpot", speed=speed, spin=-spin, restitution=e, friction=friction, **shared
    )
    push = friction * (1 + e) * speed * (1 + pull_of_dashpot(e))
    # The spin is negative as if the sphere rolled the other way, in which friction pushes it.
    found = {
        "spin_x": (-float(met.tangential_velocity), push),
        "spin_w": (-float(met.rebound_spin), spin - RIM * push / radius),
    }
    normal, along, friction = 0.2, 0.4, 0.1
    met = impact(
        "spring_dashpot",
        partner="sphere",
        speed=sqrt(normal**2 + along**2),
        angle=float(np.degrees(np.arctan2(along, normal))),
        restitution=1,
        friction=friction,
        **shared,
    )
    push = 2 * friction * normal
    return found | {
        "pair_v": (float(met.tangential_velocity), along - push),
        "pair_w": (float(met.rebound_spin), RIM * push / 2 / radius),
    }
