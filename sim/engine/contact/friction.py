"""The family of frictional laws with a memory: spheres that rotate, in three dimensions.

A contact keeps the tangential force on i, which changes sign when the partners change places, and
behind it numbers of the law's own, which do not. How many those are each law says of its type, so
that a loop is compiled for just as many.
"""

import numpy as np

from sim.engine.compile import implements

#: Numbers of the tangential force.
VECTOR = 3

#: How many numbers of their own laws keep, by the types of their parameters.
_own_numbers: dict[type, int] = {}


def remembers(kind: type, numbers: int) -> None:
    """Say how many numbers of its own, besides the tangential force, a law of such a type keeps."""
    _own_numbers[kind] = numbers


def memory_size(kind: type) -> int:
    """Return how many numbers a contact keeps under a law of such a type."""
    return VECTOR + _own_numbers[kind]


def blank(law):
    """Return the memory of a new contact under a law: zeros, as many as it keeps numbers."""
    raise NotImplementedError(type(law).__name__)


@implements(blank)
def _blank(law):
    if law.instance_class not in _own_numbers:
        return None
    zeros = (0.0,) * memory_size(law.instance_class)
    return lambda law: zeros


#: What reads the numbers of a contact. A tuple has as many numbers as its text, whatever is read.
_RECALLED = """
def recalled(new, memory, slot):
    held = slot >= 0
    s = np.uint64(max(slot, 0))
    return ({numbers},)
"""


def recall(new, memory, slot):
    """Return what a contact remembers; a negative slot means that it did not touch.

    ``new`` is the memory of a new contact, ``memory`` (M, C) that of all.
    """
    raise NotImplementedError


@implements(recall)
def _recall(new, memory, slot):
    numbers = ", ".join(f"memory[{m}, s] if held else 0.0" for m in range(len(new)))
    made = {"np": np}
    exec(_RECALLED.format(numbers=numbers), made)
    return made["recalled"]


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
    memory : tuple of floats
        What the contact remembers, the tangential force first; see ``blank`` for a new one.

    Returns
    -------
    normal_force : float
        Repulsion (N); the force on i is ``-normal_force * normal``.
    tangential_force : tuple of 3 floats
        Force (N) on i within the tangent plane; j feels the opposite.
    memory : tuple of floats
        The memory for the next step, as many numbers.
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
