"""Leap-frog for spheres: velocities live half a step before the positions.

With the forces F and moments M of the contacts at positions x(t), a step is (Walton, Mech. Mater.
16 (1993) 239, after Allen and Tildesley, Computer Simulation of Liquids, 1987)

    v(t + Δt/2) = v(t - Δt/2) + (F/m + g) Δt
    ω(t + Δt/2) = ω(t - Δt/2) + M Δt/I
    x(t + Δt) = x(t) + v(t + Δt/2) Δt
"""

from typing import NamedTuple

import numpy as np

from sim.engine.boundary.drive import acceleration, note_work
from sim.engine.boundary.plane import Plane, plane_forces
from sim.engine.compile import assume_no_alias, call, inlined, loop_kernel, prefer_wide_vectors
from sim.engine.dynamics.cells import OK, OVERLAP
from sim.engine.dynamics.mean_flow import AGE, allowed_stray
from sim.engine.dynamics.neighbors import Bond, PairList
from sim.engine.dynamics.spheres import Contacts, rotate, sphere_forces
from sim.engine.dynamics.team import Share, barrier
from sim.engine.systems.sharing import (
    Sharing,
    clear_forces,
    collect_forces,
    make_sharing,
    own_share,
)

# Columns of ``Flow.sums``: sums over the steps since they were last cleared, but for the largest
# overlap.
STEPS, MOMENTUM, CONTACTS, LARGEST, NORMAL_LOSS, FRICTION_WORK, PLANE_X, PLANE_Z = range(8)
SUMS = 8

# ``Sharing.parts`` has the same columns, followed by the sums of the velocities along x, y and z
# and the number of particles that have strayed too far.
VELOCITY_SUMS, STRAYED, PARTS = 8, 11, 12

#: Number of particles in a strip: few enough to stay in the cache from one loop to the next.
STRIP = 2048


class FlowContacts(NamedTuple):
    """Contact partners of the spheres, and the memory of their contacts.

    ``laws`` between two spheres and between a sphere and the plane; ``memory`` (2, M, C) of pairs,
    and the ``bond`` of their law.
    """

    laws: tuple[NamedTuple, NamedTuple]
    pairs: PairList
    plane: Plane
    memory: np.ndarray
    bond: Bond


class Motion(NamedTuple):
    """``drive``, ``time_step`` (s), the largest overlap allowed relative to the sum of the radii,
    the ``inertia``, moment of inertia over m r², infinite without rotation, and the address of
    ``refresh_together``."""

    drive: NamedTuple
    time_step: float
    overlap_limit: float
    inertia: float
    refresh: int


class Flow(NamedTuple):
    """State of the loop over steps besides particles and contacts.

    ``step`` (1,) number of the last completed step; ``sums`` (8,) see above; ``fixed`` (1,) True if
    some particles are fixed in space; ``sharing`` between threads.
    """

    step: np.ndarray
    sums: np.ndarray
    fixed: np.ndarray
    sharing: Sharing


def make_flow(particles: int, threads: int = 1, fixed: bool = False) -> Flow:
    """Return the state before the first step."""
    return Flow(
        np.zeros(1, np.int64),
        np.zeros(SUMS),
        np.full(1, fixed),
        make_sharing(particles, threads, PARTS),
    )


@inlined
def move_spheres(spheres, pairs, motion, gravity, allowed, share):
    """Advance velocities and positions of some particles by one step.

    ``gravity`` (m/s²) is that of the drive in this step. Returns the sums of the velocities along
    x, y and z, the momentum along x, and the number of particles farther than ``allowed`` (m) from
    their positions under drift and mean flow. Any common vector serves as the drift, so the mean
    velocity of the last step may advance it.
    """
    assume_no_alias()
    rank, begin, end = share
    time_step, inertia = motion.time_step, motion.inertia
    x, v, w = spheres.position, spheres.velocity, spheres.rim
    force, moment, anchor = spheres.force, spheres.moment, pairs.anchor
    age = pairs.clock[AGE] * time_step
    limit = allowed * allowed
    sx, sy, sz, momentum, strayed = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(begin, end):
        i = np.uint64(k)
        rate = time_step * spheres.inverse_mass[i]
        spin_rate = rate / inertia
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
        strayed += 0.0 if dx * dx + dy * dy + dz * dz < limit else 1.0
        momentum += spheres.mass[i] * vx
        sx += vx
        sy += vy
        sz += vz
    return (sx, sy, sz), momentum, strayed


@inlined
def hold_fixed(spheres, gravity, time_step, share):
    """Set the velocities of fixed particles so that the next move leaves them in place.

    Returns the sums of the forces on them along x and z (N).
    """
    rank, begin, end = share
    along, upward = 0.0, 0.0
    for i in range(begin, end):
        if spheres.inverse_mass[i] == 0.0:
            along += spheres.force[rank, 0, i]
            upward += spheres.force[rank, 2, i]
            # Gravity cancels this velocity in the next move, to the last bit.
            for d in range(3):
                spheres.velocity[d, i] = -(gravity[d] * time_step)
    return along, upward


@inlined
def _add_to_part(part, touching, overlap, loss, work):
    """Add the contacts of a strip to a thread's part of the sums."""
    part[CONTACTS] += touching
    part[LARGEST] = max(part[LARGEST], overlap)
    part[NORMAL_LOSS] += loss
    part[FRICTION_WORK] += work


