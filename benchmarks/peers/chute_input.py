"""The chute as LAMMPS commands: springs with dashpots, Coulomb friction, a frictional plane."""

from math import cos, radians, sin

import numpy as np

from benchmarks.peers.settings import Settings
from sim.engines.lammps.deck import damping_rate
from sim.parameters import ChuteParameters

#: Height of the cell above the highest particle at first (it follows it), in diameters.
HEADROOM = 1.0

#: Tangential stiffness and damping rate over the normal ones.
TANGENTIAL, SHEAR_DAMPING = 2.0 / 7.0, 0.5


def contact_commands(p: ChuteParameters) -> tuple[list[str], str]:
    """Return the commands of the pairs' law, and the plane's as ``fix wall/gran`` takes it.

    LAMMPS does not have Walton and Braun's law: these are the usual choices of its manual. The
    plane meets a particle with its whole mass, a partner with half of it, hence two rates.
    """
    pair, plane = damping_rate(p, 0.5 * p.mass), damping_rate(p, p.mass)
    tangential = TANGENTIAL * p.stiffness
    pairs = [
        f"pair_style gran/hooke/history {p.stiffness:.17g} {tangential:.17g} {pair:.17g} "
        f"{SHEAR_DAMPING * pair:.17g} {p.friction:.17g} 1",
        "pair_coeff * *",
    ]
    return pairs, (
        f"hooke {p.stiffness:.17g} {plane:.17g} damping mass_velocity tangential linear_history "
        f"{tangential:.17g} {SHEAR_DAMPING:g} {p.friction_plane:.17g}"
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
