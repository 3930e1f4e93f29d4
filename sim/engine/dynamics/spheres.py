"""Spheres, and the forces between them, in three dimensions.

The touching pairs of the neighbor list are collected and evaluated in blocks that stay in the
nearest cache. One loop computes how the partners of each pair approach each other, one applies the
law, and one adds the results to the particles. The first two have no branches, so the compiler
turns them into vector instructions. They are separate because a processor overlaps the iterations
of short loops better.
"""

from typing import NamedTuple

import numpy as np

from sim.engine.compile import LANES, assume_no_alias, inlined, kernel
from sim.engine.contact.friction import (
    blank_memory,
    contact_force,
    inverse_square_root,
    recall,
    recall_in_loop,
    stored_energy,
)
from sim.engine.contact.functions import add_torque, law_between, reach_of, touching_number
from sim.engine.dynamics.cells import nearest_image, round_up
from sim.engine.dynamics.neighbors import BLOCK, Search, find_touching, make_search

#: Distance between rows of a block. It is no power of two, or all rows would compete for the same
#: few lines of the cache.
STRIDE = BLOCK + LANES

# Rows of a block of contacts: normal, slip, approach, overlap and reach. The law replaces the first
# seven one by one with its results; separate rows would not fit into the nearest cache.
NX, NY, NZ, SX, SY, SZ, APPROACH, DEPTH, REACH = range(9)
FX, FY, FZ, MX, MY, MZ, LOSS, WORK = *range(7), 9
ROWS = 10

#: Moment of inertia of a solid sphere over m r².
SOLID = 0.4


class Spheres(NamedTuple):
    """The particles, one column each, in SI units. Those without mass are fixed in space.

    ``position``, ``velocity`` and ``rim`` (3, N); ``rim`` is the angular velocity times the radius
    (m/s). Velocities belong to the half step before the position. ``force`` and ``moment``
    (T, 3, N) hold the sums of each of T threads in the last evaluation: a thread adds to its own
    particles and to those of later threads; ``moment`` is the torque over the radius (N).
    ``radius``, ``mass`` and ``inverse_mass`` (N,), the last two 0 for fixed ones. ``orientation``
    (4, N) as unit quaternions, or (4, 0). ``label`` (1, N) is the particle's number in the initial
    state, as the neighbor list keeps the particles sorted by position.
    """

    position: np.ndarray
    velocity: np.ndarray
    rim: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    inverse_mass: np.ndarray
    orientation: np.ndarray
    label: np.ndarray


class Contacts(NamedTuple):
    """The contacts of spheres with each other or with a boundary in one step.

    ``law``; ``partners``: a pair list or the slots of a plane; memory ``before`` and ``after`` the
    step (M, C); ``reach`` (m) of the law beyond contact.
    """

    law: NamedTuple
    partners: NamedTuple
    before: np.ndarray
    after: np.ndarray
    reach: float


class Scratch(NamedTuple):
    """Scratch of one thread: that of the ``search``, and flat ``rows`` of a block of contacts."""

    search: Search
    rows: np.ndarray


class Block(NamedTuple):
    """``number`` contacts that are evaluated together in ``rows``; memory from ``base`` on."""

    rows: np.ndarray
    base: int
    number: int


class Meeting(NamedTuple):
    """How the partners i, j of a contact meet: ``separation`` (m) and ``velocity`` of j relative to
    i, ``rim``, the sum of both rims (m/s), ``reach``, the sum of the radii (m)."""

    separation: tuple[float, float, float]
    velocity: tuple[float, float, float]
    rim: tuple[float, float, float]
    reach: float


def make_spheres(
    position, velocity, radius, mass, threads: int = 1, oriented: bool = False
) -> Spheres:
    """Return solid spheres at positions and velocities (N, 3) that do not rotate.

    ``radius`` and ``mass`` may be numbers or arrays (N,); a mass of 0 stands for a sphere that is
    fixed in space, whose velocity must be 0. ``oriented`` spheres have orientations.
    """
    number = len(position)
    radius = np.broadcast_to(np.asarray(radius, float), number).copy()
    mass = np.broadcast_to(np.asarray(mass, float), number).copy()
    return Spheres(
        np.array(np.transpose(position), float, order="C"),
        np.array(np.transpose(velocity), float, order="C"),
        np.zeros((3, number)),
        np.zeros((threads, 3, number)),
        np.zeros((threads, 3, number)),
        radius,
        mass,
        np.divide(1.0, mass, out=np.zeros(number), where=mass > 0.0),
        unrotated_orientations(number if oriented else 0),
        np.arange(number).reshape(1, number),
    )


def unrotated_orientations(particles: int) -> np.ndarray:
    """Return the orientations (4, N) of spheres that have not turned yet."""
    orientation = np.zeros((4, particles))
    orientation[0] = 1.0
    return orientation


