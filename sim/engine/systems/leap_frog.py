"""Leap-frog for spheres: velocities live half a step before the positions."""

from typing import NamedTuple

import numpy as np

from sim.engine.boundary.plane import plane_forces
from sim.engine.compile import inlined, kernel, vectorised, wide_vectors
from sim.engine.dynamics.cells import reorder
from sim.engine.dynamics.mean_flow import AGE, allowed_stray, set_stream
from sim.engine.dynamics.neighbors import adopt, carry_slots, draft, has_room, tidy
from sim.engine.dynamics.orientation import rotate
from sim.engine.dynamics.spheres import SOLID, pair_forces
from sim.engine.dynamics.status import LIST_FULL, OK, OVERLAP
from sim.engine.dynamics.team import barrier
from sim.engine.systems.sharing import GROUP, clear, collect_forces, mark_reached, share_out

# Columns of ``Flow.sums``: sums over the steps since they were last cleared.
STEPS, MOMENTUM, PLANE_X, PLANE_Z, CONTACTS, LARGEST, LOST, WORK = range(8)
SUMS = 8

# Columns of ``Flow.parts``: what each thread contributes to a step.
(
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    OUTSIDE,
    TOUCHING,
    DEEPEST,
    PUSHED_X,
    PUSHED_Z,
    HEATED,
    RUBBED,
    CARRIED,
) = range(11)
PARTS = 11

#: Particles that are taken together, so that they stay in the cache from one loop to the next.
STRIP = 2048


class Flow(NamedTuple):
    """What the loop over steps carries besides particles and contacts.

    ``step`` (1,) number of the last completed step; ``sums`` (8,) and ``parts`` (T, 11) see above;
    ``border`` (T + 1,) first particle of each thread; ``reached`` (T, N // 64 + 1) which groups of
    64 particles of other threads it adds forces to; ``status`` (1,) of the last refresh; ``fixed``
    (1,) whether some particles are fixed in space.
    """

    step: np.ndarray
    sums: np.ndarray
    parts: np.ndarray
    border: np.ndarray
    reached: np.ndarray
    status: np.ndarray
    fixed: np.ndarray


