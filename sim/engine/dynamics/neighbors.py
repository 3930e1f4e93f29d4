"""Neighbor list with a skin, and the slots that tie its pairs to the memory of their contacts.

The list is valid while no pair outside it can have come into contact; ``mean_flow`` computes how
long that is.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np

from sim.engine.compile import LANES, append_negative, assume_no_alias, inlined
from sim.engine.dynamics.cells import (
    LIST_FULL,
    NOT_FINITE,
    OK,
    Box,
    Grid,
    Part,
    SortedParticles,
    assign_cells,
    find_pairs,
    nearest_image,
    sort_by_cell,
    wrap,
)
from sim.engine.dynamics.mean_flow import AGE
from sim.engine.dynamics.team import Share

#: Number of pairs or particles that are examined together.
BLOCK = 256

#: Threads that may share a list, and most room that they need between their touching pairs.
MOST_THREADS = 256
MARGIN = 16 * MOST_THREADS


class NextList(NamedTuple):
    """The next list, while threads build it.

    Each thread fills its own part of ``second`` and ``slot``. ``start`` and ``stop`` (N,) delimit
    the pairs of each particle; ``count`` is the number of pairs of each thread.
    """

    second: np.ndarray
    slot: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    count: np.ndarray


class PairList(NamedTuple):
    """Pairs within reach of each other, sorted by their first particle; always first < second.

    ``first``, ``second`` (P,) particles; ``reach`` (P,) sum of the radii (m); ``slot`` (P,) column
    of the contact's memory, -1 if it did not touch in the last step; ``touching``
    (P + MARGIN,) numbers of touching pairs; ``start`` (N + 1,) first pair of each particle. Since
    the last build: ``anchor`` (D, N) positions at that time, ``drift`` (D,) mean displacement (m),
    ``stream`` (N,) velocity of the mean flow at each particle relative to the mean of all (m/s),
    ``clock`` (2,) see ``mean_flow``, ``valid`` (1,). ``skin`` and the ``largest`` sum of two radii
    and the law's reach in m; ``box`` is the periodic cell.
    """

    first: np.ndarray
    second: np.ndarray
    reach: np.ndarray
    slot: np.ndarray
    touching: np.ndarray
    start: np.ndarray
    anchor: np.ndarray
    drift: np.ndarray
    stream: np.ndarray
    clock: np.ndarray
    valid: np.ndarray
    next: NextList
    skin: float
    largest: float
    box: Box


class Bond(NamedTuple):
    """What the law of the contacts asks of their list: how many ``turning`` numbers of a memory,
    its first, change sign where the partners change places; ``reach`` (m) beyond contact."""

    turning: int
    reach: float


class Search(NamedTuple):
    """Scratch of the search for contacts: ``gap`` (m² or m), and numbers of the ``touching``."""

    gap: np.ndarray
    touching: np.ndarray


def make_search(particles: int = BLOCK) -> Search:
    """Return scratch space to examine this many particles together, or a block of pairs."""
    room = max(BLOCK, particles)
    return Search(np.zeros(room), np.zeros(room + LANES, np.uint32))


def empty_pair_list(
    radius: np.ndarray, box: Box, skin: float, per_particle: int = 8, reach: float = 0.0
) -> PairList:
    """Return a list without pairs, with room for ``per_particle`` pairs per particle.

    ``radius`` (N,), ``skin`` and the law's ``reach`` beyond contact in m.
    """
    dimension = len(box.length)
    particles = len(radius)
    capacity = per_particle * particles + 64
    return PairList(
        first=np.zeros(capacity, np.uint32),
        second=np.zeros(capacity, np.uint32),
        reach=np.zeros(capacity),
        slot=np.full(capacity, -1, np.int32),
        touching=np.zeros(capacity + MARGIN, np.uint32),
        start=np.zeros(particles + 1, np.int64),
        anchor=np.full((dimension, particles), np.nan),
        drift=np.zeros(dimension),
        stream=np.zeros(particles),
        clock=np.zeros(2),
        valid=np.zeros(1, np.bool_),
        next=NextList(
            np.zeros(capacity, np.uint32),
            np.full(capacity, -1, np.int32),
            np.zeros(particles, np.int64),
            np.zeros(particles, np.int64),
            np.zeros(MOST_THREADS, np.int64),
        ),
        skin=skin,
        largest=2.0 * float(np.max(radius)) + reach,
        box=box,
    )


def double_room(pairs: PairList) -> PairList:
    """Return a copy of the list with twice the room."""
    double = {
        name: np.pad(getattr(pairs, name), (0, len(pairs.first)))
        for name in ("first", "second", "reach", "slot", "touching")
    }
    second, slot = (np.pad(array, (0, len(array))) for array in pairs.next[:2])
    return pairs._replace(**double, next=pairs.next._replace(second=second, slot=slot))


@inlined
def find_touching(position, pairs, begin, end, base, gap, reach=0.0):
    """Put the touching pairs among ``begin``..``end`` into ``pairs.touching`` from ``base`` on.

    These are all that are closer than the law's ``reach`` (m) beyond contact. Returns their number.
    The list is examined in blocks of the size of ``gap``, which is scratch.
    """
    box, touching = pairs.box, np.uint64(base)
    for start in range(begin, end, gap.size):
        size = min(gap.size, end - start)
        for k in range(size):
            p = np.uint64(start + k)
            i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
            square = 0.0
            for d in range(len(box.length)):
                square += nearest_image(position[d, j] - position[d, i], box, d) ** 2
            most = pairs.reach[p] + reach
            gap[k] = square - most * most
        touching += append_negative(gap, size, start, pairs.touching, touching)
    return np.int64(touching) - base


@inlined
def find_next(pairs, position, radius, bond, rank, threads):
    """Find one thread's part of the next list; return all sorted particles and the thread's share.

    All threads sort, which is cheap, and search in their own cells. The share is the range of
    particles that are first partners of a thread's pairs. ``pairs.next.count`` is -1 where there
    was no room.
    """
    dimension, particles = position.shape
    next_list, box = pairs.next, pairs.box
    cells = np.ones(dimension, np.int64)
    cell = assign_cells(position, box, pairs.largest + pairs.skin, cells)
    order, begin = sort_by_cell(cell, cells)
    place, size = np.empty((dimension, particles)), np.empty(particles)
    for i in range(particles):
        size[i] = radius[order[i]]
        for d in range(dimension):
            place[d, i] = position[d, order[i]]
    first, last = 0, 0
    while begin[first] * threads < particles * rank:
        first += 1
    while begin[last] * threads < particles * (rank + 1):
        last += 1
    room = next_list.second.size // threads
    part = Part(first, last, rank * room, room)
    ordered = SortedParticles(order, place, size)
    next_list.count[rank] = find_pairs(
        ordered, Grid(box, cells, begin), pairs.skin + bond.reach, part, next_list
    )
    for p in range(part.base, part.base + room):
        next_list.slot[np.uint64(p)] = -1
    return ordered, Share(rank, begin[first], begin[last])


@inlined
def carry_slots(pairs, order, memory, bond, first, last):
    """Copy the memory slots of the contacts among pairs ``first``..``last`` to the next list.

    ``memory`` (M, C) is that of the last step: where partners change places, the remembered vectors
    change sign.
    """
    next_list, rank = pairs.next, np.empty(order.size, np.int64)
    for i in range(order.size):
        rank[order[i]] = i
    gap, touching = np.empty(BLOCK), np.empty(BLOCK + LANES, np.uint32)
    for begin in range(first, last, BLOCK):
        size = min(BLOCK, last - begin)
        for k in range(size):
            gap[k] = -0.5 - pairs.slot[np.uint64(begin + k)]
        for k in range(append_negative(gap, size, begin, touching, np.uint64(0))):
            p = np.uint64(touching[k])
            s = np.uint64(pairs.slot[p])
            i, j = rank[pairs.first[p]], rank[pairs.second[p]]
            if i > j:
                i, j = j, i
                for m in range(bond.turning):
                    memory[m, s] = -memory[m, s]
            new = np.uint64(next_list.start[i])
            while new < next_list.stop[i] and next_list.second[new] != j:
                new += np.uint64(1)
            if new < next_list.stop[i]:
                next_list.slot[new] = s


@inlined
def adopt_part(pairs, position, ordered, share, threads):
    """Copy a thread's part of the next list, for its share of the particles, into the list.

    ``position`` is sorted as ``ordered``; these positions become the origin of displacements.
    """
    assume_no_alias()
    next_list, offset, total = pairs.next, 0, 0
    rank, first, last = share
    for other in range(threads):
        offset += next_list.count[other] if other < rank else 0
        total += next_list.count[other]
    shift = rank * (next_list.second.size // threads) - offset
    for d in range(position.shape[0]):
        for k in range(first, last):
            i = np.uint64(k)
            position[d, i] = ordered.place[d, i]
            pairs.anchor[d, i] = ordered.place[d, i]
    for i in range(first, last):
        pairs.start[i] = next_list.start[i] - shift
        for p in range(next_list.start[i] - shift, next_list.stop[i] - shift):
            pairs.first[p] = i
    if last == position.shape[1]:
        pairs.start[last] = total
    for k in range(offset, offset + next_list.count[rank]):
        p, q = np.uint64(k), np.uint64(k + shift)
        pairs.second[p] = next_list.second[q]
        pairs.slot[p] = next_list.slot[q]
        i, j = np.uint64(pairs.first[p]), np.uint64(next_list.second[q])
        pairs.reach[p] = ordered.size[i] + ordered.size[j]


@inlined
def wrap_particles(pairs, position):
    """Move all particles into the periodic cell and restart drift and clock for the next list.

    Returns a status, NOT_FINITE where a position is not finite.
    """
    for d in range(position.shape[0]):
        for i in range(position.shape[1]):
            if not isfinite(position[d, i]):
                return NOT_FINITE
    wrap(position, pairs.box)
    for d in range(pairs.drift.size):
        pairs.drift[d] = 0.0
    pairs.clock[AGE] = 0.0
    return OK


@inlined
def has_room(pairs, threads):
    """True where there was room for the whole next list."""
    least = 0
    for rank in range(threads):
        least = min(least, pairs.next.count[rank])
    return least == 0


@inlined
def refresh(pairs, position, radius, memory):
    """Rebuild the list with a single thread; return a status and the order of the particles.

    ``memory`` is that of the last step. ``position`` (D, N) is sorted; column i of every other
    array of the particles must become ``order[i]``. On LIST_FULL nothing has changed but that
    positions are wrapped.
    """
    status = wrap_particles(pairs, position)
    if status != OK:
        return status, np.empty(0, np.int64)
    no_bond = Bond(0, 0.0)
    ordered, share = find_next(pairs, position, radius, no_bond, 0, 1)
    if not has_room(pairs, 1):
        return LIST_FULL, ordered.order
    carry_slots(pairs, ordered.order, memory, no_bond, 0, pairs.start[ordered.order.size])
    adopt_part(pairs, position, ordered, share, 1)
    pairs.valid[0] = True
    return OK, ordered.order
