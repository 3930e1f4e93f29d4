"""One impact in plain Python, with the one convention in which the engines differ as a choice."""

from math import inf, log, pi, sqrt

import numpy as np

from sim.parameters import ChuteParameters


def damping_constant(p: ChuteParameters, mass: float) -> float:
    """Return c (kg/s) of F = K α + c dα/dt for this restitution and reduced mass (kg)."""
    lost = -log(p.restitution)
    return 2.0 * lost / sqrt(pi**2 + lost**2) * sqrt(p.stiffness * mass)


def impact(
    p: ChuteParameters,
    partner: str,
    position: np.ndarray,
    velocity: np.ndarray,
    steps: int,
    rescaled: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity (m/s) and spin (1/s) of sphere i after its impact.

    A pair is looked at in the frame that falls with it.

    Parameters
    ----------
    p : ChuteParameters
        The law, and the time step (s) of the leap-frog.
    partner : str
        ``pair``: an equal sphere with the opposite velocity; ``plane``: the plane z = 0.
    position, velocity : (3,) arrays
        Of sphere i (m, m/s), which does not spin; relative to the centre of mass or the plane.
        The velocity is that half a step before the position, the one returned belongs to the end.
    steps : int
        Time steps.
    rescaled : bool
        Whether the tangential force keeps its size when it is turned into the new tangent plane, as
        in Talus, or only its part within that plane, as in ``gran/hooke/history`` of LAMMPS.
    """
    pair = partner == "pair"
    mass, friction = (0.5 * p.mass, p.friction) if pair else (p.mass, p.friction_plane)
    damping, stiffness = damping_constant(p, mass), p.tangential_ratio * p.stiffness
    radius, inertia = 0.5 * p.diameter, 0.1 * p.mass * p.diameter**2
    weight = np.array([0.0, 0.0, 0.0 if pair else -p.gravity])
    x, v, spin, history = position.copy(), velocity.copy(), np.zeros(3), np.zeros(3)
    for _ in range(steps):
        # From i to its partner, whose motion is the mirror image of that of i.
        separation = -2.0 * x if pair else np.array([0.0, 0.0, -x[2]])
        distance = float(np.linalg.norm(separation))
        normal, overlap = separation / distance, (p.diameter if pair else radius) - distance
        force, torque = np.zeros(3), np.zeros(3)
        if overlap > 0.0:
            relative = -2.0 * v if pair else -v
            surface = relative - np.cross((2.0 if pair else 1.0) * radius * spin, normal)
            approach = -surface @ normal
            pressure = p.stiffness * overlap + damping * approach
            slip = (surface + approach * normal) * p.time_step
            history = turned(history, normal, rescaled) + stiffness * slip
            history *= min(1.0, friction * abs(pressure) / (np.linalg.norm(history) or inf))
            force = history - pressure * normal
            torque = radius * np.cross(normal, history)
        else:
            history = np.zeros(3)
        v = v + (force / p.mass + weight) * p.time_step
        spin = spin + torque / inertia * p.time_step
        x = x + v * p.time_step
    return v + 0.5 * weight * p.time_step, spin


def turned(history: np.ndarray, normal: np.ndarray, rescaled: bool) -> np.ndarray:
    """Return a tangential force (N) turned into the plane across ``normal``."""
    within = history - (history @ normal) * normal
    size = np.linalg.norm(within)
    if rescaled and size > 0.0:
        within *= np.linalg.norm(history) / size
    return within
