"""The obstacle: a disk of infinite mass, fixed in the laboratory, that does not see the belt."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.compile import append_negative, inlined, vectorised
from sim.contact.damping import disk_force
from sim.dynamics.cells import nearest_image


class Obstacle(NamedTuple):
    """Centre ``x``, ``z`` (m) and ``radius`` (m); a radius of 0 means that there is none."""

    x: float
    z: float
    radius: float


@inlined
def obstacle_forces(law, disks, obstacle, box, work, time_step):
    """Add the forces of the obstacle; return the number of contacts and the largest overlap.

    The overlap is relative to the sum of the radii.
    """
    vectorised()
    largest, per_step, beads = 0.0, 1.0 / time_step, disks.radius.size
    if obstacle.radius <= 0.0:
        return 0, largest
    for i in range(beads):
        dx = nearest_image(obstacle.x - disks.taylor[0, 0, i], box, 0)
        dz = obstacle.z - disks.taylor[0, 1, i]
        work.gap[i] = dx * dx + dz * dz - (disks.radius[i] + obstacle.radius) ** 2
    contacts = np.int64(append_negative(work.gap, beads, 0, work.touching, np.uint64(0)))
    for k in range(contacts):
        i = np.uint64(work.touching[k])
        dx = nearest_image(obstacle.x - disks.taylor[0, 0, i], box, 0)
        dz = obstacle.z - disks.taylor[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        reach = disks.radius[i] + obstacle.radius
        velocity = (disks.taylor[1, 0, i] * per_step, disks.taylor[1, 1, i] * per_step)
        normal = (dx / distance, dz / distance)
        fx, fz = disk_force(law, reach - distance, normal, velocity, disks.mass[i], 0.0)
        disks.force[0, i] += fx
        disks.force[1, i] += fz
        largest = max(largest, (reach - distance) / reach)
    return contacts, largest
