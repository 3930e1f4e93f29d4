"""The loop over time steps of the disks on the belt."""

from typing import NamedTuple

import numpy as np

from sim.boundary.belt import belt_forces
from sim.boundary.obstacle import obstacle_forces
from sim.compile import inlined, kernel
from sim.dynamics.disks import pair_forces
from sim.dynamics.gear import correct, flush, predict
from sim.dynamics.neighbors import refresh
from sim.dynamics.status import OK, OVERLAP

# Columns of ``Shaking.sums``: sums over the steps since they were last cleared.
STEPS, VELOCITY, MOMENTUM, CONTACTS, LARGEST = range(5)
SUMS = 5

#: Steps between two searches for vanishing Taylor terms.
FLUSH_INTERVAL = 32


class Shaking(NamedTuple):
    """What the loop over steps carries besides beads and neighbor list.

    ``step`` (1,) number of the last completed step; ``drift`` (2,) mean displacement since the list
    was built (m); ``valid`` (1,) whether the list is; ``predicted`` (1,) whether the positions are
    those predicted for the next step; ``sums`` (5,) see above.
    """

    step: np.ndarray
    drift: np.ndarray
    valid: np.ndarray
    predicted: np.ndarray
    sums: np.ndarray


def make_shaking() -> Shaking:
    """Return the state before the first step."""
    flags = [np.zeros(1, np.bool_) for _ in range(2)]
    return Shaking(np.zeros(1, np.int64), np.zeros(2), *flags, np.zeros(SUMS))


@inlined
def _list_holds(disks, pairs, shaking):
    """Return whether no bead has moved by half the skin relative to the drift of all."""
    limit = (0.5 * pairs.skin) ** 2
    inside = True
    x, z = 0.0, 0.0
    number = disks.radius.size
    for i in range(number):
        dx = disks.taylor[0, i, 0] - pairs.anchor[i, 0]
        dz = disks.taylor[0, i, 1] - pairs.anchor[i, 1]
        inside &= (dx - shaking.drift[0]) ** 2 + (dz - shaking.drift[1]) ** 2 < limit
        x += dx
        z += dz
    # Any common vector serves as the drift: the next step uses this step's mean displacement.
    shaking.drift[0] = x / number
    shaking.drift[1] = z / number
    return inside


@kernel
def advance(
    law, integrator, disks, pairs, belt, obstacle, box, shaking, gravity, overlap_limit, steps
):
    """Advance the beads by a number of steps; return a status.

    ``gravity`` (m/s²) acts along -z. On LIST_FULL nothing is lost: the positions are already those
    predicted for the next step, so give the pair list more room and call again for the steps that
    ``shaking.step`` says are missing.
    """
    sums = shaking.sums
    last = shaking.step[0] + steps
    time_step = integrator.time_step
    while shaking.step[0] < last:
        step = shaking.step[0] + 1
        if not shaking.predicted[0]:
            predict(integrator, disks.taylor)
            shaking.predicted[0] = True
            shaking.valid[0] = shaking.valid[0] and _list_holds(disks, pairs, shaking)
        if not shaking.valid[0]:
            status = refresh(pairs, disks.taylor[0], disks.radius, box, shaking)
            if status != OK:
                return status
        disks.force[:] = 0.0
        touching, overlap = pair_forces(law, disks, pairs, box, time_step)
        resting, belt_overlap = belt_forces(law, disks, belt, step * time_step, time_step)
        blocked, obstacle_overlap = obstacle_forces(law, disks, obstacle, box, time_step)
        moved, momentum = 0.0, 0.0
        for i in range(disks.radius.size):
            rate = 1.0 / disks.mass[i]
            correct(integrator, disks.taylor, i, 0, disks.force[i, 0] * rate)
            correct(integrator, disks.taylor, i, 1, disks.force[i, 1] * rate - gravity)
            moved += disks.taylor[1, i, 0]
            momentum += disks.mass[i] * disks.taylor[1, i, 0]
        overlap = max(overlap, belt_overlap, obstacle_overlap)
        sums[STEPS] += 1.0
        sums[VELOCITY] += moved / (time_step * disks.radius.size)
        sums[MOMENTUM] += momentum / time_step
        sums[CONTACTS] += 2.0 * touching + resting + blocked
        sums[LARGEST] = max(sums[LARGEST], overlap)
        if step % FLUSH_INTERVAL == 0:
            flush(disks.taylor)
        shaking.step[0] = step
        shaking.predicted[0] = False
        if not overlap < overlap_limit:
            return OVERLAP
    return OK