def make_flow(particles: int, threads: int = 1, fixed: bool = False) -> Flow:
    """Return the state before the first step."""
    return Flow(
        np.zeros(1, np.int64),
        np.zeros(SUMS),
        np.zeros((threads, PARTS)),
        np.linspace(0, particles, threads + 1).astype(np.int64),
        np.zeros((threads, particles // GROUP + 1), np.bool_),
        np.zeros(1, np.int64),
        np.full(1, fixed),
    )


@inlined
def move(spheres, pairs, allowed, gravity, time_step, share):
    """Advance velocities and positions of some particles by one step.

    Returns the sums of the velocities along x, y and z, the momentum along x, how many particles
    are farther than ``allowed`` (m) from where drift and mean flow would have carried them. Any
    common vector serves as the drift, so the mean velocity of the last step may be used to advance
    it.
    """
    vectorised()
    rank, begin, end = share
    x, v, w = spheres.position, spheres.velocity, spheres.rim
    force, moment, anchor = spheres.force, spheres.moment, pairs.anchor
    age = pairs.clock[AGE] * time_step
    limit = allowed * allowed
    sx, sy, sz, carried, outside = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(begin, end):
        i = np.uint64(k)
        rate = time_step * spheres.inverse_mass[i]
        spin_rate = rate / SOLID
        vx = v[0, i] + (force[rank, 0, i] * rate + gravity[0] * time_step)
        vy = v[1, i] + (force[rank, 1, i] * rate + gravity[1] * time_step)
        vz = v[2, i] + (force[rank, 2, i] * rate + gravity[2] * time_step)
        w[0, i] += moment[rank, 0, i] * spin_rate
        w[1, i] += moment[rank, 1, i] * spin_rate
        w[2, i] += moment[rank, 2, i] * spin_rate
        v[0, i], v[1, i], v[2, i] = vx, vy, vz
        px, py, pz = x[0, i] + vx * time_step, x[1, i] + vy * time_step, x[2, i] + vz * time_step
        x[0, i], x[1, i], x[2, i] = px, py, pz
        dx = px - anchor[0, i] - pairs.drift[0] - pairs.stream[i] * age
        dy = py - anchor[1, i] - pairs.drift[1]
        dz = pz - anchor[2, i] - pairs.drift[2]
        outside += 0.0 if dx * dx + dy * dy + dz * dz < limit else 1.0
        carried += spheres.mass[i] * vx
        sx += vx
        sy += vy
        sz += vz
    return (sx, sy, sz), carried, outside


@inlined
def hold(spheres, gravity, time_step, share):
    """Keep the fixed particles where they are through the next move.

    Returns the sums of the forces on them along x and z (N).
    """
    rank, begin, end = share
    along, upward = 0.0, 0.0
    for i in range(begin, end):
        if spheres.inverse_mass[i] == 0.0:
            along += spheres.force[rank, 0, i]
            upward += spheres.force[rank, 2, i]
            # What gravity adds to it makes zero, to the last bit.
            for d in range(3):
                spheres.velocity[d, i] = -(gravity[d] * time_step)
    return along, upward


@inlined
def refresh_flow(spheres, orientation, pairs, plane, memory, box, flow, rank, gate):
    """Rebuild the neighbor list, sort the particles by place and share them out anew.

    Done by all threads together; ``flow.status`` tells how it ended. Unless that is OK, the list
    and the particles are as they were, but for positions wrapped into the cell.
    """
    threads = flow.border.size - 1
    if rank == 0:
        flow.status[0] = tidy(pairs, spheres.position, box)
    barrier(gate)
    if flow.status[0] != OK:
        return
    order, place, size, (first, last) = draft(
        pairs, spheres.position, spheres.radius, box, rank, threads
    )
    barrier(gate)
    if not has_room(pairs, threads):
        if rank == 0:
            flow.status[0] = LIST_FULL
        barrier(gate)
        return
    begin, end = flow.border[rank], flow.border[rank + 1]
    carry_slots(pairs, order, memory, pairs.start[begin], pairs.start[end])
    barrier(gate)
    adopt(pairs, spheres.position, place, size, rank, threads, first, last)
    if rank == 0:
        reorder(spheres.velocity, order)
        reorder(spheres.rim, order)
    if rank == threads - 1:
        _reorder_rest(spheres, orientation, plane, order)
    barrier(gate)
    if rank == 0:
        share_out(pairs, flow)
        set_stream(pairs, spheres.position[2], spheres.velocity[0])
        pairs.valid[0] = True
    barrier(gate)
    mark_reached(pairs, flow, rank)


@inlined
def _reorder_rest(spheres, orientation, plane, order):
    """Sort by place what the search for pairs and the velocities do not include."""
    number = order.size
    reorder(orientation, order)
    reorder(spheres.radius.reshape(1, number), order)
    reorder(spheres.mass.reshape(1, number), order)
    reorder(spheres.inverse_mass.reshape(1, number), order)
    reorder(spheres.label, order)
    reorder(plane.slot, order)


@inlined
def _combine(spheres, pairs, flow, time_step, step):
    """Take stock of a step: sums of observables, the drift, and whether the list still holds."""
    sums, parts, number = flow.sums, flow.parts, spheres.radius.size
    outside = 0.0
    for rank in range(parts.shape[0]):
        sums[MOMENTUM] += parts[rank, CARRIED]
        sums[PLANE_X] += parts[rank, PUSHED_X]
        sums[PLANE_Z] += parts[rank, PUSHED_Z]
        sums[CONTACTS] += parts[rank, TOUCHING]
        sums[LARGEST] = max(sums[LARGEST], parts[rank, DEEPEST])
        sums[LOST] += parts[rank, HEATED]
        sums[WORK] += parts[rank, RUBBED]
        outside += parts[rank, OUTSIDE]
        for d in range(3):
            pairs.drift[d] += parts[rank, MOVED_X + d] * time_step / number
    sums[STEPS] += 1.0
    pairs.clock[AGE] += 1.0
    pairs.valid[0] = outside == 0.0
    flow.step[0] = step


@inlined
def _advance_strip(law, spheres, orientation, pairs, plane, flow, work, motion, step, strip, part):
    """Finish the forces on a strip of one thread's particles and move them; add to its ``part``.

    ``motion`` is (gravity, time step, allowed stray). Strips are short enough for their particles
    to stay in the cache from one loop over them to the next.
    """
    gravity, time_step, allowed = motion
    _, begin, end = strip
    before, after = plane.memory[(step + 1) % 2], plane.memory[step % 2]
    resting, overlap, along, upward, lost, work_done = plane_forces(
        law, spheres, plane.slot, before, after, work, time_step, strip
    )
    collect_forces(spheres, flow, strip)
    held_x, held_z = hold(spheres, gravity, time_step, strip) if flow.fixed[0] else (0.0, 0.0)
    moved, carried, outside = move(spheres, pairs, allowed, gravity, time_step, strip)
    rotate(orientation, spheres.rim, spheres.radius, time_step, begin, end)
    part[TOUCHING] += resting
    part[DEEPEST] = max(part[DEEPEST], overlap)
    part[PUSHED_X] += along - held_x
    part[PUSHED_Z] += upward - held_z
    part[HEATED] += lost
    part[RUBBED] += work_done
    part[CARRIED] += carried
    part[MOVED_X] += moved[0]
    part[MOVED_Y] += moved[1]
    part[MOVED_Z] += moved[2]
    part[OUTSIDE] += outside


@kernel
def advance(
    laws,
    spheres,
    orientation,
    pairs,
    plane,
    memory,
    box,
    work,
    flow,
    gravity,
    time_step,
    overlap_limit,
    steps,
    rank,
    gate,
):
    """Advance the flow by a number of steps; return a status.

    ``laws`` holds the law between spheres and that between a sphere and the plane; ``gravity`` is a
    tuple of three accelerations (m/s²); ``orientation`` may be empty. Every thread of the team that
    shares ``gate`` calls this with its ``rank`` and its ``work``; where one of them never comes,
    nothing happens. On LIST_FULL nothing is lost:
    give the pair list more room and call again for the steps that ``flow.step`` says are missing.
    """
    wide_vectors()
    step, valid = flow.step[0], pairs.valid[0]
    last = step + steps
    part = np.zeros(PARTS)
    if barrier(gate):
        return OK
    while step < last:
        if not valid:
            last_memory = memory[step % 2]
            refresh_flow(spheres, orientation, pairs, plane, last_memory, box, flow, rank, gate)
            if flow.status[0] != OK:
                return flow.status[0]
        step += 1
        begin, end = flow.border[rank], flow.border[rank + 1]
        share = (rank, begin, end)
        clear(spheres, flow, share)
        for column in range(PARTS):
            part[column] = 0.0
        before, after = memory[(step + 1) % 2], memory[step % 2]
        for start in range(begin, end, STRIP):
            strip = (rank, start, min(start + STRIP, end))
            touching, overlap, lost, work_done = pair_forces(
                laws[0], spheres, pairs, before, after, box, work, time_step, strip
            )
            part[TOUCHING] += 2.0 * touching
            part[DEEPEST] = max(part[DEEPEST], overlap)
            part[HEATED] += lost
            part[RUBBED] += work_done
        barrier(gate)
        motion = (gravity, time_step, allowed_stray(pairs, time_step))
        for start in range(begin, end, STRIP):
            strip = (rank, start, min(start + STRIP, end))
            _advance_strip(
                laws[1], spheres, orientation, pairs, plane, flow, work, motion, step, strip, part
            )
        for column in range(PARTS):
            flow.parts[rank, column] = part[column]
        barrier(gate)
        outside, largest = 0.0, 0.0
        for other in range(flow.parts.shape[0]):
            outside += flow.parts[other, OUTSIDE]
            largest = max(largest, flow.parts[other, DEEPEST])
        valid = outside == 0.0
        if rank == 0:
            _combine(spheres, pairs, flow, time_step, step)
        if not largest < overlap_limit:
            return OVERLAP
    return OK