def make_scratch() -> Scratch:
    """Return scratch space for one thread."""
    return Scratch(make_search(), np.zeros(ROWS * STRIDE))


@inlined
def write_approach(rows, k, meeting, time_step):
    """Write normal, slip and approach during the step, overlap and reach (m) to column k."""
    (dx, dy, dz), velocity, (wx, wy, wz), reach = meeting
    square = dx * dx + dy * dy + dz * dz
    scale = inverse_square_root(square)
    nx, ny, nz = dx * scale, dy * scale, dz * scale
    sx = velocity[0] - (wy * nz - wz * ny)
    sy = velocity[1] - (wz * nx - wx * nz)
    sz = velocity[2] - (wx * ny - wy * nx)
    along = sx * nx + sy * ny + sz * nz
    rows[NX * STRIDE + k] = nx
    rows[NY * STRIDE + k] = ny
    rows[NZ * STRIDE + k] = nz
    rows[SX * STRIDE + k] = (sx - along * nx) * time_step
    rows[SY * STRIDE + k] = (sy - along * ny) * time_step
    rows[SZ * STRIDE + k] = (sz - along * nz) * time_step
    rows[DEPTH * STRIDE + k] = reach - square * scale
    rows[REACH * STRIDE + k] = reach
    rows[APPROACH * STRIDE + k] = -along * time_step


@inlined
def apply_law(law, rows, k, memory):
    """Replace normal and slip in column k by force on i and moment (N); return the new memory.

    The approach is replaced by the energy (J) that the normal force has dissipated, and the work
    done against friction is added.
    """
    nx, ny, nz = rows[NX * STRIDE + k], rows[NY * STRIDE + k], rows[NZ * STRIDE + k]
    slip = (rows[SX * STRIDE + k], rows[SY * STRIDE + k], rows[SZ * STRIDE + k])
    overlap = rows[DEPTH * STRIDE + k]
    approach = rows[APPROACH * STRIDE + k]
    force, (tx, ty, tz), memory, (loss, work) = contact_force(
        law, overlap, approach, (nx, ny, nz), slip, memory
    )
    rows[FX * STRIDE + k] = tx - force * nx
    rows[FY * STRIDE + k] = ty - force * ny
    rows[FZ * STRIDE + k] = tz - force * nz
    rows[MX * STRIDE + k] = ny * tz - nz * ty
    rows[MY * STRIDE + k] = nz * tx - nx * tz
    rows[MZ * STRIDE + k] = nx * ty - ny * tx
    rows[LOSS * STRIDE + k] = loss
    rows[WORK * STRIDE + k] = work
    return memory


@inlined
def _evaluate(spheres, contacts, block, time_step):
    """Apply the law to the touching pairs of a block; repeated ones fill the last vector."""
    x, v, w = spheres.position, spheres.velocity, spheres.rim
    pairs, rows, number = contacts.partners, block.rows, round_up(block.number, LANES)
    new = blank_memory(contacts.law)
    for k in range(number):
        p = np.uint64(pairs.touching[np.uint64(block.base + k)])
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        velocity = (v[0, j] - v[0, i], v[1, j] - v[1, i], v[2, j] - v[2, i])
        rim = (w[0, j] + w[0, i], w[1, j] + w[1, i], w[2, j] + w[2, i])
        separation = nearest_separation(x, pairs.box, i, j)
        write_approach(rows, k, Meeting(separation, velocity, rim, pairs.reach[p]), time_step)
    for k in range(number):
        c = np.uint64(block.base + k)
        slot = pairs.slot[pairs.touching[c]]
        memory = recall_in_loop(contacts.law, new, contacts.before, slot)
        law = law_between(contacts.law, spheres, pairs, pairs.touching[c], time_step)
        memory = apply_law(law, rows, k, memory)
        for m in range(len(new)):
            contacts.after[m, c] = memory[m]


@inlined
def nearest_separation(x, box, i, j):
    """Return the vector from i to the nearest periodic image of j."""
    return (
        nearest_image(x[0, j] - x[0, i], box, 0),
        nearest_image(x[1, j] - x[1, i], box, 1),
        x[2, j] - x[2, i],
    )


