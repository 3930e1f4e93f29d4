"""Neighbor list with a skin, and the slots that tie its pairs to the memory of their contacts.

The list holds as long as no pair that is not in it can have come into contact; ``mean_flow`` says
how long that is.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np

from sim.compile import append_negative, inlined, vectorised
from sim.contact.friction import VECTOR
from sim.dynamics.cells import (
    Candidates,
    assign_cells,
    find_pairs,
    make_candidates,
    nearest_image,
    reorder,
    sort_by_cell,
    wrap,
)
from sim.dynamics.mean_flow import AGE
from sim.dynamics.status import LIST_FULL, NOT_FINITE, OK

#: Room that the threads of a run may need between their shares of the touching pairs.
MARGIN = 4096


class PairList(NamedTuple):
    """Pairs within reach of each other, sorted by their first particle; always first < second.

    ``first``, ``second`` (P,) particles; ``reach`` (P,) sum of the radii (m); ``slot`` (P,) where
    the contact is remembered, -1 if it did not touch in the last step; ``touching`` (P,) those that
    touch; ``start`` (N + 1,) first
    pair of each particle. Since the last build: ``anchor`` (D, N) positions at that time, ``drift``
    (D,) mean displacement (m), ``stream`` (N,) velocity of the mean flow at each particle relative
    to all (m/s), ``clock`` (2,) see ``mean_flow``, ``valid`` (1,). ``skin`` and the ``largest`` sum
    of two radii in m; ``candidates`` is scratch.
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
    candidates: Candidates
    skin: float
    largest: float


def empty_pair_list(
    radius: np.ndarray, dimension: int, skin: float, per_particle: int = 8
) -> PairList:
    """Return a list without pairs, with room for ``per_particle`` pairs per particle.

    ``radius`` (N,) and ``skin`` in m.
    """
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
        candidates=make_candidates(particles),
        skin=skin,
        largest=2.0 * float(np.max(radius)),
    )


def grown(pairs: PairList) -> PairList:
    """Return a copy of the list with twice the room."""
    return pairs._replace(
        first=np.concatenate([pairs.first, np.zeros_like(pairs.first)]),
        second=np.concatenate([pairs.second, np.zeros_like(pairs.second)]),
        reach=np.concatenate([pairs.reach, np.zeros_like(pairs.reach)]),
        slot=np.concatenate([pairs.slot, np.full_like(pairs.slot, -1)]),
        touching=np.concatenate([pairs.touching, np.zeros_like(pairs.touching)]),
    )


@inlined
def find_touching(position, pairs, box, begin, end, base, gap):
    """Put the touching pairs among ``begin``..``end`` into ``pairs.touching`` from ``base`` on.

    Returns how many. The list is examined in blocks of the size of ``gap``, which is scratch.
    """
    touching = np.uint64(base)
    for start in range(begin, end, gap.size):
        size = min(gap.size, end - start)
        for k in range(size):
            p = np.uint64(start + k)
            i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
            square = 0.0
            for d in range(len(box.length)):
                square += nearest_image(position[d, j] - position[d, i], box, d) ** 2
            gap[k] = square - pairs.reach[p] * pairs.reach[p]
        touching += append_negative(gap, size, start, pairs.touching, touching)
    return np.int64(touching) - base


@inlined
def _carry_slots(pairs, rank, start, second, slot, memory):
    """Fill ``slot`` (P,) of the new pairs: of those that touch, that of the old pair.

    ``rank`` is the new number of each particle. Where partners change places, the remembered force
    changes sign.
    """
    gap, touching = pairs.candidates.gap, pairs.candidates.near
    for p in range(slot.size):
        slot[p] = -1
    for begin in range(0, pairs.start[-1], gap.size):
        size = min(gap.size, pairs.start[-1] - begin)
        for k in range(size):
            gap[k] = -0.5 - pairs.slot[np.uint64(begin + k)]
        for k in range(append_negative(gap, size, begin, touching, np.uint64(0))):
            p = np.uint64(touching[k])
            s = np.uint64(pairs.slot[p])
            i, j = rank[pairs.first[p]], rank[pairs.second[p]]
            if i > j:
                i, j = j, i
                for m in range(VECTOR):
                    memory[m, s] = -memory[m, s]
            new = np.uint64(start[i])
            while new < start[i + 1] and second[new] != j:
                new += np.uint64(1)
            if new < start[i + 1]:
                slot[new] = s


@inlined
def rebuild(pairs, position, radius, box, memory):
    """Find all pairs anew; return whether there was room, and the order of the particles to adopt.

    ``memory`` is that of the last step. ``position`` (D, N) must lie in the periodic cell. The list
    refers to the particles in their new order: column i of every array of theirs must become
    ``order[i]``. Without room nothing has changed.
    """
    dimension, particles = position.shape
    cells = np.ones(dimension, np.int64)
    cell = assign_cells(position, box, pairs.largest + pairs.skin, cells)
    order, begin = sort_by_cell(cell, cells)
    reorder(position, order)
    rank, sizes = np.empty(particles, np.int64), np.empty(particles)
    for i in range(particles):
        rank[order[i]] = i
        sizes[i] = radius[order[i]]
    second = np.empty(pairs.second.size, np.uint32)
    start = np.empty(pairs.start.size, np.int64)
    found = find_pairs(
        position, sizes, box, pairs.skin, cells, begin, pairs.candidates, second, start
    )
    if not found:
        reorder(position, rank)
        return False, order
    slot = np.empty(start[-1], np.int32)
    _carry_slots(pairs, rank, start, second, slot, memory)
    _adopt(pairs, position, start, second, slot, sizes)
    return True, order


@inlined
def _adopt(pairs, position, start, second, slot, radius):
    """Make these pairs the list, and these positions those that displacements count from."""
    vectorised()
    for d in range(position.shape[0]):
        for i in range(position.shape[1]):
            pairs.anchor[d, i] = position[d, i]
    pairs.start[start.size - 1] = start[start.size - 1]
    for i in range(start.size - 1):
        pairs.start[i] = start[i]
        for p in range(start[i], start[i + 1]):
            pairs.first[p] = i
    for p in range(start[-1]):
        i, j = np.uint64(pairs.first[p]), np.uint64(second[p])
        pairs.second[p] = second[p]
        pairs.slot[p] = slot[p]
        pairs.reach[p] = radius[i] + radius[j]


@inlined
def refresh(pairs, position, radius, box, memory):
    """Wrap and sort the positions and rebuild the list; return a status and the particles' order.

    Arguments as for ``rebuild``.
    """
    order = np.empty(0, np.int64)
    for d in range(position.shape[0]):
        for i in range(position.shape[1]):
            if not isfinite(position[d, i]):
                return NOT_FINITE, order
    wrap(position, box)
    room, order = rebuild(pairs, position, radius, box, memory)
    if not room:
        return LIST_FULL, order
    for d in range(pairs.drift.size):
        pairs.drift[d] = 0.0
    pairs.clock[AGE] = 0.0
    pairs.valid[0] = True
    return OK, order
