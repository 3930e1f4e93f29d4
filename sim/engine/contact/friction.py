"""The family of frictional laws with a memory: spheres that rotate, in three dimensions."""

from sim.engine.compile import implements

#: Numbers that a contact keeps: the tangential force on i (3), which changes sign when the partners
#: change places, and four of the law's own, which do not.
MEMORY = 7
VECTOR = 3


def contact_force(law, overlap, approach, normal, slip, memory):
    """Advance one contact by one time step.

    Parameters
    ----------
    law : NamedTuple
        The parameters of the law; its type selects the body.
    overlap, approach : float
        Overlap of the two surfaces (m), positive in contact, and how far (m) the partners have
        approached each other during the step.
    normal : tuple of 3 floats
        Unit vector from sphere i to its partner j.
    slip : tuple of 3 floats
        Displacement (m) of the surface of j relative to that of i during the step, within the
        tangent plane.
    memory : tuple of 7 floats
        What the contact remembers; all zeros for a new one.

    Returns
    -------
    normal_force : float
        Repulsion (N); the force on i is ``-normal_force * normal``.
    tangential_force : tuple of 3 floats
        Force (N) on i within the tangent plane; j feels the opposite.
    memory : tuple of 7 floats
        The memory for the next step.
    energy : tuple of 2 floats
        Energy (J) that the normal force has dissipated during the step, and work (J) done against
        the tangential force, which includes what its spring has stored.
    """
    raise NotImplementedError(type(law).__name__)


def stored_energy(law, overlap, memory):
    """Return the energy (J) stored in the normal and in the tangential spring of a contact.

    Arguments as for ``contact_force``; ``memory`` is that after the last step.
    """
    raise NotImplementedError(type(law).__name__)


__all__ = ["MEMORY", "VECTOR", "contact_force", "implements", "stored_energy"]
