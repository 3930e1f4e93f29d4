"""Contact laws that are plain functions of two partners.

For each contact such a law is bundled with radius, mass and rotation of its partners
(`PartnerLaw`). Laws that need none of these are used as they are, and what a law does not do is
not compiled for it.
"""

from typing import NamedTuple

from numba.core.types import BaseTuple, Float

from sim.engine.compile import (
    by_type,
    implements,
    inlined,
    inlined_with_calls,
    require_numbers,
    typing_error,
)
from sim.engine.contact.friction import (
    SMALLEST,
    VECTOR,
    blank_memory,
    contact_force,
    declare_memory,
    friction_direction,
    inverse_square_root,
    stored_energy,
    work_against,
)
from sim.parameters.laws import Law

#: The laws that are plain functions, by the types of their parameters.
_laws: dict[type, Law] = {}

#: Numbers remembered of the torque of a law that rolls: all of it, its part across the normal, and,
#: behind all other numbers, its size about the normal.
_TORQUE = 2 * VECTOR + 1


class PartnerLaw(NamedTuple):
    """A law of plain functions with reduced ``radius`` (m) and ``mass`` (kg) of two partners."""

    law: NamedTuple
    radius: float
    mass: float


class RollingLaw(NamedTuple):
    """The same with the ``turn`` (3,) (rad) of the second partner relative to the first in the
    step."""

    law: NamedTuple
    radius: float
    mass: float
    turn: tuple[float, float, float]


def _rolls(law):
    return law.instance_class in _laws and _laws[law.instance_class].rolls


def _reaches(law):
    kind = law.instance_class
    return kind in _laws and "reach" in _laws[kind].model_fields_set


@inlined
def turn_of(spheres, i, time_step):
    """Return by which angle (3,) (rad) a sphere has turned in the step."""
    w, per_rim = spheres.rim, time_step / spheres.radius[i]
    return w[0, i] * per_rim, w[1, i] * per_rim, w[2, i] * per_rim


@by_type
def law_between(law, spheres, pairs, p, time_step):
    """Return a law for the two spheres of pair p of a list."""
    if law.instance_class not in _laws:
        return lambda law, spheres, pairs, p, time_step: law

    def body(law, spheres, pairs, p, time_step):
        i, j = pairs.first[p], pairs.second[p]
        reduced_radius = (
            spheres.radius[i] * spheres.radius[j] / (spheres.radius[i] + spheres.radius[j])
        )
        # A fixed sphere has an inverse mass of 0; a contact of two fixed spheres does not count.
        inverse = spheres.inverse_mass[i] + spheres.inverse_mass[j]
        return PartnerLaw(law, reduced_radius, 1.0 / inverse if inverse > 0.0 else 0.0)

    inlined_body = inlined(body)

    def rolling_body(law, spheres, pairs, p, time_step):
        law, radius, mass = inlined_body(law, spheres, pairs, p, time_step)
        ax, ay, az = turn_of(spheres, pairs.first[p], time_step)
        bx, by, bz = turn_of(spheres, pairs.second[p], time_step)
        return RollingLaw(law, radius, mass, (bx - ax, by - ay, bz - az))

    return rolling_body if _rolls(law) else body


@by_type
def law_on_plane(law, spheres, i, time_step):
    """Return a law for sphere i and the plane."""
    if law.instance_class not in _laws:
        return lambda law, spheres, i, time_step: law
    if not _rolls(law):
        return lambda law, spheres, i, time_step: PartnerLaw(
            law, spheres.radius[i], spheres.mass[i]
        )

    def body(law, spheres, i, time_step):
        x, y, z = turn_of(spheres, i, time_step)
        return RollingLaw(law, spheres.radius[i], spheres.mass[i], (-x, -y, -z))

    return body


@by_type
def reach_of(law, reach):
    """Return how far (m) beyond contact a law is called."""
    return (lambda law, reach: reach) if _reaches(law) else (lambda law, reach: 0.0)


@by_type
def gap_to_plane(law, spheres, i, reach):
    """Return how far (m) sphere i is from where the plane's law is called, negative within.

    A fixed sphere and the plane are no partners of a law that reaches.
    """
    if not _reaches(law):
        return lambda law, spheres, i, reach: spheres.position[2, i] - spheres.radius[i]
    return lambda law, spheres, i, reach: (
        spheres.position[2, i] - spheres.radius[i] - reach if spheres.mass[i] > 0.0 else reach
    )


@by_type
def touching_number(law, rows, first, number):
    """Return how many of ``number`` overlaps (m), from index ``first`` on, are of contacts."""
    if not _reaches(law):
        return lambda law, rows, first, number: number

    def body(law, rows, first, number):
        count = 0
        for k in range(first, first + number):
            count += 1 if rows[k] > 0.0 else 0
        return count

    return body


@by_type
def add_torque(law, spheres, memory, c, i, sign, rank):
    """Add to sphere i the torque of contact c, if its law gives one, see ``Spheres.moment``."""
    if not _rolls(law):
        return lambda law, spheres, memory, c, i, sign, rank: None

    def body(law, spheres, memory, c, i, sign, rank):
        for d in range(VECTOR):
            spheres.moment[rank, d, i] += sign * memory[VECTOR + d, c] / spheres.radius[i]

    return body


@implements(blank_memory)
def _blank_memory(law):
    is_bundle = law.instance_class in (PartnerLaw, RollingLaw)
    return (lambda law: blank_memory(law.law)) if is_bundle else None


