"""The chute as LAMMPS commands: springs with dashpots, Coulomb friction, a frictional plane."""

from math import cos, log, pi, radians, sin, sqrt

import numpy as np

from benchmarks.peers.settings import Settings
from sim.laws.hertz import effective_modulus
from sim.parameters import ChuteParameters

#: Height of the cell above the highest particle at first (it follows it), in diameters.
HEADROOM = 1.0


def damping_rate(stiffness: float, mass: float, restitution: float) -> float:
    """Return γ (1/s) of F = K δ - m γ v that gives this restitution where the overlap ends."""
    lost = -log(restitution)
    return 2.0 * sqrt(stiffness / mass) * lost / sqrt(pi**2 + lost**2)


def tangential_model(p: ChuteParameters) -> tuple[float, float]:
    """Return K_t (N/m) and the tangential damping rate over the normal one.

    Spring and dashpot are our very law. For Walton and Braun's, which LAMMPS does not have, these
    are the usual choices of its manual.
    """
    if p.law == "spring_dashpot":
        return p.tangential_ratio * p.stiffness, 0.0
    return 2.0 / 7.0 * p.stiffness, 0.5


def hertz_model(p: ChuteParameters, friction: float) -> str:
    """Return our law ``hertz`` as LAMMPS says it, of material with Young's modulus and ν.

    Its ``damping tsuji`` takes the restitution into a polynomial whose damping is too weak; that of
    ``coeff_restitution`` is ours. The plane is of the same material.
    """
    poisson = 2.0 * (1.0 - p.tangential_ratio) / (2.0 - p.tangential_ratio)
    modulus = 2.0 * (1.0 - poisson**2) * effective_modulus(p)
    return (
        f"hertz/material {modulus:.17g} {p.restitution:.17g} {poisson:.17g} "
        f"damping coeff_restitution tangential mindlin/force NULL 0 {friction:.17g}"
    )


def contact_commands(p: ChuteParameters) -> tuple[list[str], str]:
    """Return the commands of the pairs' law, and the plane's as ``fix wall/gran`` takes it.

    The plane meets a particle with its whole mass, a partner with half of it, hence two rates.
    """
    if p.law == "hertz":
        pairs = ["pair_style granular", f"pair_coeff * * {hertz_model(p, p.friction)}"]
        return pairs, hertz_model(p, p.friction_plane)
    pair = damping_rate(p.stiffness, 0.5 * p.mass, p.restitution)
    plane = damping_rate(p.stiffness, p.mass, p.restitution)
    tangential, shear_damping = tangential_model(p)
    pairs = [
        f"pair_style gran/hooke/history {p.stiffness:.17g} {tangential:.17g} {pair:.17g} "
        f"{shear_damping * pair:.17g} {p.friction:.17g} 1",
        "pair_coeff * *",
    ]
    return pairs, (
        f"hooke {p.stiffness:.17g} {plane:.17g} damping mass_velocity tangential linear_history "
        f"{tangential:.17g} {shear_damping:g} {p.friction_plane:.17g}"
    )


def frame_velocity(velocity: np.ndarray, frame: str) -> float:
    """Return the velocity (m/s) of the frame of reference along x."""
    along = velocity[:, 0]
    if frame == "rest":
        return 0.0
    return float(along.mean() if frame == "mean" else 0.5 * (along.min() + along.max()))


def chute_state(p: ChuteParameters, snapshot: dict, settings: Settings) -> dict:
    """Return the particles as LAMMPS takes them: within the cell, in the chosen frame (SI)."""
    side = p.cell * p.diameter
    position, velocity = snapshot["position"].copy(), snapshot["particle_velocity"].copy()
    position[:, :2] %= side
    velocity[:, 0] -= frame_velocity(velocity, settings.frame)
    return {
        "position": position,
        "velocity": velocity,
        "spin": snapshot["particle_spin"],
        "radius": snapshot["radius"],
        "mass": p.mass * (2.0 * snapshot["radius"] / p.diameter) ** 3,
    }


def chute_request(p: ChuteParameters, snapshot: dict, settings: Settings) -> dict:
    """Return what `worker.Worker.setup` needs, but for the particles."""
    side = p.cell * p.diameter
    top = snapshot["position"][:, 2].max() + HEADROOM * p.diameter
    pairs, plane = contact_commands(p)
    drift = frame_velocity(snapshot["particle_velocity"], settings.frame)
    angle = radians(p.angle)
    before = [
        "units si",
        f"newton {'on' if settings.newton else 'off'}",
        "atom_style sphere",
        f"atom_modify sort {settings.sort} 0",
        "boundary p p fs",
        "comm_modify vel yes",
        "timer off",
        f"region cell block 0 {side:.17g} 0 {side:.17g} 0 {top:.17g}",
        "create_box 1 cell",
    ]
    after = [
        *settings.list_commands(p.diameter),
        *pairs,
        f"fix weight all gravity {p.gravity:.17g} vector {sin(angle):.17g} 0 {-cos(angle):.17g}",
        f"fix plane all wall/gran granular {plane} zplane 0 NULL shear x {-drift:.17g}",
        "fix motion all nve/sphere",
        f"timestep {p.time_step:.17g}",
        "compute contacts all contact/atom",
        "thermo_modify lost error",
        "thermo 0",
    ]
    return {"arguments": settings.arguments(), "floor": 2, "before": before, "after": after}
