"""Gallas' drag between rotating particles: a spring, and drags in normal and shear direction.

F_N = K α + 2ζ √(K m*) dα/dt, whose ζ gives the restitution e, and a shear force γ_s m* v_t against
the slip velocity v_t, without a limit and without a memory (Gallas, Herrmann and Sokołowski, Eqs.
2-4, with the reduced mass of the partners for both drags).
"""

from math import sqrt
from typing import NamedTuple

from sim.engine.contact import Partners
from sim.engine.contact.own import add_functions
from sim.engine.contact.spring_dashpot import damping_ratio
from sim.parameters.spheres import SphereParameters


class Drag(NamedTuple):
    """``stiffness`` K (N/m); ``damping`` 2ζ √K over the time step, and ``shear`` γ_s over it."""

    stiffness: float
    damping: float
    shear: float


def from_parameters(p: SphereParameters, partners: Partners) -> Drag:
    """Return the law of a point, the same for all partners."""
    damping = 2.0 * damping_ratio(p.restitution) * sqrt(p.stiffness)
    shear = p.shear_damping * p.gravity
    return Drag(float(p.stiffness), damping / partners.time_step, shear / partners.time_step)


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return what `sim.parameters.laws.law` says of a law's force."""
    drag = law.damping * sqrt(mass) * approach
    shear = law.shear * mass
    along = (shear * slip[0], shear * slip[1], shear * slip[2])
    # Drags set in at once and end at once; what their first step has too much makes up for what is
    # missing behind their last.
    begun = memory[1] == 0.0
    lost = 0.5 * ((drag if begun else memory[0]) + drag) * approach
    if begun:
        lost += 0.5 * (along[0] * slip[0] + along[1] * slip[1] + along[2] * slip[2])
    return law.stiffness * overlap + drag, along, (drag, 1.0), lost


def energy(law, overlap, tangential, memory, radius, mass):
    """Return the energy (J) in the spring; nothing is stored along the surfaces."""
    return 0.5 * law.stiffness * overlap * overlap, 0.0


add_functions(Drag, force, energy, kept=2)
