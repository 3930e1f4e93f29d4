"""Contact laws that are plain functions of two partners.

For each contact such a law is bundled with radius and mass of its partners (`PartnerLaw`). Laws
that need neither are used as they are, at no extra cost.
"""

from functools import cache
from typing import NamedTuple

from numba.core.types import BaseTuple, Float

from sim.engine.compile import (
    adopt_type,
    by_type,
    implements,
    inlined,
    require_numbers,
    typing_error,
)
from sim.engine.contact.friction import (
    SMALLEST,
    blank_memory,
    contact_force,
    declare_memory,
    friction_direction,
    inverse_square_root,
    own_vectors,
    stored_energy,
    work_against,
)

#: Types of the laws that are plain functions.
_functional: set[type] = set()


class PartnerLaw(NamedTuple):
    """A law of plain functions with reduced ``radius`` (m) and ``mass`` (kg) of two partners."""

    law: NamedTuple
    radius: float
    mass: float


@by_type
def law_between(law, spheres, pairs, p):
    """Return a law for the two spheres of pair p of a list."""
    if law.instance_class not in _functional:
        return lambda law, spheres, pairs, p: law

    def body(law, spheres, pairs, p):
        i, j = pairs.first[p], pairs.second[p]
        reduced_radius = (
            spheres.radius[i] * spheres.radius[j] / (spheres.radius[i] + spheres.radius[j])
        )
        # A fixed sphere has an inverse mass of 0; a contact of two fixed spheres does not count.
        inverse = spheres.inverse_mass[i] + spheres.inverse_mass[j]
        return PartnerLaw(law, reduced_radius, 1.0 / inverse if inverse > 0.0 else 0.0)

    return body


@by_type
def law_on_plane(law, spheres, i):
    """Return a law for sphere i and the plane."""
    if law.instance_class not in _functional:
        return lambda law, spheres, i: law
    return lambda law, spheres, i: PartnerLaw(law, spheres.radius[i], spheres.mass[i])


@implements(blank_memory)
def _blank_memory(law):
    return (lambda law: blank_memory(law.law)) if law.instance_class is PartnerLaw else None


@inlined
def turn_into_plane(normal, tangential):
    """Return a tangential force turned into the present tangent plane, with its magnitude."""
    ux, uy, uz = friction_direction(normal, tangential)
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    magnitude = square * inverse_square_root(square) if square > SMALLEST else 0.0
    return magnitude * ux, magnitude * uy, magnitude * uz


@by_type
def turn_vectors(law, normal, numbers):
    """Return a law's own numbers with its vectors turned as the tangential force is."""
    return _turning(own_vectors(law.instance_class))


def _turning(vectors):
    if vectors == 0:
        return lambda law, normal, numbers: numbers
    turn_others = inlined(_turning(vectors - 1))

    def body(law, normal, numbers):
        return (*turn_into_plane(normal, numbers[:3]), *turn_others(law, normal, numbers[3:]))

    return body


def force_of(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return the result of a law's function ``force``, see `sim.parameters.laws.law`."""
    raise NotImplementedError


def checked_force(law, returned):
    """Return the result of a law's ``force``; refuse other types or numbers when compiled."""
    raise NotImplementedError


def checked_energy(law, returned):
    """Return the result of a law's ``energy``; refuse other types when compiled."""
    raise NotImplementedError


def energy_of(law, overlap, tangential, memory, radius, mass):
    """Return the result of a law's function ``energy``, see `sim.parameters.laws.law`."""
    raise NotImplementedError


@implements(contact_force)
def _contact_force(law, overlap, approach, normal, slip, memory):
    if law.instance_class is not PartnerLaw:
        return None

    def body(law, overlap, approach, normal, slip, memory):
        before, numbers = memory[:3], turn_vectors(law.law, normal, memory[3:])
        force, tangential, numbers, loss = force_of(
            law.law,
            overlap,
            approach,
            slip,
            turn_into_plane(normal, before),
            numbers,
            law.radius,
            law.mass,
        )
        work = work_against(before, tangential, slip)
        return force, tangential, (*tangential, *numbers), (loss, work)

    return body


@implements(stored_energy)
def _stored_energy(law, overlap, memory):
    if law.instance_class is not PartnerLaw:
        return None
    return lambda law, overlap, memory: energy_of(
        law.law, overlap, memory[:3], memory[3:], law.radius, law.mass
    )


def add_law(kind, law, has_plugin):
    """Register a type of parameters as a law, with its functions, of a plug-in or of Talus."""
    if adopt_type(kind, has_plugin):
        if law.force:
            _inline(law.force)
        _add_functions(kind, *law.of(kind), law.energy)


#: A function that several types have is registered once.
_inline = cache(inlined)


def _add_functions(kind, force, own_numbers, vectors, energy):
    """Register functions for a type; it remembers ``own_numbers`` besides the tangential force."""
    own_force, own_energy = _inline(force), _inline(energy)
    _functional.add(kind)
    declare_memory(kind, own_numbers, vectors=vectors)

    @implements(force_of)
    def _force(law, overlap, approach, slip, tangential, memory, radius, mass):
        if law.instance_class is not kind:
            return None

        def body(law, overlap, approach, slip, tangential, memory, radius, mass):
            return checked_force(
                law, own_force(law, overlap, approach, slip, tangential, memory, radius, mass)
            )

        return body

    @implements(checked_force)
    def _checked_force(law, returned):
        if law.instance_class is not kind:
            return None
        if not (isinstance(returned, BaseTuple) and len(returned) == 4):
            message = (
                "what force returns is no tuple of normal force, tangential force, numbers to "
            )
            raise typing_error(force, f"{message}remember and energy: got {returned}")
        normal, tangential, numbers, loss = returned
        require_numbers(force, "normal force and energy that force returns", (normal, loss), 2)
        require_numbers(force, "the tangential force that force returns", tangential, 3, Float)
        subject = f"what force gives to remember, {own_numbers} as remembers says,"
        require_numbers(force, subject, numbers, own_numbers, Float)
        return lambda law, returned: returned

    @implements(checked_energy)
    def _checked_energy(law, returned):
        if law.instance_class is not kind:
            return None
        require_numbers(energy, "what energy returns", returned, 2)
        return lambda law, returned: returned

    @implements(energy_of)
    def _energy(law, overlap, tangential, memory, radius, mass):
        if law.instance_class is not kind:
            return None
        return lambda law, overlap, tangential, memory, radius, mass: checked_energy(
            law, own_energy(law, overlap, tangential, memory, radius, mass)
        )
