"""The plane z = 0, under chute and conveyor: a sphere of infinite radius and mass."""

from typing import NamedTuple

import numpy as np

from sim.engine.compile import LANES, append_negative, assume_no_alias, inlined, kernel
from sim.engine.contact.friction import (
    blank_memory,
    make_memory,
    recall,
    recall_in_loop,
    stored_energy,
)
from sim.engine.contact.functions import add_torque, gap_to_plane, law_on_plane, touching_number
from sim.engine.dynamics.neighbors import BLOCK
from sim.engine.dynamics.spheres import (
    DEPTH,
    FX,
    LOSS,
    MX,
    STRIDE,
    WORK,
    Meeting,
    apply_law,
    fill_vectors,
    write_approach,
)


class Plane(NamedTuple):
    """``slot`` (1, N): where each particle's contact is in ``memory`` (2, M, C), -1 for none."""

    slot: np.ndarray
    memory: np.ndarray


def make_plane(law: NamedTuple, particles: int, threads: int = 1) -> Plane:
    """Return a plane without contacts, for spheres that obey this law."""
    memory = make_memory(law, particles + LANES * threads)
    return Plane(np.full((1, particles), -1, np.int32), memory)


@inlined
def _find_touching(spheres, contacts, start, size, search):
    """List the touching ones of ``size`` particles from ``start`` on; return their number."""
    for k in range(size):
        i = np.uint64(start + k)
        search.gap[k] = gap_to_plane(contacts.law, spheres, i, contacts.reach)
    return np.int64(append_negative(search.gap, size, start, search.touching, np.uint64(0)))


@inlined
def _evaluate(spheres, contacts, scratch, number, base, time_step):
    """Apply the law to ``number`` touching particles of a block; the memory goes to base + k."""
    x, v, w = spheres.position, spheres.velocity, spheres.rim
    slot, touching, rows = contacts.partners, scratch.search.touching, scratch.rows
    new = blank_memory(contacts.law)
    for k in range(number):
        i = np.uint64(touching[k])
        velocity, rim = (-v[0, i], -v[1, i], -v[2, i]), (w[0, i], w[1, i], w[2, i])
        separation = (0.0, 0.0, -x[2, i])
        write_approach(rows, k, Meeting(separation, velocity, rim, spheres.radius[i]), time_step)
    for k in range(number):
        i = np.uint64(touching[k])
        law = law_on_plane(contacts.law, spheres, i, time_step)
        memory = recall_in_loop(contacts.law, new, contacts.before, slot[0, i])
        memory = apply_law(law, rows, k, memory)
        for m in range(len(new)):
            contacts.after[m, np.uint64(base + k)] = memory[m]


@inlined
def plane_forces(spheres, contacts, scratch, time_step, share):
    """Add the forces of the plane on one thread's share of the particles.

    Returns the number of touching spheres, the largest overlap relative to a diameter, the energy
    dissipated by normal forces and the work done against friction (J), and the sum of the forces on
    the spheres along x and z (N).
    """
    assume_no_alias()
    rank, begin, end = share
    slot, touching, rows = contacts.partners, scratch.search.touching, scratch.rows
    contact_count, found, largest, along, upward = 0, 0, 0.0, 0.0, 0.0
    loss, work = 0.0, 0.0
    for start in range(begin, end, BLOCK):
        size = min(BLOCK, end - start)
        number = _find_touching(spheres, contacts, start, size, scratch.search)
        base = begin + rank * LANES + found
        if number > 0:
            padded_number = fill_vectors(touching, 0, number)
            _evaluate(spheres, contacts, scratch, padded_number, base, time_step)
        for i in range(start, start + size):
            slot[0, np.uint64(i)] = -1
        for k in range(number):
            i = np.uint64(touching[k])
            slot[0, i] = base + k
            for d in range(3):
                spheres.force[rank, d, i] += rows[(FX + d) * STRIDE + k]
                spheres.moment[rank, d, i] += rows[(MX + d) * STRIDE + k]
            add_torque(contacts.law, spheres, contacts.after, base + k, i, 1.0, rank)
            along += rows[FX * STRIDE + k]
            upward += rows[(FX + 2) * STRIDE + k]
            loss += rows[LOSS * STRIDE + k]
            work += rows[WORK * STRIDE + k]
            # Not the overlap of the row, which is symmetric about the plane: a centre may be below.
            overlap = spheres.radius[i] - spheres.position[2, i]
            diameter = 2.0 * spheres.radius[i]
            if overlap > largest * diameter:
                largest = overlap / diameter
        found += number
        contact_count += touching_number(contacts.law, rows, DEPTH * STRIDE, number)
    return contact_count, largest, loss, work, along, upward


@kernel
def stored_in_plane(law, spheres, plane, memory, time_step):
    """Return the energy (J) in the normal and tangential springs of all contacts with the plane.

    Arguments as for ``stored_in_spheres``.
    """
    normal, tangential, new = 0.0, 0.0, blank_memory(law)
    for i in range(spheres.radius.size):
        if plane.slot[0, i] < 0:
            continue
        height = spheres.position[2, i] - spheres.velocity[2, i] * time_step
        overlap = spheres.radius[i] - abs(height)
        plane_law = law_on_plane(law, spheres, i, time_step)
        normal_energy, tangential_energy = stored_energy(
            plane_law, overlap, recall(new, memory, plane.slot[0, i])
        )
        normal += normal_energy
        tangential += tangential_energy
    return normal, tangential
