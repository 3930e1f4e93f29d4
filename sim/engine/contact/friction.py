"""The family of frictional laws with a memory: spheres that rotate, in three dimensions.

The memory of a contact is the tangential force on i, followed by numbers of the law's own. The
force changes sign when the partners change places; the numbers do not. Each law declares for its
type how many numbers it has, so a loop is compiled for exactly that many.
"""

import numpy as np

from sim.engine.compile import implements

#: Numbers of the tangential force.
VECTOR = 3

#: How many numbers of its own each law remembers, by the type of its parameters.
_own_numbers: dict[type, int] = {}


def declare_memory(kind: type, numbers: int) -> None:
    """Declare how many numbers besides the tangential force a law of this type remembers."""
    _own_numbers[kind] = numbers


def memory_size(kind: type) -> int:
    """Return how many numbers a contact remembers under a law of this type."""
    return VECTOR + _own_numbers[kind]


def blank_memory(law):
    """Return the memory of a new contact under a law: zeros."""
    raise NotImplementedError(type(law).__name__)


@implements(blank_memory)
def _blank_memory(law):
    if law.instance_class not in _own_numbers:
        return None
    zeros = (0.0,) * memory_size(law.instance_class)
    return lambda law: zeros


#: Source of the function that reads a contact's memory: the length of a compiled tuple is that of
#: its text.
_RECALL_SOURCE = """
def recall_numbers(new, memory, slot):
    touched = slot >= 0
    s = np.uint64(max(slot, 0))
    return ({numbers},)
"""


def recall(new, memory, slot):
    """Return the memory of a contact; a negative slot means that it did not touch.

    ``new`` is the memory of a new contact, ``memory`` (M, C) that of all contacts.
    """
    raise NotImplementedError


@implements(recall)
def _recall(new, memory, slot):
    numbers = ", ".join(f"memory[{m}, s] if touched else 0.0" for m in range(len(new)))
    namespace = {"np": np}
    exec(_RECALL_SOURCE.format(numbers=numbers), namespace)
    return namespace["recall_numbers"]


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
        Memory of the contact, the tangential force first; ``blank_memory`` returns a new one.

    Returns
    -------
    normal_force : float
        Repulsion (N); the force on i is ``-normal_force * normal``.
    tangential_force : tuple of 3 floats
        Force (N) on i within the tangent plane; j feels the opposite.
    memory : tuple of floats
        Memory for the next step, with as many numbers.
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
