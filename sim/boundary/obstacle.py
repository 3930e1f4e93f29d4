"""The obstacle: a disk of infinite mass, fixed in the laboratory, that does not see the belt."""

from math import sqrt
from typing import NamedTuple

from sim.compile import kernel
from sim.contact.damping import disk_force
from sim.dynamics.neighbors import nearest_image


class Obstacle(NamedTuple):
    """Centre ``x``, ``z`` (m) and ``radius`` (m); a radius of 0 means that there is none."""

    x: float
    z: float
    radius: float


@kernel
def obstacle_forces(law, disks, obstacle, box, time_step):
    """Add the forces of the obstacle; return the number of contacts and the largest overlap.

    The overlap is relative to the sum of the radii.
    """
    contacts, largest = 0, 0.0
    if obstacle.radius <= 0.0:
        return contacts, largest
    per_step = 1.0 / time_step
    for i in range(disks.radius.size):
        dx = nearest_image(obstacle.x - disks.taylor[0, i, 0], box, 0)
        dz = obstacle.z - disks.taylor[0, i, 1]
        square = dx * dx + dz * dz
        reach = disks.radius[i] + obstacle.radius
        if square < reach * reach:
            distance = sqrt(square)
            velocity = (disks.taylor[1, i, 0] * per_step, disks.taylor[1, i, 1] * per_step)
            normal = (dx / distance, dz / distance)
            fx, fz = disk_force(law, reach - distance, normal, velocity, disks.mass[i], 0.0)
            disks.force[i, 0] += fx
            disks.force[i, 1] += fz
            contacts += 1
            largest = max(largest, (reach - distance) / reach)
    return contacts, largest
