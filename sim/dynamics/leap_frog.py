"""Leap-frog for spheres: velocities live half a step before the positions."""

from typing import NamedTuple

import numpy as np

from sim.boundary.plane import plane_forces
from sim.compile import inlined, kernel
from sim.dynamics.neighbors import refresh
from sim.dynamics.orientation import rotate
from sim.dynamics.spheres import pair_forces
from sim.dynamics.status import OK, OVERLAP

# Columns of ``Flow.sums``: sums over the steps since they were last cleared.
STEPS, VELOCITY, PLANE_X, PLANE_Z, CONTACTS, LARGEST = range(6)
SUMS = 6


class Flow(NamedTuple):
    """What the loop over steps carries besides particles and contacts.

    ``step`` (1,) number of the last completed step; ``drift`` (3,) mean displacement since the
    neighbor list was built (m); ``valid`` (1,) whether the list is; ``sums`` (6,) see above.
    """

    step: np.ndarray
    drift: np.ndarray
    valid: np.ndarray
    sums: np.ndarray


def make_flow() -> Flow:
    """Return the state before the first step."""
    return Flow(np.zeros(1, np.int64), np.zeros(3), np.zeros(1, np.bool_), np.zeros(SUMS))


@inlined
def _move(spheres, pairs, flow, gravity, time_step):
    """Advance velocities and positions by one step; return the sum of the velocities along x.

    The list stays valid while no particle has moved by half the skin relative to the drift. Any
    common vector serves as the drift, so last step's mean velocity may be used to advance it.
    """
    limit = (0.5 * pairs.skin) ** 2
    inside = True
    tx, ty, tz = 0.0, 0.0, 0.0
    number = spheres.radius.size
    for i in range(number):
        rate = time_step / spheres.mass[i]
        spin_rate = time_step / spheres.inertia[i]
        square = 0.0
        for d in range(3):
            spheres.velocity[i, d] += spheres.force[i, d] * rate + gravity[d] * time_step
            spheres.spin[i, d] += spheres.torque[i, d] * spin_rate
            spheres.position[i, d] += spheres.velocity[i, d] * time_step
            moved = spheres.position[i, d] - pairs.anchor[i, d] - flow.drift[d]
            square += moved * moved
        tx += spheres.velocity[i, 0]
        ty += spheres.velocity[i, 1]
        tz += spheres.velocity[i, 2]
        inside &= square < limit
    flow.drift[0] += tx * time_step / number
    flow.drift[1] += ty * time_step / number
    flow.drift[2] += tz * time_step / number
    flow.valid[0] = inside
    return tx


@kernel
def advance(
    laws,
    spheres,
    orientation,
    pairs,
    plane,
    box,
    work,
    flow,
    gravity,
    time_step,
    overlap_limit,
    steps,
):
    """Advance the flow by a number of steps; return a status.

    ``laws`` holds the law between spheres and that between a sphere and the plane; ``gravity`` is a
    tuple of three accelerations (m/s²); ``orientation`` may be empty. On LIST_FULL nothing is lost:
    give the pair list more room and call again for the steps that ``flow.step`` says are missing.
    """
    law, plane_law = laws
    sums = flow.sums
    last = flow.step[0] + steps
    while flow.step[0] < last:
        if not flow.valid[0]:
            status = refresh(pairs, spheres.position, spheres.radius, box, flow)
            if status != OK:
                return status
        step = flow.step[0] + 1
        spheres.force[:] = 0.0
        spheres.torque[:] = 0.0
        touching, overlap = pair_forces(law, spheres, pairs, box, work, time_step, step)
        resting, plane_overlap, along, upward = plane_forces(
            plane_law, spheres, plane, work, time_step, step
        )
        sums[STEPS] += 1.0
        sums[VELOCITY] += _move(spheres, pairs, flow, gravity, time_step) / spheres.radius.size
        sums[PLANE_X] += along
        sums[PLANE_Z] += upward
        sums[CONTACTS] += 2.0 * touching + resting
        sums[LARGEST] = max(sums[LARGEST], overlap, plane_overlap)
        rotate(orientation, spheres.spin, time_step)
        flow.step[0] = step
        if not max(overlap, plane_overlap) < overlap_limit:
            return OVERLAP
    return OK
