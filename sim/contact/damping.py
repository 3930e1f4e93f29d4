"""The family of laws without memory or rotation: disks in two dimensions."""

from sim.compile import implements


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


__all__ = ["disk_force", "implements"]
