"""Linear spring and dashpot with the friction of Cundall and Strack, the law of most DEM codes.

Cundall and Strack, Géotechnique 29 (1979) 47. Normal force F_N = K α + c dα/dt, kept or clipped
where it is attractive at the end of a contact; tangential spring K_t s, cut to μ |F_N|. For
partners of any masses, and with a drag along the surfaces, the law is in `sim.laws`.
"""

from math import sqrt
from typing import NamedTuple

from sim.engine.compile import by_type, implements
from sim.engine.contact.friction import (
    SMALLEST,
    contact_force,
    declare_memory,
    friction_direction,
    inverse_square_root,
    stored_energy,
    work_against,
)
from sim.parameters.dashpot import damping_fraction


class SpringDashpot(NamedTuple):
    """Parameters of the law for one kind of partners.

    ``stiffness`` K and ``tangential`` stiffness K_t (N/m), ``damping`` c over the time step (N/m):
    the damping force per approach during a step; ``friction`` μ.
    """

    stiffness: float
    damping: float
    tangential: float
    friction: float


class Clipped(NamedTuple):
    """The same numbers, for a normal force that is never attractive."""

    stiffness: float
    damping: float
    tangential: float
    friction: float


#: The drag of the last step.
for _kind in (SpringDashpot, Clipped):
    declare_memory(_kind, 1)


def spring_dashpot(
    stiffness: float,
    restitution: float,
    friction: float,
    mass: float,
    time_step: float,
    tangential_ratio: float = 0.8,
    attraction: str = "kept",
    normal_damping: float = 0.0,
) -> SpringDashpot | Clipped:
    """Return the law of one reduced mass.

    For K (N/m), e, μ, that mass (kg), time step (s), K_t/K, attraction, and γ_n (1/s), which stands
    in place of e unless it is 0.
    """
    share, whole = damping_fraction(restitution, attraction)
    damping = 2.0 * (share / whole) * sqrt(stiffness * mass)
    damping = normal_damping * mass if normal_damping else damping
    kind = SpringDashpot if attraction == "kept" else Clipped
    return kind(
        float(stiffness),
        damping / time_step,
        float(tangential_ratio * stiffness),
        float(friction),
    )


@by_type
def admitted(law, force, drag):
    """Return the normal force and the part of it that is drag, without attraction if so."""
    if law.instance_class is SpringDashpot:
        return lambda law, force, drag: (force, drag)

    def body(law, force, drag):
        pull = min(force, 0.0)
        return force - pull, drag - pull

    return body


@implements(contact_force)
def _spring_dashpot(law, overlap, approach, normal, slip, memory):
    if law.instance_class not in (SpringDashpot, Clipped):
        return None

    def body(law, overlap, approach, normal, slip, memory):
        before, drag_before = memory[:3], memory[3]
        drag = law.damping * approach
        # The drag starts and ends abruptly: the excess of its first step makes up for the part that
        # is missing after its last.
        drag_before = drag if drag_before == 0.0 else drag_before
        force, drag = admitted(law, law.stiffness * overlap + drag, drag)
        limit = law.friction * abs(force)

        ux, uy, uz = friction_direction(normal, before)
        square = before[0] ** 2 + before[1] ** 2 + before[2] ** 2
        magnitude = square * inverse_square_root(square) if square > SMALLEST else 0.0
        tx = magnitude * ux + law.tangential * slip[0]
        ty = magnitude * uy + law.tangential * slip[1]
        tz = magnitude * uz + law.tangential * slip[2]

        square = tx * tx + ty * ty + tz * tz
        inverse = inverse_square_root(square) if square > SMALLEST else 0.0
        scale = min(square * inverse, limit) * inverse
        tangential = (tx * scale, ty * scale, tz * scale)
        return (
            force,
            tangential,
            (*tangential, drag),
            (0.5 * (drag_before + drag) * approach, work_against(before, tangential, slip)),
        )

    return body


@implements(stored_energy)
def _stored_energy(law, overlap, memory):
    if law.instance_class not in (SpringDashpot, Clipped):
        return None

    def body(law, overlap, memory):
        square = memory[0] ** 2 + memory[1] ** 2 + memory[2] ** 2
        return 0.5 * law.stiffness * overlap * overlap, 0.5 * square / law.tangential

    return body
