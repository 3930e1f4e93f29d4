"""Gallas' drag between rotating particles: a spring, and drags in normal and shear direction.

The normal force is F_N = K α + 2ζ √(K m*) dα/dt, with the ζ that gives the restitution e, kept or
clipped where it pulls. The shear force γ_s m* v_t acts against the slip velocity v_t and has
neither a limit nor a memory (Gallas, Herrmann and Sokołowski, Eqs. 2-4, with the reduced mass of
the partners in both drags).
"""

from math import sqrt
from typing import Any, NamedTuple

from sim.parameters.dashpot import contact_time, damping_fraction
from sim.parameters.laws import SMALL_OVERLAP, law
from sim.parameters.spheres import SphereParameters


class Drag(NamedTuple):
    """``stiffness`` K (N/m); ``damping`` 2ζ √K over the time step, and ``shear`` γ_s over it;
    ``clips`` is 1 where the normal force never pulls, else 0."""

    stiffness: float
    damping: float
    shear: float
    clips: float


def collision_time(p: SphereParameters) -> float:
    """Return the time for which the lightest particles push, s, as `spring_dashpot` has it."""
    return 2 * p.loading_time * contact_time(p.restitution, p.attraction)


def make(p: SphereParameters, partners: Any) -> Drag:
    """Return the law of a point, the same for all partners."""
    share, whole = damping_fraction(p.restitution, p.attraction)
    damping = 2.0 * (share / whole) * sqrt(p.stiffness) / partners.time_step
    shear = p.shear_damping * p.gravity / partners.time_step
    return Drag(float(p.stiffness), damping, shear, float(p.attraction == "clipped"))


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return normal force, shear force, numbers to remember and loss, as `law` defines them.

    See `sim.parameters.laws.law`. The numbers are the drag (N), and 1 as the contact has begun.
    """
    drag = law.damping * sqrt(mass) * approach
    shear = law.shear * mass
    shear_force = (shear * slip[0], shear * slip[1], shear * slip[2])
    # Drags start and end abruptly: the excess of their first step makes up for the part that is
    # missing after their last.
    is_new = memory[1] == 0.0
    loss = 0.5 * ((drag if is_new else memory[0]) + drag) * approach
    if is_new:
        loss += 0.5 * (
            shear_force[0] * slip[0] + shear_force[1] * slip[1] + shear_force[2] * slip[2]
        )
    normal = law.stiffness * overlap + drag
    pull = law.clips * min(normal, 0.0)
    return normal - pull, shear_force, (drag - pull, 1.0), loss - 0.5 * pull * approach


def energy(law, overlap, tangential, memory, radius, mass):
    """Return the energy (J) in the spring; nothing is stored along the surfaces."""
    return 0.5 * law.stiffness * overlap * overlap, 0.0


law(
    "drag",
    description="the spring of the belt with its drags, without friction; Gallas, Eqs. 2-4",
    make=make,
    force=force,
    energy=energy,
    collision_time=collision_time,
    remembers=2,
    max_overlap=SMALL_OVERLAP,
    owns=("shear_damping", "attraction"),
    ignores=("friction", "friction_plane", "tangential_ratio"),
)
