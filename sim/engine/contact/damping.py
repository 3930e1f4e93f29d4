"""The law of the belt's beads, disks without memory or rotation: a linear spring with damping.

Equations: Gallas, Herrmann and Sokolowski, J. Phys. II France 2 (1992) 1389, Eqs. 2-4.
"""

from typing import NamedTuple

from sim.engine.compile import by_type, inlined


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


@by_type
def damped_mass(kind, mass, inverse_partner_mass):
    """Return the mass that multiplies the damping coefficients."""
    if kind.instance_class is OwnMass:
        return lambda kind, mass, inverse_partner_mass: mass
    return lambda kind, mass, inverse_partner_mass: mass / (1.0 + mass * inverse_partner_mass)


@by_type
def admissible_force(kind, repulsion):
    """Return the normal force that the reading admits; positive is repulsive."""
    if kind.instance_class is AttractionKept:
        return lambda kind, repulsion: repulsion
    return lambda kind, repulsion: max(0.0, repulsion)


@inlined
def disk_force(law, overlap, normal, velocity, mass, inverse_partner_mass):
    """Return the force (N) on a disk from one partner, as the disk itself sees the contact.

    Each partner asks for its own force, so the law need not obey Newton's third law.

    Parameters
    ----------
    law : NamedTuple
        The parameters of the law; the types of its parts select its readings.
    overlap : float
        Overlap of the two disks (m), positive in contact.
    normal : tuple of 2 floats
        Unit vector (x, z) from the disk to its partner.
    velocity : tuple of 2 floats
        Velocity of the disk relative to its partner (m/s).
    mass, inverse_partner_mass : float
        Mass of the disk (kg); one over the partner's mass (1/kg), 0 for belt and obstacle.
    """
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


@inlined
def elastic_energy(law, overlap):
    """Return the energy (J) stored in the spring at an overlap (m)."""
    return 0.5 * law.spring.stiffness * overlap * overlap


@inlined
def dissipated_powers(law, overlap, normal, velocity, force):
    """Return the powers (W) that normal and shear damping take from a disk.

    Arguments as for ``disk_force``, whose result is ``force``. ``velocity`` is the disk's own, or
    relative to a driven partner, whose work is then counted separately.
    """
    nx, nz = normal
    speed = velocity[0] * nx + velocity[1] * nz
    pull = force[0] * nx + force[1] * nz
    power = force[0] * velocity[0] + force[1] * velocity[1]
    # The conservative part of the repulsion is that of the spring alone.
    return -(pull + law.spring.stiffness * overlap) * speed, pull * speed - power
