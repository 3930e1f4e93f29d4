"""How the threads of one flow share its particles, add up their forces and rebuild their list."""

from typing import NamedTuple

import numpy as np

from sim.engine.compile import assume_no_alias, inlined, kernel, prefer_wide_vectors
from sim.engine.dynamics.cells import LIST_FULL, OK, reorder
from sim.engine.dynamics.mean_flow import set_stream
from sim.engine.dynamics.neighbors import (
    adopt_part,
    carry_slots,
    find_next,
    has_room,
    wrap_particles,
)
from sim.engine.dynamics.spheres import Scratch
from sim.engine.dynamics.team import Share, barrier

#: Particles whose forces are cleared and collected together when several threads add to them.
GROUP = 64


class Sharing(NamedTuple):
    """The shares of T threads, and their results of a step.

    ``border`` (T + 1,) first particle of each thread; ``reached`` (T, N // 64 + 1) True for groups
    of 64 particles of other threads that it adds forces to; ``parts`` (2, T, P) its part of the
    sums of even and of odd steps, as a thread may begin a step while others still add up the last
    one; ``status`` (1,) of the last refresh.
    """

    border: np.ndarray
    reached: np.ndarray
    parts: np.ndarray
    status: np.ndarray


class Thread(NamedTuple):
    """A thread of a team: its ``rank``, the common ``gate``, and ``scratch`` of its own."""

    rank: int
    gate: np.ndarray
    scratch: Scratch


def make_sharing(particles: int, threads: int, parts: int) -> Sharing:
    """Return equal shares of the particles, with room for this many parts of sums."""
    return Sharing(
        np.linspace(0, particles, threads + 1).astype(np.int64),
        np.zeros((threads, particles // GROUP + 1), np.bool_),
        np.zeros((2, threads, parts)),
        np.zeros(1, np.int64),
    )


@inlined
def own_share(sharing, rank):
    """Return the particles of a thread."""
    return Share(rank, sharing.border[rank], sharing.border[rank + 1])


@inlined
def clear_forces(spheres, sharing, share):
    """Clear one thread's forces and moments: on its own particles and on groups marked for it."""
    assume_no_alias()
    rank, begin, end = share
    for d in range(3):
        for k in range(begin, end):
            i = np.uint64(k)
            spheres.force[rank, d, i] = 0.0
            spheres.moment[rank, d, i] = 0.0
    for group in range(end // GROUP, sharing.reached.shape[1]):
        if sharing.reached[rank, group]:
            for k in range(max(end, group * GROUP), min((group + 1) * GROUP, spheres.radius.size)):
                i = np.uint64(k)
                for d in range(3):
                    spheres.force[rank, d, i] = 0.0
                    spheres.moment[rank, d, i] = 0.0


@inlined
def collect_forces(spheres, sharing, share):
    """Add the forces of earlier threads to a thread's forces on its own particles."""
    assume_no_alias()
    rank, begin, end = share
    for other in range(rank):
        for group in range(begin // GROUP, (end + GROUP - 1) // GROUP):
            if sharing.reached[other, group]:
                for k in range(max(begin, group * GROUP), min((group + 1) * GROUP, end)):
                    i = np.uint64(k)
                    for d in range(3):
                        spheres.force[rank, d, i] += spheres.force[other, d, i]
                        spheres.moment[rank, d, i] += spheres.moment[other, d, i]


@kernel
def refresh_together(spheres, pairs, plane, sharing, thread, memory, bond):
    """Rebuild the neighbor list, sort the particles by position and share them out anew.

    All threads call it together; ``memory`` (M, C) is that of the last step. Returns a status:
    unless it is OK, nothing has changed but positions, which are wrapped into the cell.
    """
    prefer_wide_vectors()
    rank, gate = thread.rank, thread.gate
    threads = sharing.border.size - 1
    if rank == 0:
        sharing.status[0] = wrap_particles(pairs, spheres.position)
    barrier(gate)
    if sharing.status[0] != OK:
        return sharing.status[0]
    ordered, share = find_next(pairs, spheres.position, spheres.radius, bond, rank, threads)
    barrier(gate)
    if not has_room(pairs, threads):
        return LIST_FULL
    old_share = own_share(sharing, rank)
    begin, end = pairs.start[old_share.begin], pairs.start[old_share.end]
    carry_slots(pairs, ordered.order, memory, bond, begin, end)
    barrier(gate)
    adopt_part(pairs, spheres.position, ordered, share, threads)
    if rank == 0:
        reorder(spheres.velocity, ordered.order)
        reorder(spheres.rim, ordered.order)
    if rank == threads - 1:
        _reorder_rest(spheres, plane, ordered.order)
    barrier(gate)
    if rank == 0:
        _share_out(pairs, sharing)
        set_stream(pairs, spheres.position[2], spheres.velocity[0])
        pairs.valid[0] = True
    barrier(gate)
    _mark_reached(pairs, sharing, rank)
    return OK


@inlined
def _reorder_rest(spheres, plane, order):
    """Sort all arrays but positions, velocities and rims, which are sorted elsewhere."""
    number = order.size
    reorder(spheres.orientation, order)
    reorder(spheres.radius.reshape(1, number), order)
    reorder(spheres.mass.reshape(1, number), order)
    reorder(spheres.inverse_mass.reshape(1, number), order)
    reorder(spheres.label, order)
    reorder(plane.slot, order)


@inlined
def _share_out(pairs, sharing):
    """Give each thread a range of first particles with the same number of pairs."""
    threads, particles = sharing.border.size - 1, pairs.start.size - 1
    for rank in range(1, threads):
        border = sharing.border[rank - 1]
        while pairs.start[border] * threads < pairs.start[particles] * rank:
            border += 1
        sharing.border[rank] = border


@inlined
def _mark_reached(pairs, sharing, rank):
    """Mark the groups of other threads' particles that the pairs of one thread reach."""
    _, begin, end = own_share(sharing, rank)
    for group in range(sharing.reached.shape[1]):
        sharing.reached[rank, group] = False
    for p in range(pairs.start[begin], pairs.start[end]):
        j = pairs.second[np.uint64(p)]
        if j >= end:
            sharing.reached[rank, j // GROUP] = True
