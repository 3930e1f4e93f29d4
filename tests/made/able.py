"""A law that does all that a law can: it rolls, twists, reaches and remembers a vector.

A linear spring and dashpot; a tangential spring, the vector, beside a dashpot; springs against
rolling and twisting, cut to an arm times the force of the spring; a bridge that begins with the
contact, pulls with one force and breaks at a length.
"""

from math import log, pi, sqrt
from typing import NamedTuple

import talus


class Able(NamedTuple):
    """Stiffness (N/m), √K times twice the damping ratio over the time step, tangential stiffness
    (N/m), γ over the time step (1/s²), friction, resistance to rolling (N m), its arm (m), the pull
    (N) and the length (m) of a bridge."""

    stiffness: float
    damping: float
    tangential: float
    shear: float
    friction: float
    rolling: float
    arm: float
    pull: float
    length: float


def make(p, partners):
    """Return the law of a point."""
    beta = -log(p.restitution) / sqrt(log(p.restitution) ** 2 + pi**2)
    return Able(
        float(p.stiffness),
        2 * beta * sqrt(p.stiffness) / partners.time_step,
        p.tangential_ratio * p.stiffness,
        p.side_damping / partners.time_step,
        float(partners.friction),
        0.1 * p.stiffness * p.diameter**2,
        p.rolling_arm * p.diameter,
        p.bridge_pull * p.mass * p.gravity,
        p.bridge_length * p.diameter,
    )


def force(law, overlap, approach, slip, tangential, memory, radius, mass, rolling, torque):
    """Return what a law that rolls does."""
    touches = 1.0 if overlap > 0.0 else 0.0
    wet = touches
    if overlap > -law.length:
        wet = max(touches, memory[3])
    press = law.stiffness * max(overlap, 0.0)
    drag = touches * law.damping * sqrt(mass) * approach
    before = memory[4] if memory[4] != 0.0 else drag
    lost = 0.5 * (before + drag) * approach
    lost += law.pull * (wet - memory[3]) * (overlap - 0.5 * approach)

    x = memory[0] + law.tangential * slip[0]
    y = memory[1] + law.tangential * slip[1]
    z = memory[2] + law.tangential * slip[2]
    size, limit = sqrt(x * x + y * y + z * z), law.friction * press
    share = limit / size if size > limit else 1.0
    spring = (x * share, y * share, z * share)
    side = touches * law.shear * mass
    along = (spring[0] + side * slip[0], spring[1] + side * slip[1], spring[2] + side * slip[2])

    x = torque[0] + law.rolling * rolling[0]
    y = torque[1] + law.rolling * rolling[1]
    z = torque[2] + law.rolling * rolling[2]
    size, limit = sqrt(x * x + y * y + z * z), law.arm * press
    share = limit / size if size > limit else 1.0
    twist = min(max(torque[3] + law.rolling * rolling[3], -limit), limit)
    resists = (x * share, y * share, z * share, twist)
    return press + drag - law.pull * wet, along, (*spring, wet, drag), lost, resists


def energy(law, overlap, tangential, memory, radius, mass, torque):
    """Return the energy in the normal spring and the bridge, and in all other springs."""
    pressed = 0.5 * law.stiffness * max(overlap, 0.0) ** 2 - law.pull * memory[3] * overlap
    sheared = 0.5 * (memory[0] ** 2 + memory[1] ** 2 + memory[2] ** 2) / law.tangential
    rolled = torque[0] ** 2 + torque[1] ** 2 + torque[2] ** 2 + torque[3] ** 2
    return pressed, sheared + 0.5 * rolled / law.rolling


def reach(p):
    """Return a little more than the length of a bridge, which is told that it breaks."""
    return 1.2 * p.bridge_length * p.diameter


def collision_time(p):
    """Return the time in which the lightest partners press the spring and are pressed off."""
    beta = -log(p.restitution) / sqrt(log(p.restitution) ** 2 + pi**2)
    return pi * sqrt(p.lightest_mass / 2 / p.stiffness / (1 - beta**2))


talus.law(
    "able",
    description="all that a law can do",
    make=make,
    force=force,
    energy=energy,
    collision_time=collision_time,
    remembers=5,
    turns=1,
    rolls=True,
    reach=reach,
    parameters={
        name: talus.parameter(0, unit=unit, description=description, ge=0)
        for name, unit, description in (
            ("side_damping", "s-1", "tangential damping over the reduced mass"),
            ("rolling_arm", "1", "arm of the resistance to rolling and twisting, in diameters"),
            ("bridge_pull", "1", "pull of a bridge, in weights of a particle"),
            ("bridge_length", "1", "length at which a bridge breaks, in diameters"),
        )
    },
)
