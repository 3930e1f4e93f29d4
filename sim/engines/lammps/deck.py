"""A point as commands and data of LAMMPS: laws, plane, gravity, and its particles.

Laws are said in the styles whose single impacts have the digits of ours, see
docs/second_engine.md.
"""

from io import StringIO
from math import cos, exp, pi, radians, sin, sqrt
from typing import Any

import numpy as np

from sim.engine.boundary.drive import tilt_of
from sim.laws.hertz import effective_modulus
from sim.parameters.dashpot import by_restitution, damping_fraction
from sim.parameters.spheres import SKIN, SphereParameters

#: Height of the cell above the highest particle at first (it follows it), in diameters.
HEADROOM = 1.0

#: Its largest friction coefficient, which never cuts a drag.
NO_LIMIT = 10000

#: Types of its particles.
MOBILE, GLUED = 1, 2


def damping_rate(p: SphereParameters, mass: float) -> float:
    """Return γ (1/s) of F = K α + m γ dα/dt, given or that of the restitution."""
    if p.normal_damping:
        return p.normal_damping
    share, whole = damping_fraction(p.restitution, p.attraction)
    return 2.0 * sqrt(p.stiffness / mass) * share / whole


def unclipped_restitution(p: SphereParameters) -> float:
    """Return the restitution that the damping of a point gives where it may pull.

    That of a clipped force has to be less than critical for it.
    """
    if p.attraction == "kept":
        return p.restitution
    ratio, _ = damping_fraction(p.restitution, p.attraction)
    return exp(-pi * ratio / sqrt(1.0 - ratio**2))


def contact_commands(p: SphereParameters) -> tuple[list[str], str]:
    """Return the commands of the pairs' law, and the plane's as ``fix wall/gran`` takes it.

    The plane meets a particle with its whole mass, a partner with half of it: two rates.
    """
    if by_restitution(p):
        law = _hertz if p.law == "hertz" else _hooke
        pairs = ["pair_style granular", f"pair_coeff * * {law(p, p.friction)}"]
        return pairs, f"granular {law(p, p.friction_plane)}"
    clip = _clip(p)
    pair_rate, rate = damping_rate(p, 0.5 * p.mass), damping_rate(p, p.mass)
    tangential, shear = p.tangential_ratio * p.stiffness, p.shear_damping * p.gravity
    damping = p.tangential_damping
    if p.law == "drag":
        style = f"hooke {p.stiffness:.17g} 0 {pair_rate:.17g} {shear:.17g} {NO_LIMIT} 1"
        along = f"linear_nohistory {shear / rate:.17g} {NO_LIMIT}"
    else:
        springs = f"{p.stiffness:.17g} {tangential:.17g} {pair_rate:.17g}"
        style = f"hooke/history {springs} {damping:.17g} {p.friction:.17g} 1{clip}"
        share = damping / rate if damping else 0.0
        along = f"linear_history {tangential:.17g} {share:.17g} {p.friction_plane:.17g}"
    # The styles of these pairs have a plane, too, which does not move as it is told.
    plane = f"granular hooke {p.stiffness:.17g} {rate:.17g} damping mass_velocity tangential"
    return [f"pair_style gran/{style}", "pair_coeff * *"], f"{plane} {along}{clip}"


def _clip(p: SphereParameters) -> str:
    return " limit_damping" if p.attraction == "clipped" else ""


def _hooke(p: SphereParameters, friction: float) -> str:
    """Return the linear law that finds the damping of each pair from the restitution."""
    return (
        f"hooke {p.stiffness:.17g} {unclipped_restitution(p):.17g} damping coeff_restitution "
        f"tangential linear_history {p.tangential_ratio * p.stiffness:.17g} 0 {friction:.17g}"
        f"{_clip(p)}"
    )


def _hertz(p: SphereParameters, friction: float) -> str:
    """Return the law of material with Young's modulus and ν, of which the plane is, too.

    Its ``damping tsuji`` takes the restitution into a polynomial whose damping is too weak; that of
    ``coeff_restitution`` is ours.
    """
    poisson = 2.0 * (1.0 - p.tangential_share) / (2.0 - p.tangential_share)
    modulus = 2.0 * (1.0 - poisson**2) * effective_modulus(p)
    along = "mindlin" if p.tangential_unloading == "kept" else "mindlin_rescale"
    return (
        f"hertz/material {modulus:.17g} {unclipped_restitution(p):.17g} {poisson:.17g} "
        f"damping coeff_restitution tangential {along}/force NULL 0 {friction:.17g}{_clip(p)}"
    )


def frame_speed(p: SphereParameters) -> float:
    """Return the velocity (m/s) along x of the frame in which LAMMPS computes, for speed.

    There, particles move less from one list of neighbors to the next. A plane with bumps rests.
    """
    return 0.0 if p.bumps else p.initial_velocity * p.velocity_unit


