"""The family of laws without memory or rotation: disks in two dimensions."""

from sim.engine.compile import implements, inlined


def disk_force(law, overlap, normal, velocity, mass, inverse_partner_mass):
    """Return the force (N) on a disk from one partner, as the disk itself sees the contact.

    Each partner asks for its own force, so a law need not obey Newton's third law.

    Parameters
    ----------
    law : NamedTuple
        The parameters of the law; its type selects the body.
    overlap : float
        Overlap of the two disks (m), positive in contact.
    normal : tuple of 2 floats
        Unit vector (x, z) from the disk to its partner.
    velocity : tuple of 2 floats
        Velocity of the disk relative to its partner (m/s).
    mass, inverse_partner_mass : float
        Mass of the disk (kg); one over the partner's mass (1/kg), 0 for belt and obstacle.
    """
    raise NotImplementedError(type(law).__name__)


def elastic_force(law, overlap):
    """Return the conservative part of the repulsion (N): that of the spring alone."""
    raise NotImplementedError(type(law).__name__)


def elastic_energy(law, overlap):
    """Return the energy (J) stored in the spring at an overlap (m)."""
    raise NotImplementedError(type(law).__name__)


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
    return -(pull + elastic_force(law, overlap)) * speed, pull * speed - power


__all__ = ["disk_force", "dissipated_powers", "elastic_energy", "elastic_force", "implements"]
