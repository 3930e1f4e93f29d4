"""One impact in plain Python, with the two conventions in which the engines differ as a choice."""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from sim.laws.hertz import effective_modulus
from sim.parameters import ChuteParameters
from sim.parameters.dashpot import damping_fraction


class Convention(NamedTuple):
    """What an engine makes of a tangential force between two spheres.

    Whether it keeps its size when it is turned into the new tangent plane, or only its part within
    that plane; and by which share of the overlap the arms of its torques are shorter than radii.
    """

    rescaled: bool
    shortened: float


TALUS = Convention(True, 0.0)

#: LAMMPS: ``gran/hooke/history``, and ``granular``, which is told the restitution.
HOOKE, GRANULAR = Convention(False, 0.0), Convention(True, 0.5)


class Springs(NamedTuple):
    """F_N = ``normal`` (N/m) α + ``damping`` (kg/s) dα/dt; stiffness ``tangential`` (N/m)."""

    normal: float
    damping: float
    tangential: float


def damping_constant(p: ChuteParameters, stiffness: float, mass: float) -> float:
    """Return c (kg/s) of F = K α + c dα/dt for K (N/m) and reduced mass (kg)."""
    if p.normal_damping:
        return p.normal_damping * mass
    share, whole = damping_fraction(p.restitution, p.attraction)
    return 2.0 * share / whole * sqrt(stiffness * mass)


def springs(p: ChuteParameters, overlap: float, radius: float, mass: float) -> Springs:
    """Return the springs of a law at an overlap, for the reduced radius (m) and mass (kg)."""
    if p.law == "hertz":
        stiffness = 2.0 * effective_modulus(p) * sqrt(radius * overlap)
        damping = sqrt(5 / 6) * damping_constant(p, stiffness, mass)
        return Springs(2 / 3 * stiffness, damping, p.tangential_share * stiffness)
    damping = damping_constant(p, p.stiffness, mass)
    return Springs(p.stiffness, damping, p.tangential_ratio * p.stiffness)


def impact(
    p: ChuteParameters,
    radii: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    steps: int,
    convention: Convention,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity (m/s) of a sphere after its impact, and all spins (1/s).

    A pair is looked at in the frame of its centre of mass, which falls.

    Parameters
    ----------
    p : ChuteParameters
        The law, and the time step (s) of the leap-frog.
    radii : (1,) or (2,) array
        Of the sphere and its partner of the same density (m); one alone meets the plane z = 0.
    position, velocity : (3,) arrays
        Of the sphere (m, m/s), which does not spin; relative to the centre of mass or the plane.
        The velocity is that half a step before the position, the one returned belongs to the end.
    steps : int
        Time steps.
    convention : Convention
        The engine's.
    """
    pair = len(radii) == 2
    friction = p.friction if pair else p.friction_plane
    masses = p.mass * (2.0 * radii / p.diameter) ** 3
    mass, radius = (1.0 / (1.0 / of_both).sum() for of_both in (masses, radii))
    # The partner moves as the mirror image of the sphere, but for its mass.
    whole, shortened = masses[0] / mass, convention.shortened if pair else 0.0
    weight = np.array([0.0, 0.0, 0.0 if pair else -p.gravity])
    x, v, rims, history = position.copy(), velocity.copy(), np.zeros((len(radii), 3)), np.zeros(3)
    falls, before = p.tangential_unloading == "rescaled", 0.0
    for _ in range(steps):
        separation = -whole * x if pair else np.array([0.0, 0.0, -x[2]])
        distance = float(np.linalg.norm(separation))
        normal, overlap, force = separation / distance, radii.sum() - distance, np.zeros(3)
        if overlap > 0.0:
            surface = -whole * v - np.cross(rims.sum(axis=0), normal)
            approach, law = -surface @ normal, springs(p, overlap, radius, mass)
            pressure = law.normal * overlap + law.damping * approach
            pressure = max(pressure, 0.0) if p.attraction == "clipped" else pressure
            if falls and law.tangential < before:
                history = history * law.tangential / before
            before = law.tangential
            slip = (surface + approach * normal) * p.time_step
            drag = p.tangential_damping * mass * slip / p.time_step
            history = turned(history, normal, convention.rescaled) + law.tangential * slip
            along = history + drag
            along *= min(1.0, friction * abs(pressure) / (np.linalg.norm(along) or inf))
            history, force = along - drag, along - pressure * normal
            arms = (1.0 - shortened * overlap / radii) / (0.4 * masses)
            rims += arms[:, None] * np.cross(normal, along) * p.time_step
        else:
            history, before = np.zeros(3), 0.0
        v = v + (force / masses[0] + weight) * p.time_step
        x = x + v * p.time_step
    return v + 0.5 * weight * p.time_step, rims / radii[:, None]


def turned(history: np.ndarray, normal: np.ndarray, rescaled: bool) -> np.ndarray:
    """Return a tangential force (N) turned into the plane across ``normal``."""
    within = history - (history @ normal) * normal
    size = np.linalg.norm(within)
    if rescaled and size > 0.0:
        within *= np.linalg.norm(history) / size
    return within