@inlined
def _add_pair_forces(spheres, contacts, flow, motion, thread, step):
    """Begin a thread's part of a step: forces of the pairs whose first partner is in its share."""
    share, part = own_share(flow.sharing, thread.rank), flow.sharing.parts[step % 2, thread.rank]
    for column in range(PARTS):
        part[column] = 0.0
    clear_forces(spheres, flow.sharing, share)
    before, after = contacts.memory[(step + 1) % 2], contacts.memory[step % 2]
    pair_contacts = Contacts(contacts.laws[0], contacts.pairs, before, after, contacts.bond.reach)
    for start in range(share.begin, share.end, STRIP):
        strip = Share(share.rank, start, min(start + STRIP, share.end))
        touching, overlap, loss, work = sphere_forces(
            spheres, pair_contacts, thread.scratch, motion.time_step, strip
        )
        _add_to_part(part, 2.0 * touching, overlap, loss, work)


@inlined
def _finish_forces_and_move(spheres, contacts, flow, motion, thread, step):
    """Finish the forces on a thread's spheres and move them.

    Strips are short enough for their particles to stay in the cache from one loop over them to the
    next.
    """
    share, part = own_share(flow.sharing, thread.rank), flow.sharing.parts[step % 2, thread.rank]
    plane, time_step = contacts.plane, motion.time_step
    before, after = plane.memory[(step + 1) % 2], plane.memory[step % 2]
    plane_contacts = Contacts(contacts.laws[1], plane.slot, before, after, contacts.bond.reach)
    allowed = allowed_stray(contacts.pairs, time_step)
    gravity = acceleration(motion.drive, step, time_step)
    for start in range(share.begin, share.end, STRIP):
        strip = Share(share.rank, start, min(start + STRIP, share.end))
        touching, overlap, loss, work, along, upward = plane_forces(
            spheres, plane_contacts, thread.scratch, time_step, strip
        )
        collect_forces(spheres, flow.sharing, strip)
        fixed_x, fixed_z = (
            hold_fixed(spheres, gravity, time_step, strip) if flow.fixed[0] else (0.0, 0.0)
        )
        velocity_sums, momentum, strayed = move_spheres(
            spheres, contacts.pairs, motion, gravity, allowed, strip
        )
        rotate(spheres.orientation, spheres.rim, spheres.radius, time_step, strip.begin, strip.end)
        _add_to_part(part, touching, overlap, loss, work)
        part[MOMENTUM] += momentum
        part[PLANE_X] += along - fixed_x
        part[PLANE_Z] += upward - fixed_z
        part[STRAYED] += strayed
        for d in range(3):
            part[VELOCITY_SUMS + d] += velocity_sums[d]


@inlined
def _add_up_parts(pairs, flow, motion, step):
    """Add up the parts of a step: sums of observables, drift, validity of the neighbor list."""
    sums, parts, number = flow.sums, flow.sharing.parts[step % 2], pairs.stream.size
    time_step, strayed, along, upward = motion.time_step, 0.0, 0.0, 0.0
    for rank in range(parts.shape[0]):
        sums[MOMENTUM] += parts[rank, MOMENTUM]
        sums[CONTACTS] += parts[rank, CONTACTS]
        sums[LARGEST] = max(sums[LARGEST], parts[rank, LARGEST])
        sums[NORMAL_LOSS] += parts[rank, NORMAL_LOSS]
        sums[FRICTION_WORK] += parts[rank, FRICTION_WORK]
        sums[PLANE_X] += parts[rank, PLANE_X]
        sums[PLANE_Z] += parts[rank, PLANE_Z]
        along += parts[rank, PLANE_X]
        upward += parts[rank, PLANE_Z]
        strayed += parts[rank, STRAYED]
        for d in range(3):
            pairs.drift[d] += parts[rank, VELOCITY_SUMS + d] * time_step / number
    note_work(motion.drive, step, time_step, along, upward)
    sums[STEPS] += 1.0
    pairs.clock[AGE] += 1.0
    pairs.valid[0] = strayed == 0.0
    flow.step[0] = step


@loop_kernel
def advance_spheres(spheres, contacts, flow, motion, thread, steps):
    """Advance the flow by a number of steps; return a status.

    Every thread of the team that shares a gate calls this; if one of them fails before the gate,
    nothing happens. On LIST_FULL nothing is lost: give the pair list more room and call again for
    the missing steps, see ``flow.step``.
    """
    prefer_wide_vectors()
    step, valid = flow.step[0], contacts.pairs.valid[0]
    last = step + steps
    if barrier(thread.gate):
        return OK
    while step < last:
        if not valid:
            pairs, plane, memory = contacts.pairs, contacts.plane, contacts.memory[step % 2]
            arguments = spheres, pairs, plane, flow.sharing, thread, memory, contacts.bond
            status = call(motion.refresh, 0, *arguments)
            if status != OK:
                return status
        step += 1
        _add_pair_forces(spheres, contacts, flow, motion, thread, step)
        barrier(thread.gate)
        _finish_forces_and_move(spheres, contacts, flow, motion, thread, step)
        barrier(thread.gate)
        parts = flow.sharing.parts[step % 2]
        strayed, largest = 0.0, 0.0
        for rank in range(parts.shape[0]):
            strayed += parts[rank, STRAYED]
            largest = max(largest, parts[rank, LARGEST])
        valid = strayed == 0.0
        if thread.rank == 0:
            _add_up_parts(contacts.pairs, flow, motion, step)
        if not largest < motion.overlap_limit:
            return OVERLAP
    return OK
