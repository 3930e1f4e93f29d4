"""A contact law: Hertz-Mindlin for spheres of any sizes, with damping that gives one restitution.

Normal force: Hertz's 4/3 E* √R* α^(3/2), and a dashpot of 2 √(5/6) β √(S m*) with the stiffness
S = 2 E* √(R* α). Tangential force: Mindlin's stiffness 8 G* √(R* α) without slip, cut to the
friction limit. β follows from the restitution e (Tsuji, Tanaka and Ishida 1992; as in LIGGGHTS).
"""

from math import log, pi, sqrt
from typing import NamedTuple

import talus


class HertzMindlin(NamedTuple):
    """E* and G* (Pa), damping 2 √(5/6) β over the time step (1/s), friction."""

    modulus: float
    shear_modulus: float
    damping: float
    friction: float


def make(p, partners):
    """Return the law of a point; plane and spheres are of one material."""
    nu = p.grain_poisson
    beta = -log(p.restitution) / sqrt(log(p.restitution) ** 2 + pi**2)
    return HertzMindlin(
        p.grain_modulus / (2 * (1 - nu**2)),
        p.grain_modulus / (4 * (1 + nu) * (2 - nu)),
        2 * sqrt(5 / 6) * beta / partners.time_step,
        partners.friction,
    )


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Compiled: plain arithmetic on numbers and tuples."""
    edge = sqrt(radius * max(overlap, 0.0))
    elastic = 4 / 3 * law.modulus * edge * overlap
    drag = law.damping * sqrt(2 * law.modulus * edge * mass) * approach
    normal = elastic + drag
    spring = 8 * law.shear_modulus * edge
    tx = tangential[0] + spring * slip[0]
    ty = tangential[1] + spring * slip[1]
    tz = tangential[2] + spring * slip[2]
    size = sqrt(tx * tx + ty * ty + tz * tz)
    limit = law.friction * abs(normal)
    scale = min(1.0, limit / size) if size > 0.0 else 0.0
    lost = 0.5 * (memory[0] + drag) * approach
    return normal, (tx * scale, ty * scale, tz * scale), (drag,), lost


def energy(law, overlap, tangential, memory, radius, mass):
    """Return what both springs have stored."""
    edge = sqrt(radius * max(overlap, 0.0))
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    spring = 8 * law.shear_modulus * edge
    pressed = 8 / 15 * law.modulus * edge * overlap**2
    return pressed, 0.5 * square / spring if spring > 0.0 else 0.0


def collision_time(p):
    """Return how long the lightest spheres collide at ten times the velocity unit, Hertz's 2.87."""
    spread = p.diameter_spread
    size = (1 - spread) / (1 + spread**2) ** (1 / 3)
    mass, radius = p.mass * size**3 / 2, p.diameter * size / 4
    modulus = p.grain_modulus / (2 * (1 - p.grain_poisson**2))
    speed = 10 * p.velocity_unit
    return 2.87 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2


talus.law(
    "hertz_mindlin",
    description="Hertz and Mindlin for spheres of any sizes, with a damping of Tsuji et al.",
    make=make,
    force=force,
    energy=energy,
    remembers=1,
    collision_time=collision_time,
    parameters={
        "grain_modulus": talus.parameter(
            1e6, symbol="E", unit="Pa", description="Young's modulus", gt=0
        ),
        "grain_poisson": talus.parameter(
            0.3, symbol="ν", unit="1", description="Poisson's ratio", ge=0, le=0.5
        ),
    },
)
