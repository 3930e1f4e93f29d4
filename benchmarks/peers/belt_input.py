"""The vibrating belt as LAMMPS commands: disks in the frame of the belt, which then stands still.

Forces depend on relative velocities alone, so the frame changes nothing but gravity, which gets the
belt's acceleration with the opposite sign. A moving wall (``fix wall/gran/region``) is slower.
"""

from math import cos, pi, radians, sin, sqrt, tan

import numpy as np

from benchmarks.peers.settings import Settings
from sim.parameters import BeltParameters

#: Height of the cell at first (it grows with the highest bead) and half its thickness, in mean
#: diameters.
CEILING = 100.0
THICKNESS = 0.5

#: At high frequency (Hz) the soft spring lets the centre of a small bead through the belt, where
#: LAMMPS would push it on downwards; there it is thrown back.
RESCUE_ABOVE = 50.0
RESCUE = "fix rescue all wall/reflect ylo 0"

#: LAMMPS' largest friction coefficient, which never cuts the tangential damping.
NO_LIMIT = 10000


def belt_amplitudes(p: BeltParameters) -> tuple[float, float]:
    """Return the amplitudes (m) of the belt along x and z."""
    upward = p.amplitude * p.diameter
    return upward / tan(radians(p.vibration_angle)), upward


def belt_state(p: BeltParameters, snapshot: dict, phase: float) -> dict:
    """Return the disks as LAMMPS takes them (SI), where they are relative to a belt of this phase.

    Their velocities are those of the laboratory: a belt that starts shaking changes the frame.
    """
    position = snapshot["position"] - np.array(belt_amplitudes(p)) * sin(phase)
    position[:, 0] %= p.width * p.diameter
    flat = np.zeros((len(position), 1))
    return {
        "position": np.hstack([position, flat]),
        "velocity": np.hstack([snapshot["particle_velocity"], flat]),
        "spin": np.zeros((len(position), 3)),
        "radius": snapshot["radius"],
        "mass": p.mass * (2.0 * snapshot["radius"] / p.diameter) ** 2,
    }


def resting_request(p: BeltParameters, settings: Settings) -> dict:
    """Return what `worker.Worker.setup` needs, but for the particles, to settle on a resting belt.

    LAMMPS damps by the reduced mass, half of a bead's own for equal beads, hence the doubled rates
    of a pair; the belt meets the whole mass.
    """
    width, height = p.width * p.diameter, CEILING * p.diameter
    half = THICKNESS * p.diameter
    stiffness = p.stiffness * p.gravity * p.mass / p.diameter
    normal, shear = p.damping * p.gravity, p.shear_damping * p.gravity
    before = [
        "units si",
        f"newton {'on' if settings.newton else 'off'}",
        "dimension 2",
        "atom_style sphere",
        f"atom_modify sort {settings.sort} 0",
        "boundary p fs p",
        "comm_modify vel yes",
        "timer off",
        f"region cell block 0 {width:.17g} 0 {height:.17g} {-half:.17g} {half:.17g}",
        "create_box 1 cell",
    ]
    after = [
        *settings.list_commands(p.diameter),
        f"pair_style gran/hooke {stiffness:.17g} 0 {2 * normal:.17g} {2 * shear:.17g} {NO_LIMIT} 1",
        "pair_coeff * *",
        f"fix weight all gravity {p.gravity:.17g} vector 0 -1 0",
        f"fix belt all wall/gran granular hooke {stiffness:.17g} {normal:.17g} "
        f"damping mass_velocity tangential linear_nohistory "
        f"{shear / normal if normal else 0.0:.17g} {NO_LIMIT} yplane 0 NULL",
        "fix motion all nve",
        *([RESCUE] if p.frequency > RESCUE_ABOVE else []),
        f"timestep {p.settling_step:.17g}",
        "compute contacts all contact/atom",
        "thermo_modify lost error",
        "thermo_style custom step",
        # The variable of the shaking would make LAMMPS compute these in every step.
        "uncompute thermo_press",
        "uncompute thermo_pe",
        "thermo 0",
    ]
    return {"arguments": settings.arguments(), "floor": 1, "before": before, "after": after}


def shaking(p: BeltParameters, phase: float) -> list[str]:
    """Return the commands that shake the belt from this phase (rad) on.

    The belt's velocity is taken from all beads, and its acceleration joins gravity.
    """
    along, upward = belt_amplitudes(p)
    angular = 2.0 * pi * p.frequency
    peak = sqrt(along**2 + upward**2) * angular**2
    speed = angular * cos(phase)
    return [
        "reset_timestep 0",
        f"timestep {p.time_step:.17g}",
        f"velocity all set {-along * speed:.17g} {-upward * speed:.17g} NULL sum yes",
        # Read anew in every step, so its length counts: ten digits suffice.
        f"variable shaking equal {peak:.10g}*sin({phase:.10g}+{angular * p.time_step:.10g}*step)",
        f"fix shaking all gravity v_shaking vector {along:.17g} {upward:.17g} 0",
    ]


def belt_request(p: BeltParameters, phase: float, settings: Settings) -> dict:
    """Return what `worker.Worker.setup` needs, but for the particles, to go on at this phase."""
    request = resting_request(p, settings)
    return request | {"after": request["after"] + shaking(p, phase)}
