"""Leap-frog for spheres: velocities live half a step before the positions."""

from typing import NamedTuple

import numpy as np

from sim.boundary.plane import plane_forces
from sim.compile import inlined, kernel, vectorised, wide_vectors
from sim.dynamics.cells import reorder
from sim.dynamics.mean_flow import AGE, allowed_stray, set_stream
from sim.dynamics.neighbors import refresh
from sim.dynamics.orientation import rotate
from sim.dynamics.spheres import SOLID, pair_forces
from sim.dynamics.status import OK, OVERLAP
from sim.dynamics.team import barrier

# Columns of ``Flow.sums``: sums over the steps since they were last cleared.
STEPS, VELOCITY, PLANE_X, PLANE_Z, CONTACTS, LARGEST = range(6)
SUMS = 6

# Columns of ``Flow.parts``: what each thread contributes to a step.
MOVED_X, MOVED_Y, MOVED_Z, OUTSIDE, TOUCHING, DEEPEST, PUSHED_X, PUSHED_Z = range(8)
PARTS = 8


class Flow(NamedTuple):
    """What the loop over steps carries besides particles and contacts.

    ``step`` (1,) number of the last completed step; ``sums`` (6,) and ``parts`` (T, 8) see above;
    ``border`` (T + 1,) first particle of each thread; ``status`` (1,) of the last refresh.
    """

    step: np.ndarray
    sums: np.ndarray
    parts: np.ndarray
    border: np.ndarray
    status: np.ndarray


def make_flow(particles: int, threads: int = 1) -> Flow:
    """Return the state before the first step."""
    return Flow(
        np.zeros(1, np.int64),
        np.zeros(SUMS),
        np.zeros((threads, PARTS)),
        np.linspace(0, particles, threads + 1).astype(np.int64),
        np.zeros(1, np.int64),
    )


@inlined
def clear(spheres, rank):
    """Set the forces and moments of one thread to zero."""
    vectorised()
    for d in range(3):
        for i in range(spheres.radius.size):
            spheres.force[rank, d, i] = 0.0
            spheres.moment[rank, d, i] = 0.0


@inlined
def _collect_forces(spheres, begin, end):
    """Add the forces and moments of all threads to those of the first."""
    vectorised()
    for rank in range(1, spheres.force.shape[0]):
        for d in range(3):
            for k in range(begin, end):
                i = np.uint64(k)
                spheres.force[0, d, i] += spheres.force[rank, d, i]
                spheres.moment[0, d, i] += spheres.moment[rank, d, i]


@inlined
def move(spheres, pairs, allowed, gravity, time_step, begin, end):
    """Advance velocities and positions of some particles by one step.

    Returns the sums of the velocities along x, y and z, and how many particles are farther than
    ``allowed`` (m) from where drift and mean flow would have carried them. Any common vector serves
    as the drift, so the mean velocity of the last step may be used to advance it.
    """
    vectorised()
    x, v, w = spheres.position, spheres.velocity, spheres.rim
    force, moment, anchor = spheres.force, spheres.moment, pairs.anchor
    age = pairs.clock[AGE] * time_step
    limit = allowed * allowed
    sx, sy, sz, outside = 0.0, 0.0, 0.0, 0.0
    for k in range(begin, end):
        i = np.uint64(k)
        rate = time_step * spheres.inverse_mass[i]
        spin_rate = rate / SOLID
        vx = v[0, i] + (force[0, 0, i] * rate + gravity[0] * time_step)
        vy = v[1, i] + (force[0, 1, i] * rate + gravity[1] * time_step)
        vz = v[2, i] + (force[0, 2, i] * rate + gravity[2] * time_step)
        w[0, i] += moment[0, 0, i] * spin_rate
        w[1, i] += moment[0, 1, i] * spin_rate
        w[2, i] += moment[0, 2, i] * spin_rate
        v[0, i], v[1, i], v[2, i] = vx, vy, vz
        px, py, pz = x[0, i] + vx * time_step, x[1, i] + vy * time_step, x[2, i] + vz * time_step
        x[0, i], x[1, i], x[2, i] = px, py, pz
        dx = px - anchor[0, i] - pairs.drift[0] - pairs.stream[i] * age
        dy = py - anchor[1, i] - pairs.drift[1]
        dz = pz - anchor[2, i] - pairs.drift[2]
        outside += 0.0 if dx * dx + dy * dy + dz * dz < limit else 1.0
        sx += vx
        sy += vy
        sz += vz
    return sx, sy, sz, outside


