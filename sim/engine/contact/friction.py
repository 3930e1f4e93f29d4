"""The family of frictional laws with a memory: spheres that rotate, in three dimensions.

The memory of a contact is the tangential force on i, followed by numbers of the law's own, of which
the first may be vectors. Force and vectors change sign when the partners change places; the other
numbers do not. Each law declares for its type how many it has, so a loop is compiled for exactly
that many.
"""

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import by_type, implements, inlined

#: Numbers of the tangential force.
VECTOR = 3


class Memory(NamedTuple):
    """How many numbers besides the tangential force a law remembers, ``vectors`` of 3 first.

    Loads upon a condition keep a loop over contacts from being a vector loop on processors without
    a fast gather. Laws that are ``always_read``, whether a contact touched before or not, have
    none; the others would round differently.
    """

    numbers: int
    vectors: int
    always_read: bool


#: What each law remembers, by the type of its parameters.
_memories: dict[type, Memory] = {}


def declare_memory(kind: type, numbers: int, always_read: bool = False, vectors: int = 0) -> None:
    """Declare what a law of this type remembers, see `Memory`."""
    _memories[kind] = Memory(numbers, vectors, always_read)


def memory_size(kind: type) -> int:
    """Return how many numbers a contact remembers under a law of this type."""
    return VECTOR + _memories[kind].numbers


def turning_numbers(law: NamedTuple) -> int:
    """Return how many numbers of a memory, its first, change sign where partners change places."""
    return VECTOR * (1 + _memories[type(law)].vectors)


def make_memory(law: NamedTuple, contacts: int) -> np.ndarray:
    """Return empty memory (2, M, C) of contacts, written in even and odd steps in turn.

    M is the count of numbers that a contact remembers under the law.
    """
    return np.zeros((2, memory_size(type(law)), contacts))


def memory_after(memory: np.ndarray, step: int) -> np.ndarray:
    """Return the memory (M, C) that a step has written; the next step reads it."""
    return memory[step % 2]


def restart_memory(memory: np.ndarray, step: int) -> np.ndarray:
    """Return the memory after a step, for a flow that counts that step as number 0."""
    return memory[::-1].copy() if step % 2 else memory


def enlarge_memory(memory: np.ndarray, contacts: int) -> np.ndarray:
    """Return a copy of the memory with room for more contacts."""
    return np.pad(memory, ((0, 0), (0, 0), (0, contacts - memory.shape[2])))


def blank_memory(law):
    """Return the memory of a new contact under a law: zeros."""
    raise NotImplementedError(type(law).__name__)


@implements(blank_memory)
def _blank_memory(law):
    if law.instance_class not in _memories:
        return None
    zeros = (0.0,) * memory_size(law.instance_class)
    return lambda law: zeros


#: Source of the functions that read a contact's memory: the length of a compiled tuple is that of
#: its text.
_RECALL_SOURCE = """
def recall_numbers({arguments}):
    touched = slot >= 0
    s = np.uint64(max(slot, 0))
    {loads}
    return ({numbers},)
"""


def _recall_function(arguments, loads, numbers):
    namespace = {"np": np}
    exec(_RECALL_SOURCE.format(arguments=arguments, loads=loads, numbers=numbers), namespace)
    return namespace["recall_numbers"]


@by_type
def recall(new, memory, slot):
    """Return the memory of a contact; a negative slot means that it did not touch.

    ``new`` is the memory of a new contact, ``memory`` (M, C) that of all contacts.
    """
    numbers = ", ".join(f"memory[{m}, s] if touched else 0.0" for m in range(len(new)))
    return _recall_function("new, memory, slot", "", numbers)


@by_type
def recall_in_loop(law, new, memory, slot):
    """Return the same as ``recall`` in a loop over contacts that obey a law."""
    if not _memories[law.instance_class].always_read:
        return lambda law, new, memory, slot: recall(new, memory, slot)
    every = range(len(new))
    loads = "; ".join(f"old_{m} = memory[{m}, s]" for m in every)
    numbers = ", ".join(f"old_{m} if touched else 0.0" for m in every)
    return _recall_function("law, new, memory, slot", loads, numbers)


def contact_force(law, overlap, approach, normal, slip, memory):
    """Advance one contact by one time step.

    Parameters
    ----------
    law : NamedTuple
        The parameters of the law; its type selects the body.
    overlap, approach : float
        Overlap of the two surfaces (m), negative beyond contact, and how far (m) the partners have
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


@inlined
def friction_direction(normal, tangential):
    """Return the direction of the old friction within the present tangent plane.

    A friction of zero has the zero vector: all displacement then counts as new.
    """
    nx, ny, nz = normal
    tx, ty, tz = tangential
    along = nx * tx + ny * ty + nz * tz
    px, py, pz = tx - along * nx, ty - along * ny, tz - along * nz
    projected = px * px + py * py + pz * pz
    scale = inverse_square_root(projected) if projected > SMALLEST else 0.0
    return px * scale, py * scale, pz * scale


@inlined
def work_against(before, after, slip):
    """Return the work (J) done against a friction (N) that changes during a slip (m).

    With the mean of both forces it is exactly the change of the particles' kinetic energy: in
    leap-frog the force of a step acts over half of the displacement before it and half of the next.
    """
    return 0.5 * (
        (before[0] + after[0]) * slip[0]
        + (before[1] + after[1]) * slip[1]
        + (before[2] + after[2]) * slip[2]
    )


# Roots that compilers can vectorise and that avoid the slow divider of the processor.
#
# Each root starts from the bit pattern, which holds the logarithm of a number. A share of it,
# subtracted from a constant, gives the power within 3.5 per cent; two polynomial corrections
# follow.

#: Numbers below this count as zero: their powers would leave the range of normal numbers.
SMALLEST = 1e-290


@intrinsic
def _bits(typingctx, value):
    """Reinterpret a float64 as an int64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _float(typingctx, bits):
    """Reinterpret an int64 as a float64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


@inlined
def inverse_square_root(x):
    """Return 1/√x to about 4e-16 relative for x >= ``SMALLEST``, and anything for smaller x.

    With h = 1 - x r², 1/√x = r (1 - h)^(-1/2); the binomial series of the last factor is cut where
    the next term no longer matters.
    """
    r = _float(0x5FE6EB50C7B537A9 - (_bits(x) >> 1))
    h = 1.0 - x * r * r
    r *= 1.0 + h * (1 / 2 + h * (3 / 8 + h * (5 / 16 + h * (35 / 128))))
    h = 1.0 - x * r * r
    return r * (1.0 + h * (1 / 2 + h * (3 / 8)))


@inlined
def cube_root(x):
    """Return the cube root of x >= 0 to about 7e-16 relative, and 0 below ``SMALLEST``.

    It is x r² with r = x^(-1/3), corrected by the series of (1 - h)^(-1/3) with h = 1 - x r³.
    """
    third = _bits(x) * (1 / 3)
    r = _float(0x553EF1A9FBE76C8C - types.int64(third))
    h = 1.0 - x * r * r * r
    r *= 1.0 + h * (1 / 3 + h * (2 / 9 + h * (14 / 81 + h * (35 / 243))))
    h = 1.0 - x * r * r * r
    r *= 1.0 + h * (1 / 3 + h * (2 / 9))
    return x * r * r if x > SMALLEST else 0.0