@inlined
def turn_into_plane(normal, tangential):
    """Return a tangential force turned into the present tangent plane, with its magnitude."""
    ux, uy, uz = friction_direction(normal, tangential)
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    magnitude = square * inverse_square_root(square) if square > SMALLEST else 0.0
    return magnitude * ux, magnitude * uy, magnitude * uz


def _turning(vectors):
    """Return a function that turns so many vectors, the first of some numbers."""
    if vectors == 0:
        return lambda normal, numbers: numbers
    turn_others = inlined(_turning(vectors - 1))
    return lambda normal, numbers: (
        *turn_into_plane(normal, numbers[:3]),
        *turn_others(normal, numbers[3:]),
    )


@by_type
def force_of(law, given):
    """Return the result of a law's function ``force``, see `sim.parameters.laws.law`."""
    force, *_ = _laws[law.instance_class].of(law.instance_class)
    force = inlined_with_calls(force)
    return lambda law, given: checked_force(law, force(law, *given))


@by_type
def checked_force(law, returned):
    """Return the result of a law's ``force``; refuse other types or numbers when compiled."""
    force, own_numbers, _ = _laws[law.instance_class].of(law.instance_class)
    parts = ["normal force", "tangential force", "numbers to remember", "energy", "torque"]
    parts = parts if _rolls(law) else parts[:-1]
    if not (isinstance(returned, BaseTuple) and len(returned) == len(parts)):
        wanted = f"{', '.join(parts[:-1])} and {parts[-1]}"
        raise typing_error(force, f"what force returns is no tuple of {wanted}: got {returned}")
    normal, tangential, numbers, loss, *torque = returned
    require_numbers(force, "normal force and energy that force returns", (normal, loss), 2)
    require_numbers(force, "the tangential force that force returns", tangential, 3, Float)
    subject = f"what force gives to remember, {own_numbers} as remembers says,"
    require_numbers(force, subject, numbers, own_numbers, Float)
    for one in torque:
        require_numbers(force, "the torque that force returns", one, 4, Float)
    return lambda law, returned: returned


@by_type
def energy_of(law, given):
    """Return the result of a law's function ``energy``, see `sim.parameters.laws.law`."""
    energy = inlined_with_calls(_laws[law.instance_class].energy)
    return lambda law, given: checked_energy(law, energy(law, *given))


@by_type
def checked_energy(law, returned):
    """Return the result of a law's ``energy``; refuse other types when compiled."""
    require_numbers(_laws[law.instance_class].energy, "what energy returns", returned, 2)
    return lambda law, returned: returned


@implements(contact_force)
def _contact_force(law, overlap, approach, normal, slip, memory):
    if law.instance_class not in (PartnerLaw, RollingLaw):
        return None
    kind = law.types[0].instance_class
    _, _, vectors = _laws[kind].of(kind)
    turn_vectors = inlined(_turning(vectors))
    has_turn = law.instance_class is RollingLaw
    turn_in = inlined((lambda law: law.turn) if has_turn else (lambda law: (0.0, 0.0, 0.0)))

    def body(law, overlap, approach, normal, slip, memory):
        before, numbers = memory[:3], turn_vectors(normal, memory[3:])
        held = turn_into_plane(normal, before)
        given = overlap, approach, slip, held, numbers, law.radius, law.mass
        force, tangential, numbers, loss = force_of(law.law, given)
        work = work_against(before, tangential, slip)
        return force, tangential, (*tangential, *numbers), (loss, work)

    def rolling_body(law, overlap, approach, normal, slip, memory):
        before, torque_before, numbers = memory[:3], memory[3:6], memory[9:-1]
        held, numbers = turn_into_plane(normal, before), turn_vectors(normal, numbers)
        (nx, ny, nz), (tx, ty, tz) = normal, turn_in(law)
        twist = tx * nx + ty * ny + tz * nz
        rolling = (tx - twist * nx, ty - twist * ny, tz - twist * nz, twist)
        resisting = (*turn_into_plane(normal, memory[6:9]), memory[-1])
        given = overlap, approach, slip, held, numbers, law.radius, law.mass, rolling, resisting
        force, tangential, numbers, loss, (x, y, z, about) = force_of(law.law, given)
        torque = (x + about * nx, y + about * ny, z + about * nz)
        work = work_against(before, tangential, slip)
        work += work_against(torque_before, torque, (tx, ty, tz))
        remembered = (*tangential, *torque, x, y, z, *numbers, about)
        return force, tangential, remembered, (loss, work)

    return rolling_body if _rolls(law.types[0]) else body


@implements(stored_energy)
def _stored_energy(law, overlap, memory):
    if law.instance_class not in (PartnerLaw, RollingLaw):
        return None

    def body(law, overlap, memory):
        given = overlap, memory[:3], memory[3:], law.radius, law.mass
        return energy_of(law.law, given)

    def rolling_body(law, overlap, memory):
        torque = (*memory[6:9], memory[-1])
        given = overlap, memory[:3], memory[9:-1], law.radius, law.mass, torque
        return energy_of(law.law, given)

    return rolling_body if _rolls(law.types[0]) else body


def add_law(kind, law):
    """Register a type of parameters as a law, with its functions, of a plug-in or of Talus."""
    _, numbers, vectors = law.of(kind)
    _laws[kind], torque = law, _TORQUE if law.rolls else 0
    declare_memory(kind, torque + numbers, vectors=torque // VECTOR + vectors)
