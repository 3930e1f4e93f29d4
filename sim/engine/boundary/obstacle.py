"""The obstacle: a disk of infinite mass, fixed in the laboratory, that the belt does not move."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.compile import append_negative, assume_no_alias, inlined, kernel
from sim.engine.contact.damping import disk_force, dissipated_powers, elastic_energy
from sim.engine.dynamics.cells import nearest_image


class Obstacle(NamedTuple):
    """Centre ``x``, ``z`` (m) and ``radius`` (m); a radius of 0 means that there is none."""

    x: float
    z: float
    radius: float


@inlined
def obstacle_forces(law, disks, obstacle, box, search, time_step):
    """Add the forces of the obstacle.

    Returns the number of contacts, the largest overlap relative to the sum of the radii, and the
    powers (W) that normal and shear damping take.
    """
    assume_no_alias()
    largest, per_step, beads = 0.0, 1.0 / time_step, disks.radius.size
    normal_loss, shear_loss = 0.0, 0.0
    if obstacle.radius <= 0.0:
        return 0, largest, normal_loss, shear_loss
    for i in range(beads):
        dx = nearest_image(obstacle.x - disks.taylor[0, 0, i], box, 0)
        dz = obstacle.z - disks.taylor[0, 1, i]
        search.gap[i] = dx * dx + dz * dz - (disks.radius[i] + obstacle.radius) ** 2
    contacts = np.int64(append_negative(search.gap, beads, 0, search.touching, np.uint64(0)))
    for k in range(contacts):
        i = np.uint64(search.touching[k])
        dx = nearest_image(obstacle.x - disks.taylor[0, 0, i], box, 0)
        dz = obstacle.z - disks.taylor[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        reach = disks.radius[i] + obstacle.radius
        velocity = (disks.taylor[1, 0, i] * per_step, disks.taylor[1, 1, i] * per_step)
        normal = (dx / distance, dz / distance)
        fx, fz = disk_force(law, reach - distance, normal, velocity, disks.mass[i], 0.0)
        disks.force[0, i] += fx
        disks.force[1, i] += fz
        normal_power, shear_power = dissipated_powers(
            law, reach - distance, normal, velocity, (fx, fz)
        )
        normal_loss += normal_power
        shear_loss += shear_power
        largest = max(largest, (reach - distance) / reach)
    return contacts, largest, normal_loss, shear_loss


@kernel
def stored_in_obstacle(law, disks, obstacle, box):
    """Return the energy (J) in the springs of all beads at the obstacle."""
    energy = 0.0
    if obstacle.radius <= 0.0:
        return energy
    for i in range(disks.radius.size):
        dx = nearest_image(obstacle.x - disks.taylor[0, 0, i], box, 0)
        dz = obstacle.z - disks.taylor[0, 1, i]
        overlap = disks.radius[i] + obstacle.radius - sqrt(dx * dx + dz * dz)
        energy += elastic_energy(law, overlap) if overlap > 0.0 else 0.0
    return energy
