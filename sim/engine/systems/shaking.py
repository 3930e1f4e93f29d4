"""The loop over time steps of the disks on the belt."""

from typing import NamedTuple

import numpy as np

from sim.engine.boundary.belt import Belt, Obstacle, belt_forces, obstacle_forces
from sim.engine.compile import (
    assume_no_alias,
    call,
    inlined,
    kernel,
    loop_kernel,
    prefer_wide_vectors,
)
from sim.engine.dynamics.cells import OK, OVERLAP, reorder
from sim.engine.dynamics.disks import TERMS, correct, disk_forces, flush, predict
from sim.engine.dynamics.mean_flow import allowed_stray
from sim.engine.dynamics.neighbors import PairList, Search, refresh

# Columns of ``Shaking.sums``: sums over the steps since they were last cleared, but for the largest
# overlap.
STEPS, MOMENTUM, CONTACTS, LARGEST, NORMAL_LOSS, SHEAR_LOSS, BELT_WORK, VELOCITY = range(8)
BELT_PUSH_X, BELT_PUSH_Z, BELT_CONTACTS, BELT_TOUCH_STEPS = range(8, 12)
SUMS = 12

#: Steps between two searches for vanishing Taylor terms.
FLUSH_INTERVAL = 32


class BedContacts(NamedTuple):
    """Contact partners of the beads, their ``law``, and scratch of the ``search`` for contacts."""

    law: NamedTuple
    pairs: PairList
    belt: Belt
    obstacle: Obstacle
    search: Search


class BedMotion(NamedTuple):
    """The ``integrator``, ``gravity`` (m/s²) along -z, the largest overlap allowed relative to the
    sum of the radii, the number of ``corrections`` in a step, the address of ``refresh_beads``."""

    integrator: NamedTuple
    gravity: float
    overlap_limit: float
    corrections: int
    refresh: int


class Shaking(NamedTuple):
    """State of the loop over steps besides beads and neighbor list.

    ``step`` (1,) number of the last completed step; ``evaluation`` (1,) number of the next
    evaluation of the forces within the next step, 0 before its prediction; ``sums`` (12,) see
    above.
    """

    step: np.ndarray
    evaluation: np.ndarray
    sums: np.ndarray


def make_shaking() -> Shaking:
    """Return the state before the first step."""
    return Shaking(np.zeros(1, np.int64), np.zeros(1, np.int64), np.zeros(SUMS))


@inlined
def is_list_valid(disks, pairs, time_step):
    """True where no bead has strayed too far from the mean displacement of all."""
    assume_no_alias()
    largest_stray = allowed_stray(pairs, time_step)
    limit = largest_stray * largest_stray
    outside, x, z = 0.0, 0.0, 0.0
    number = disks.radius.size
    for i in range(number):
        dx = disks.taylor[0, 0, i] - pairs.anchor[0, i]
        dz = disks.taylor[0, 1, i] - pairs.anchor[1, i]
        stray_squared = (dx - pairs.drift[0]) ** 2 + (dz - pairs.drift[1]) ** 2
        outside += 0.0 if stray_squared < limit else 1.0
        x += dx
        z += dz
    # Any common vector serves as the drift: the next step uses this step's mean displacement.
    pairs.drift[0] = x / number
    pairs.drift[1] = z / number
    return outside == 0.0


@kernel
def refresh_beads(disks, pairs):
    """Rebuild the neighbor list and sort the beads by position; return a status."""
    prefer_wide_vectors()
    no_memory = np.empty((0, 0))
    status, order = refresh(pairs, disks.taylor[0], disks.radius, no_memory)
    if status == OK:
        for k in range(1, TERMS):
            reorder(disks.taylor[k], order)
        reorder(disks.radius.reshape(1, order.size), order)
        reorder(disks.mass.reshape(1, order.size), order)
        reorder(disks.label, order)
    return status


@inlined
def _clear_forces(disks):
    for d in range(2):
        for i in range(disks.radius.size):
            disks.force[d, i] = 0.0


@inlined
def move_disks(integrator, disks, gravity):
    """Correct all coordinates; return the sums of velocity times Δt and of momentum times Δt."""
    assume_no_alias()
    displacement, momentum = 0.0, 0.0
    for i in range(disks.radius.size):
        rate = 1.0 / disks.mass[i]
        correct(integrator, disks.taylor, 0, i, disks.force[0, i] * rate)
        correct(integrator, disks.taylor, 1, i, disks.force[1, i] * rate - gravity)
    for i in range(disks.radius.size):
        displacement += disks.taylor[1, 0, i]
        momentum += disks.mass[i] * disks.taylor[1, 0, i]
    return displacement, momentum


@loop_kernel
def advance_disks(disks, contacts, shaking, motion, steps):
    """Advance the beads by a number of steps; return a status.

    Losses are those of a step's last evaluation of the forces. On LIST_FULL nothing is lost: the
    positions are already those predicted for the next step, or corrected once, so give the pair
    list more room and call again for the missing steps, see ``shaking.step``.
    """
    prefer_wide_vectors()
    law, pairs, belt, obstacle, search = contacts
    integrator, gravity, overlap_limit, corrections, refresh = motion
    sums = shaking.sums
    last = shaking.step[0] + steps
    time_step = integrator.time_step
    while shaking.step[0] < last:
        step = shaking.step[0] + 1
        if shaking.evaluation[0] == 0:
            predict(integrator, disks.taylor)
            shaking.evaluation[0] = 1
        pairs.valid[0] = pairs.valid[0] and is_list_valid(disks, pairs, time_step)
        if not pairs.valid[0]:
            status = call(refresh, 0, disks, pairs)
            if status != OK:
                return status
        _clear_forces(disks)
        touching, overlap, pair_normal_power, pair_shear_power = disk_forces(
            law, disks, pairs, search, time_step
        )
        belt_contacts, belt_overlap, belt_normal_power, belt_shear_power, belt_power, belt_force = (
            belt_forces(law, disks, belt, search, step * time_step, time_step)
        )
        obstacle_contacts, obstacle_overlap, obstacle_normal_power, obstacle_shear_power = (
            obstacle_forces(law, disks, obstacle, pairs.box, search, time_step)
        )
        displacement, momentum = move_disks(integrator, disks, gravity)
        if shaking.evaluation[0] < corrections:
            shaking.evaluation[0] += 1
            continue
        overlap = max(overlap, belt_overlap, obstacle_overlap)
        sums[STEPS] += 1.0
        sums[VELOCITY] += displacement / (time_step * disks.radius.size)
        sums[MOMENTUM] += momentum / time_step
        sums[CONTACTS] += 2.0 * touching + belt_contacts + obstacle_contacts
        sums[LARGEST] = max(sums[LARGEST], overlap)
        sums[NORMAL_LOSS] += (
            pair_normal_power + belt_normal_power + obstacle_normal_power
        ) * time_step
        sums[SHEAR_LOSS] += (pair_shear_power + belt_shear_power + obstacle_shear_power) * time_step
        sums[BELT_WORK] += belt_power * time_step
        sums[BELT_PUSH_X] += belt_force[0]
        sums[BELT_PUSH_Z] += belt_force[1]
        sums[BELT_CONTACTS] += belt_contacts
        sums[BELT_TOUCH_STEPS] += 1.0 if belt_contacts > 0 else 0.0
        if step % FLUSH_INTERVAL == 0:
            flush(disks.taylor)
        shaking.step[0] = step
        shaking.evaluation[0] = 0
        if not overlap < overlap_limit:
            return OVERLAP
    return OK
