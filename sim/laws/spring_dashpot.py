"""Linear spring and dashpot with the friction of Cundall and Strack.

F_N = K α + c dα/dt, where c gives every pair the restitution, or is γ_n m with the reduced mass m
of the partners, of which what is fixed has an infinite one (as in LAMMPS and MercuryDPM). Along the
surfaces a spring K_t s and a drag γ_t m v_t; their sum is cut to μ |F_N|. What is cut off shortens
the spring, so that the sum is at its limit while it slides (``gran/hooke/history`` of LAMMPS).

For one reduced mass without that drag the body is compiled by hand:
`sim.engine.contact.spring_dashpot`.
"""

from math import sqrt
from typing import Any, NamedTuple

from sim.parameters.dashpot import contact_time, damping_fraction, damping_ratio, time_of
from sim.parameters.laws import SMALL_OVERLAP, law
from sim.parameters.spheres import SphereParameters


class AnyMasses(NamedTuple):
    """``stiffness`` K and ``tangential`` K_t (N/m); over the time step ``damping`` c/√m that gives
    the restitution and ``rate`` γ_n, of which one is 0, and ``shear`` γ_t; ``friction`` μ;
    ``clips`` is 1 where the normal force never pulls, else 0."""

    stiffness: float
    damping: float
    rate: float
    tangential: float
    shear: float
    friction: float
    clips: float


def is_general(p: SphereParameters) -> bool:
    """Return whether the law of a point is that of several masses or drags along the surfaces."""
    return bool(p.bumps or p.diameter_spread or p.tangential_damping)


def make(p: SphereParameters, partners: Any) -> NamedTuple:
    """Return the law of a point for one kind of partners."""
    from sim.engine.contact.spring_dashpot import spring_dashpot

    step = partners.time_step
    if not is_general(p):
        return spring_dashpot(
            p.stiffness,
            p.restitution,
            partners.friction,
            partners.reduced_mass,
            step,
            p.tangential_ratio,
            p.attraction,
            p.normal_damping,
        )
    share, whole = damping_fraction(p.restitution, p.attraction)
    damping = 0.0 if p.normal_damping else 2.0 * share / whole * sqrt(p.stiffness)
    return AnyMasses(
        float(p.stiffness),
        damping / step,
        p.normal_damping / step,
        float(p.tangential_ratio * p.stiffness),
        p.tangential_damping / step,
        float(partners.friction),
        float(p.attraction == "clipped"),
    )


def collision_time(p: SphereParameters) -> float:
    """Return the time for which the lightest particles push, s.

    π √(m*/K) √(1 + (ln e/π)²) where they also pull, less where that is clipped.
    """
    if p.normal_damping:
        ratio = damping_ratio(p.normal_damping, p.stiffness, 0.5 * p.lightest_mass)
        return 2 * p.loading_time * time_of(ratio, p.attraction)
    return 2 * p.loading_time * contact_time(p.restitution, p.attraction)


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return both forces, what to remember and the loss, as `law` defines them.

    See `sim.parameters.laws.law`. To remember are the force of the spring along the surfaces, which
    turns with the contact, and the drag along the normal (N).
    """
    drag = (law.damping * sqrt(mass) + law.rate * mass) * approach
    # A drag starts and ends abruptly: the excess of its first step makes up for the part that is
    # missing after its last.
    before = drag if memory[3] == 0.0 else memory[3]
    pull = law.clips * min(law.stiffness * overlap + drag, 0.0)
    drag -= pull
    normal = law.stiffness * overlap + drag
    shear = law.shear * mass
    spring = law.tangential + shear
    tx = memory[0] + spring * slip[0]
    ty = memory[1] + spring * slip[1]
    tz = memory[2] + spring * slip[2]
    size = sqrt(tx * tx + ty * ty + tz * tz)
    limit = law.friction * abs(normal)
    scale = limit / size if size > limit else 1.0
    tx, ty, tz = tx * scale, ty * scale, tz * scale
    held = (tx - shear * slip[0], ty - shear * slip[1], tz - shear * slip[2])
    return normal, (tx, ty, tz), (*held, drag), 0.5 * (before + drag) * approach


def energy(law, overlap, tangential, memory, radius, mass):
    """Return the energy (J) in the normal and in the tangential spring."""
    square = memory[0] ** 2 + memory[1] ** 2 + memory[2] ** 2
    return 0.5 * law.stiffness * overlap * overlap, 0.5 * square / law.tangential


law(
    "spring_dashpot",
    description="linear springs and a dashpot, as in most DEM codes; Cundall and Strack, 1979",
    make=make,
    force=None,
    energy=energy,
    collision_time=collision_time,
    remembers=1,
    max_overlap=SMALL_OVERLAP,
    owns=("attraction", "normal_damping", "tangential_damping"),
    replaces={"normal_damping": ("restitution",)},
    selects=lambda p: {"tangential_damping": 1.0} if is_general(p) else {},
    variants={AnyMasses: (force, 4, 1)},
)