@inlined
def refresh_flow(spheres, orientation, pairs, plane, memory, box, flow):
    """Rebuild the neighbor list, sort the particles by place and share them out anew."""
    status, order = refresh(pairs, spheres.position, spheres.radius, box, memory)
    flow.status[0] = status
    if status != OK:
        return
    number = order.size
    reorder(spheres.velocity, order)
    reorder(spheres.rim, order)
    reorder(orientation, order)
    reorder(spheres.radius.reshape(1, number), order)
    reorder(spheres.mass.reshape(1, number), order)
    reorder(spheres.inverse_mass.reshape(1, number), order)
    reorder(spheres.label, order)
    reorder(plane.slot, order)
    set_stream(pairs, spheres.position[2], spheres.velocity[0])
    threads = flow.border.size - 1
    for rank in range(1, threads):
        share = pairs.start[number] * rank // threads
        border = flow.border[rank - 1]
        while pairs.start[border] < share:
            border += 1
        flow.border[rank] = border


@inlined
def _combine(spheres, pairs, flow, time_step, step):
    """Take stock of a step: sums of observables, the drift, and whether the list still holds."""
    sums, parts, number = flow.sums, flow.parts, spheres.radius.size
    outside = 0.0
    for rank in range(parts.shape[0]):
        sums[VELOCITY] += parts[rank, MOVED_X] / number
        sums[PLANE_X] += parts[rank, PUSHED_X]
        sums[PLANE_Z] += parts[rank, PUSHED_Z]
        sums[CONTACTS] += parts[rank, TOUCHING]
        sums[LARGEST] = max(sums[LARGEST], parts[rank, DEEPEST])
        outside += parts[rank, OUTSIDE]
        for d in range(3):
            pairs.drift[d] += parts[rank, MOVED_X + d] * time_step / number
    sums[STEPS] += 1.0
    pairs.clock[AGE] += 1.0
    pairs.valid[0] = outside == 0.0
    flow.step[0] = step


@inlined
def _forces(laws, spheres, pairs, plane, memory, box, work, time_step, share, part, step):
    """Evaluate the forces of one thread's share of contacts."""
    law, plane_law = laws
    now, last = step % 2, (step + 1) % 2
    touching, overlap = pair_forces(
        law, spheres, pairs, memory[last], memory[now], box, work, time_step, share
    )
    resting, plane_overlap, along, upward = plane_forces(
        plane_law,
        spheres,
        plane.slot,
        plane.memory[last],
        plane.memory[now],
        work,
        time_step,
        share,
    )
    part[TOUCHING] = 2.0 * touching + resting
    part[DEEPEST] = max(overlap, plane_overlap)
    part[PUSHED_X], part[PUSHED_Z] = along, upward


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
    shares ``gate`` calls this with its ``rank`` and its ``work``. On LIST_FULL nothing is lost:
    give the pair list more room and call again for the steps that ``flow.step`` says are missing.
    """
    wide_vectors()
    step, valid = flow.step[0], pairs.valid[0]
    last = step + steps
    part = np.zeros(PARTS)
    barrier(gate)
    while step < last:
        if not valid:
            if rank == 0:
                refresh_flow(spheres, orientation, pairs, plane, memory[step % 2], box, flow)
            barrier(gate)
            if flow.status[0] != OK:
                return flow.status[0]
        step += 1
        begin, end = flow.border[rank], flow.border[rank + 1]
        share = (rank, begin, end)
        clear(spheres, rank)
        _forces(laws, spheres, pairs, plane, memory, box, work, time_step, share, part, step)
        barrier(gate)
        _collect_forces(spheres, begin, end)
        allowed = allowed_stray(pairs, time_step)
        moved = move(spheres, pairs, allowed, gravity, time_step, begin, end)
        part[MOVED_X], part[MOVED_Y], part[MOVED_Z], part[OUTSIDE] = moved
        rotate(orientation, spheres.rim, spheres.radius, time_step, begin, end)
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