def drive_commands(p: Any, time_step: float) -> list[str]:
    """Return the commands of gravity, and of the acceleration of a frame that moves with the plane.

    The acceleration is that from half a step before to half a step after a time, as ours.
    """
    commands = _gravity_commands(p, time_step)
    if p.system == "conveyor":
        rate = 2.0 * pi * p.frequency
        first, second = radians(p.phase_along), radians(p.overtone_phase)
        waves = {
            "x": [(p.amplitude_along, 1, first), (p.overtone_along, p.overtone, second)],
            "z": [(p.amplitude, 1, 0.0), (p.overtone_amplitude, p.overtone, second)],
        }
        for axis, vector in {"x": "1 0 0", "z": "0 0 1"}.items():
            terms = [
                _wave(a * p.diameter, n * rate, phase, time_step) for a, n, phase in waves[axis]
            ]
            commands += [
                f"variable shaking_{axis} equal {'+'.join(terms)}",
                f"fix shaking_{axis} mobile gravity v_shaking_{axis} vector {vector}",
            ]
    return commands


def _gravity_commands(p: Any, time_step: float) -> list[str]:
    """Return the commands of gravity, whose direction may be a function of the step."""
    fix = f"fix weight mobile gravity {p.gravity:.17g} vector"
    tilt = tilt_of(p, round(p.sample_steps * p.time_step / time_step))
    if not tilt:
        angle = radians(p.angle)
        return [f"{fix} {sin(angle):.17g} 0 {-cos(angle):.17g}"]
    steps, angles = tilt.steps.astype(int), np.radians(tilt.angles)
    parts = [f"(step<{steps[0]})*{angles[0]:.17g}", f"(step>={steps[-1]})*{angles[-1]:.17g}"]
    for k in np.flatnonzero(np.diff(steps)):
        rate = (angles[k + 1] - angles[k]) / (steps[k + 1] - steps[k])
        within = f"(step>={steps[k]})*(step<{steps[k + 1]})"
        parts.append(f"{within}*({angles[k]:.17g}+{rate:.17g}*(step-{steps[k]}))")
    return [
        f"variable slope equal {'+'.join(parts)}",
        "variable slope_x equal sin(v_slope)",
        "variable slope_z equal -cos(v_slope)",
        f"{fix} v_slope_x 0 v_slope_z",
    ]


def _wave(amplitude: float, rate: float, phase: float, time_step: float) -> str:
    peak = 2.0 * amplitude * rate * sin(0.5 * rate * time_step) / time_step
    return f"{peak:.17g}*sin({rate * time_step:.17g}*step+{phase:.17g})"


def deck(p: Any, time_step: float, start: str, is_restart: bool) -> list[str]:
    """Return the commands that set up a point; ``run N`` follows.

    ``time_step`` is in s. ``start`` names the file with the particles: data, or a restart, from
    which the flow goes on, where ``is_restart``.
    """
    pairs, plane = contact_commands(p)
    speed = frame_speed(p)
    drift = f" shear x {-speed:.17g}" if speed else ""
    style = ["units si", "newton on", "atom_style sphere", "boundary p p fs"]
    return [
        *([] if is_restart else style),
        "processors * * 1",
        "comm_modify vel yes",
        f"{'read_restart' if is_restart else 'read_data'} {start}",
        "timer off",
        f"neighbor {SKIN * p.diameter:.17g} bin",
        "neigh_modify delay 0 every 1 check yes",
        f"group mobile type {MOBILE}",
        *pairs,
        *drive_commands(p, time_step),
        f"fix plane mobile wall/gran {plane} zplane 0 NULL{drift}",
        f"fix motion mobile {'nve/sphere' if getattr(p, 'rotation', True) else 'nve'}",
        *([f"group glued type {GLUED}", "fix glue glued freeze"] if p.bumps else []),
        f"timestep {time_step:.17g}",
        "thermo_style custom step atoms",
        "thermo_modify lost error",
        "thermo 0",
    ]


def particle_data(p: Any, spheres: Any, velocity: np.ndarray) -> str:
    """Return the data file of particles in their initial state.

    ``spheres`` (`sim.engine.dynamics.spheres.Spheres`) are in the order of their labels, those
    without mass glued; ``velocity`` (3, N) is at the time of the positions, in the frame of LAMMPS
    (m/s).
    """
    along, across = p.cell * p.diameter, p.breadth * p.diameter
    (x, y, z), radius = spheres.position, spheres.radius
    number, is_glued = np.arange(1, radius.size + 1), spheres.mass == 0.0
    kind = np.where(is_glued, GLUED, MOBILE)
    material = p.mass / p.diameter**3
    mass = np.where(is_glued, material * (2.0 * radius) ** 3, spheres.mass)
    density = mass / (4.0 / 3.0 * pi * radius**3)
    top = z.max() + HEADROOM * p.diameter
    text = StringIO()
    text.write(
        f"particles of Talus\n\n{radius.size} atoms\n{GLUED} atom types\n\n"
        f"0 {along:.17g} xlo xhi\n0 {across:.17g} ylo yhi\n0 {top:.17g} zlo zhi\n\n"
        "Atoms # sphere\n\n"
    )
    place = np.column_stack([number, kind, 2.0 * radius, density, x % along, y % across, z])
    np.savetxt(text, place, "%d %d %.17g %.17g %.17g %.17g %.17g")
    text.write("\nVelocities\n\n")
    motion = np.column_stack([number, *velocity, *(spheres.rim / radius)])
    np.savetxt(text, motion, "%d" + 6 * " %.17g")
    return text.getvalue()
