"""Linear spring with normal and shear damping: the beads of the vibrating belt.

Equations: Gallas, Herrmann and Sokolowski, J. Phys. II France 2 (1992) 1389, Eqs. 2-4.
"""

from typing import NamedTuple

from sim.engine.compile import implements, inlined
from sim.engine.contact.damping import disk_force, elastic_energy, elastic_force


class OwnMass(NamedTuple):
    """Damping proportional to the mass of the disk that feels it, as printed: not reciprocal."""

    damping: float
    shear_damping: float


class ReducedMass(NamedTuple):
    """Damping proportional to the reduced mass of the two partners: reciprocal."""

    damping: float
    shear_damping: float


class AttractionKept(NamedTuple):
    """The damping may make the normal force attractive at the end of a contact, as printed."""

    stiffness: float


class AttractionClipped(NamedTuple):
    """The normal force is never attractive."""

    stiffness: float


class SpringDamping(NamedTuple):
    """Parameters of the law; the types of its two parts select its readings.

    ``dissipation`` (OwnMass or ReducedMass) holds γ and γ_s (1/s), ``spring`` (Kept or Clipped)
    holds the stiffness Y (N/m).
    """

    dissipation: NamedTuple
    spring: NamedTuple


def spring_damping(
    stiffness: float,
    damping: float,
    shear_damping: float,
    damping_mass: str = "own",
    attraction: str = "kept",
) -> SpringDamping:
    """Return the law for Y (N/m), γ and γ_s (1/s) and the two readings."""
    dissipation = {"own": OwnMass, "reduced": ReducedMass}[damping_mass]
    spring = {"kept": AttractionKept, "clipped": AttractionClipped}[attraction]
    return SpringDamping(
        dissipation(float(damping), float(shear_damping)), spring(float(stiffness))
    )


def damped_mass(kind, mass, inverse_partner_mass):
    """Return the mass that multiplies the damping coefficients."""
    raise NotImplementedError


@implements(damped_mass)
def _damped_mass(kind, mass, inverse_partner_mass):
    if kind.instance_class is OwnMass:
        return lambda kind, mass, inverse_partner_mass: mass
    return lambda kind, mass, inverse_partner_mass: mass / (1.0 + mass * inverse_partner_mass)


def admissible_force(kind, repulsion):
    """Return the normal force that the reading admits; positive is repulsive."""
    raise NotImplementedError


@implements(admissible_force)
def _admissible_force(kind, repulsion):
    if kind.instance_class is AttractionKept:
        return lambda kind, repulsion: repulsion
    return lambda kind, repulsion: max(0.0, repulsion)


@inlined
def _damped_spring(law, overlap, normal, velocity, mass, inverse_partner_mass):
    nx, nz = normal
    vx, vz = velocity
    inertia = damped_mass(law.dissipation, mass, inverse_partner_mass)
    approach = vx * nx + vz * nz
    shear = vz * nx - vx * nz
    repulsion = admissible_force(
        law.spring, law.spring.stiffness * overlap + law.dissipation.damping * inertia * approach
    )
    drag = law.dissipation.shear_damping * inertia * shear
    return -repulsion * nx + drag * nz, -repulsion * nz - drag * nx


@implements(disk_force)
def _spring_damping(law, overlap, normal, velocity, mass, inverse_partner_mass):
    if law.instance_class is SpringDamping:
        return lambda law, overlap, normal, velocity, mass, inverse_partner_mass: _damped_spring(
            law, overlap, normal, velocity, mass, inverse_partner_mass
        )
    return None


@implements(elastic_force)
def _elastic_force(law, overlap):
    if law.instance_class is SpringDamping:
        return lambda law, overlap: law.spring.stiffness * overlap
    return None


@implements(elastic_energy)
def _elastic_energy(law, overlap):
    if law.instance_class is SpringDamping:
        return lambda law, overlap: 0.5 * law.spring.stiffness * overlap * overlap
    return None
