"""Contact laws that are plain functions of two partners, those of plug-ins among them.

Between two partners such a law is held together with what it may know of them (`Between`); laws
that need neither radius nor mass stay as they are and cost nothing more.
"""

from typing import NamedTuple

from numba.core.types import BaseTuple, Float

from sim.engine.compile import implements, inlined
from sim.engine.contact.friction import blank, contact_force, remembers, stored_energy
from sim.engine.contact.roots import SMALLEST, inverse_square_root
from sim.engine.contact.tangential import friction_direction, work_against
from sim.engine.plugged import adopt, refused, require_numbers

#: Types of the laws that are such functions.
_functional: set[type] = set()


class Between(NamedTuple):
    """Such a law between two partners: with their reduced ``radius`` (m) and ``mass`` (kg)."""

    law: NamedTuple
    radius: float
    mass: float


def between(law, spheres, pairs, p):
    """Return a law as it is between the spheres of pair p of a list."""
    raise NotImplementedError


def on_plane(law, spheres, i):
    """Return a law as it is between sphere i and the plane."""
    raise NotImplementedError


@implements(between)
def _between(law, spheres, pairs, p):
    if law.instance_class not in _functional:
        return lambda law, spheres, pairs, p: law

    def body(law, spheres, pairs, p):
        i, j = pairs.first[p], pairs.second[p]
        radii = spheres.radius[i] * spheres.radius[j] / (spheres.radius[i] + spheres.radius[j])
        # Of one that is fixed in space the inverse is 0; two of them have no contact that counts.
        inverse = spheres.inverse_mass[i] + spheres.inverse_mass[j]
        return Between(law, radii, 1.0 / inverse if inverse > 0.0 else 0.0)

    return body


@implements(on_plane)
def _on_plane(law, spheres, i):
    if law.instance_class not in _functional:
        return lambda law, spheres, i: law
    return lambda law, spheres, i: Between(law, spheres.radius[i], spheres.mass[i])


@implements(blank)
def _blank(law):
    return (lambda law: blank(law.law)) if law.instance_class is Between else None


@inlined
def turned(normal, tangential):
    """Return a tangential force turned into the present tangent plane, its magnitude kept."""
    ux, uy, uz = friction_direction(normal, tangential)
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    magnitude = square * inverse_square_root(square) if square > SMALLEST else 0.0
    return magnitude * ux, magnitude * uy, magnitude * uz


def force_of(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return what the function ``force`` of a law does, see `sim.parameters.laws.law`."""
    raise NotImplementedError


def given_by(law, returned):
    """Return what ``force`` of a law gives, of which it keeps as many numbers as it said."""
    raise NotImplementedError


def energies_of(law, returned):
    """Return the energies that ``energy`` of a law gives."""
    raise NotImplementedError


def energy_of(law, overlap, tangential, memory, radius, mass):
    """Return what the function ``energy`` of a law does."""
    raise NotImplementedError


@implements(contact_force)
def _contact_force(law, overlap, approach, normal, slip, memory):
    if law.instance_class is not Between:
        return None

    def body(law, overlap, approach, normal, slip, memory):
        before, kept = memory[:3], memory[3:]
        force, tangential, kept, lost = force_of(
            law.law, overlap, approach, slip, turned(normal, before), kept, law.radius, law.mass
        )
        work = work_against(before, tangential, slip)
        return force, tangential, (*tangential, *kept), (lost, work)

    return body


@implements(stored_energy)
def _stored_energy(law, overlap, memory):
    if law.instance_class is not Between:
        return None
    return lambda law, overlap, memory: energy_of(
        law.law, overlap, memory[:3], memory[3:], law.radius, law.mass
    )


def add_law(kind, law):
    """Make a type of parameters known as a law, with the functions of a plug-in for it."""
    if adopt(kind):
        add_functions(kind, law.force, law.energy, law.remembers)


def add_functions(kind, force, energy, kept):
    """Make a type of parameters known as a law with these functions, which keeps such a number of
    numbers of its own."""
    own_force, own_energy = inlined(force), inlined(energy)
    _functional.add(kind)
    remembers(kind, kept)

    @implements(force_of)
    def _force(law, overlap, approach, slip, tangential, memory, radius, mass):
        if law.instance_class is not kind:
            return None

        def body(law, overlap, approach, slip, tangential, memory, radius, mass):
            return given_by(
                law, own_force(law, overlap, approach, slip, tangential, memory, radius, mass)
            )

        return body

    @implements(given_by)
    def _given(law, returned):
        if law.instance_class is not kind:
            return None
        if not (isinstance(returned, BaseTuple) and len(returned) == 4):
            said = "what force returns is no tuple of normal force, tangential force, numbers to "
            raise refused(force, f"{said}remember and energy: got {returned}")
        normal, along, numbers, lost = returned
        require_numbers(force, "normal force and energy that force returns", (normal, lost), 2)
        require_numbers(force, "the tangential force that force returns", along, 3, Float)
        said = f"what force gives to remember, {kept} as remembers says,"
        require_numbers(force, said, numbers, kept, Float)
        return lambda law, returned: returned

    @implements(energies_of)
    def _energies(law, returned):
        if law.instance_class is not kind:
            return None
        require_numbers(energy, "what energy returns", returned, 2)
        return lambda law, returned: returned

    @implements(energy_of)
    def _energy(law, overlap, tangential, memory, radius, mass):
        if law.instance_class is not kind:
            return None
        return lambda law, overlap, tangential, memory, radius, mass: energies_of(
            law, own_energy(law, overlap, tangential, memory, radius, mass)
        )
