"""A contact law: Hertz's and Mindlin's, with resistance to rolling, as of grains with edges.

A spring against the relative rotation is cut to the torque μ_r R* F_N, the normal force at an arm;
its stiffness is 2.25 K1 (μ_r R*)² (Ai, Chen, Rotter and Ooi, Powder Technol. 206 (2011) 269, model
C; stiffness as in LIGGGHTS).
"""

from math import sqrt
from typing import NamedTuple

import talus
from talus.laws.hertz import collision_time
from talus.laws.hertz import energy as hertz_energy
from talus.laws.hertz import force as hertz_force
from talus.laws.hertz import make as make_hertz


class Rolling(NamedTuple):
    """The numbers of `hertz`; the stiffness K1 (N/m) and the rolling friction μ_r."""

    modulus: float
    tangential: float
    damping: float
    friction: float
    stiffness: float
    arm: float


def make(p, partners):
    """Return the law of a point."""
    return Rolling(*make_hertz(p, partners), p.stiffness, p.rolling_friction)


def force(law, overlap, approach, slip, tangential, memory, radius, mass, rolling, torque):
    """Compiled: what `hertz` returns, and the torque."""
    normal, along, numbers, lost = hertz_force(
        law, overlap, approach, slip, tangential, memory, radius, mass
    )
    arm = law.arm * radius
    spring = 2.25 * law.stiffness * arm**2
    x = torque[0] + spring * rolling[0]
    y = torque[1] + spring * rolling[1]
    z = torque[2] + spring * rolling[2]
    size = sqrt(x * x + y * y + z * z)
    cut = min(1.0, arm * abs(normal) / size) if size > 0.0 else 0.0
    return normal, along, numbers, lost, (x * cut, y * cut, z * cut, 0.0)


def energy(law, overlap, tangential, memory, radius, mass, torque):
    """Return what the normal spring has stored, and all others."""
    pressed, sheared = hertz_energy(law, overlap, tangential, memory, radius, mass)
    bent = torque[0] ** 2 + torque[1] ** 2 + torque[2] ** 2
    spring = 2.25 * law.stiffness * (law.arm * radius) ** 2
    return pressed, sheared + (0.5 * bent / spring if spring > 0.0 else 0.0)


talus.law(
    "rolling",
    description="that of Hertz and Mindlin with resistance to rolling, Ai et al.",
    make=make,
    force=force,
    energy=energy,
    collision_time=collision_time,
    remembers=1,
    rolls=True,
    parameters={
        "rolling_friction": talus.parameter(
            0.1, symbol="μ_r", unit="1", description="coefficient of rolling friction", ge=0
        )
    },
)
