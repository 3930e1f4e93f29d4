"""Hertz's normal force, Mindlin's tangential stiffness, a dashpot with a constant restitution.

With the normal stiffness S = 2 E* √(R* α): F_N = (2/3) S α + 2 √(5/6) β √(S m*) dα/dt. With
β = -ln e/√(π² + ln² e) the restitution is e at every velocity and size (Tsuji, Tanaka and
Ishida, Powder Technol. 71 (1992) 239). The tangential stiffness is a constant share of S, 2(1 - ν)
/(2 - ν) of spheres with Poisson's ratio ν (Mindlin, J. Appl. Mech. 16 (1949) 259), and its force is
cut to μ |F_N|.
"""

from math import log, pi, sqrt
from typing import NamedTuple

from sim.engine.contact import Partners
from sim.engine.contact.own import add_functions
from sim.parameters.spheres import SphereParameters


class Hertz(NamedTuple):
    """``modulus`` E* (Pa); ``tangential`` stiffness relative to the normal one; ``damping``
    2 √(5/6) β over the time step (1/s); ``friction`` μ."""

    modulus: float
    tangential: float
    damping: float
    friction: float


def from_parameters(p: SphereParameters, partners: Partners) -> Hertz:
    """Return the law of a point for one kind of partners; plane and spheres are of one material."""
    decay = -log(p.restitution)
    damping = 2.0 * sqrt(5.0 / 6.0) * decay / sqrt(pi**2 + decay**2)
    return Hertz(
        p.effective_modulus,
        float(p.tangential_ratio),
        damping / partners.time_step,
        float(partners.friction),
    )


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return normal and tangential force, the drag to remember and the loss, as `law` defines them.

    See `sim.parameters.laws.law`.
    """
    stiffness = 2.0 * law.modulus * sqrt(radius * max(overlap, 0.0))
    drag = law.damping * sqrt(stiffness * mass) * approach
    normal = 2.0 / 3.0 * stiffness * overlap + drag
    spring = law.tangential * stiffness
    tx = tangential[0] + spring * slip[0]
    ty = tangential[1] + spring * slip[1]
    tz = tangential[2] + spring * slip[2]
    size = sqrt(tx * tx + ty * ty + tz * tz)
    limit = law.friction * abs(normal)
    scale = limit / size if size > limit else 1.0
    loss = 0.5 * (memory[0] + drag) * approach
    return normal, (tx * scale, ty * scale, tz * scale), (drag,), loss


def energy(law, overlap, tangential, memory, radius, mass):
    """Return the energy (J) in the normal and in the tangential spring."""
    stiffness = 2.0 * law.modulus * sqrt(radius * max(overlap, 0.0))
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    spring = law.tangential * stiffness
    normal = 4.0 / 15.0 * stiffness * overlap * overlap
    return normal, 0.5 * square / spring if spring > 0.0 else 0.0


add_functions(Hertz, force, energy, own_numbers=1)