@inlined
def _scatter(spheres, contacts, block, rank):
    """Add forces and moments to both partners.

    Returns the largest relative overlap, the energy dissipated by normal forces and the work done
    against friction (J).
    """
    largest, loss, work = 0.0, 0.0, 0.0
    force, moment, rows = spheres.force, spheres.moment, block.rows
    law, pairs = contacts.law, contacts.partners
    for k in range(block.number):
        c = np.uint64(block.base + k)
        p = np.uint64(pairs.touching[c])
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        for d in range(3):
            force[rank, d, i] += rows[(FX + d) * STRIDE + k]
            force[rank, d, j] -= rows[(FX + d) * STRIDE + k]
            moment[rank, d, i] += rows[(MX + d) * STRIDE + k]
            moment[rank, d, j] += rows[(MX + d) * STRIDE + k]
        add_torque(law, spheres, contacts.after, c, i, 1.0, rank)
        add_torque(law, spheres, contacts.after, c, j, -1.0, rank)
        if rows[DEPTH * STRIDE + k] > largest * rows[REACH * STRIDE + k]:
            largest = rows[DEPTH * STRIDE + k] / rows[REACH * STRIDE + k]
        loss += rows[LOSS * STRIDE + k]
        work += rows[WORK * STRIDE + k]
    return largest, loss, work


@inlined
def fill_vectors(list_, begin, number):
    """Repeat the last of ``number`` entries up to a multiple of ``LANES``; return that multiple.

    A loop over whole vectors has no remainder, whose contacts would cost as much as a vector each.
    """
    whole = round_up(number, LANES)
    for k in range(number, whole):
        list_[begin + k] = list_[begin + number - 1]
    return whole


@inlined
def sphere_forces(spheres, contacts, scratch, time_step, share):
    """Add the forces of the touching pairs whose first partners are in one thread's share.

    Returns the number of touching pairs, the largest overlap relative to the sum of the radii, the
    energy dissipated by normal forces and the work done against friction (J).
    """
    assume_no_alias()
    pairs, gap = contacts.partners, scratch.search.gap
    first, last = pairs.start[share.begin], pairs.start[share.end]
    base = first + share.rank * LANES
    reach = reach_of(contacts.law, contacts.reach)
    touching = find_touching(spheres.position, pairs, first, last, base, gap, reach)
    fill_vectors(pairs.touching, base, touching)
    number, largest, loss, work = 0, 0.0, 0.0, 0.0
    for start in range(base, base + touching, BLOCK):
        block = Block(scratch.rows, start, min(BLOCK, base + touching - start))
        _evaluate(spheres, contacts, block, time_step)
        block_largest, block_loss, block_work = _scatter(spheres, contacts, block, share.rank)
        number += touching_number(contacts.law, block.rows, DEPTH * STRIDE, block.number)
        largest = max(largest, block_largest)
        loss += block_loss
        work += block_work
    for p in range(first, last):
        pairs.slot[np.uint64(p)] = -1
    for c in range(base, base + touching):
        pairs.slot[pairs.touching[np.uint64(c)]] = c
    return number, largest, loss, work


@kernel
def stored_in_spheres(law, spheres, pairs, memory, time_step):
    """Return the energy (J) in the normal and tangential springs of all pairs in contact.

    ``memory`` (M, C) is that of the last step, and the overlaps are those of its force evaluation,
    one displacement ago.
    """
    x, v = spheres.position, spheres.velocity
    normal, tangential, new = 0.0, 0.0, blank_memory(law)
    for p in range(pairs.start[-1]):
        if pairs.slot[p] < 0:
            continue
        i, j = pairs.first[p], pairs.second[p]
        dx, dy, dz = nearest_separation(x, pairs.box, i, j)
        dx -= (v[0, j] - v[0, i]) * time_step
        dy -= (v[1, j] - v[1, i]) * time_step
        dz -= (v[2, j] - v[2, i]) * time_step
        overlap = pairs.reach[p] - (dx * dx + dy * dy + dz * dz) ** 0.5
        pair_law = law_between(law, spheres, pairs, p, time_step)
        normal_energy, tangential_energy = stored_energy(
            pair_law, overlap, recall(new, memory, pairs.slot[p])
        )
        normal += normal_energy
        tangential += tangential_energy
    return normal, tangential


@inlined
def rotate(orientation, rim, radius, time_step, begin, end):
    """Turn the spheres ``begin``..``end`` by their spin ``rim / radius`` during one step.

    dq/dt = ω q / 2 (Evans 1977 in laboratory axes), then scaled back to unit length, which makes
    the angle exact to third order in the step. Orientations may be empty.
    """
    assume_no_alias()
    for k in range(begin, min(end, orientation.shape[1])):
        i = np.uint64(k)
        half = 0.5 * time_step / radius[i]
        w, x, y, z = orientation[0, i], orientation[1, i], orientation[2, i], orientation[3, i]
        a, b, c = half * rim[0, i], half * rim[1, i], half * rim[2, i]
        nw = w - a * x - b * y - c * z
        nx = x + a * w + b * z - c * y
        ny = y - a * z + b * w + c * x
        nz = z + a * y - b * x + c * w
        scale = inverse_square_root(nw * nw + nx * nx + ny * ny + nz * nz)
        orientation[0, i] = nw * scale
        orientation[1, i] = nx * scale
        orientation[2, i] = ny * scale
        orientation[3, i] = nz * scale
