"""The vibrating belt, a rigid line that carries a ghost disk per contact, and the obstacle.

The obstacle is a disk of infinite mass,
fixed in the laboratory, that the belt does not move.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.boundary.motion import Harmonic, shape_of
from sim.engine.compile import append_negative, assume_no_alias, inlined, kernel
from sim.engine.contact.damping import disk_force, dissipated_powers, elastic_energy
from sim.engine.dynamics.cells import nearest_image


class Belt(NamedTuple):
    """x = A_x s_x(ωt + φ), z = A_z s_z(ωt + φ), both s the sine for a harmonic ``motion``.

    ``amplitude_x``, ``amplitude_z`` (m); ``angular_frequency`` ω (1/s), 0 for a belt at rest;
    ``phase`` φ (rad); ``surface`` (m), height of the ghost's surface above the line: 0 for a ghost
    below the line, half a mean diameter for one centred on it; ``inverse_mass`` (1/kg) of the
    ghost, which enters the damping alone: it moves with the belt whatever its mass.
    """

    amplitude_x: float
    amplitude_z: float
    angular_frequency: float
    phase: float
    surface: float
    inverse_mass: float = 0.0
    motion: NamedTuple = Harmonic()


@inlined
def belt_state(belt, time):
    """Return height (m) and velocity (x, z) (m/s) of the belt (Gallas et al., Eq. 1)."""
    z, along, up = shape_of(belt.motion, belt.angular_frequency * time + belt.phase)
    speed_x = belt.amplitude_x * belt.angular_frequency * along
    return belt.amplitude_z * z, (speed_x, belt.amplitude_z * belt.angular_frequency * up)


@kernel
def belt_height(belt, time):
    """Return the height (m) of the belt above its mean."""
    return belt_state(belt, time)[0]


@inlined
def belt_forces(law, disks, belt, search, time, time_step):
    """Add the forces of the belt.

    The ghost lies right below the bead and moves with the belt, so the normal is vertical. Returns
    the number of contacts, the largest overlap per diameter, the powers (W) that normal and shear
    damping take, the power of the belt, and the force (x, z) (N) on all beads.
    """
    assume_no_alias()
    height, (belt_x, belt_z) = belt_state(belt, time)
    largest, per_step, beads = 0.0, 1.0 / time_step, disks.radius.size
    normal_loss, shear_loss, power, force_x, force_z = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(beads):
        search.gap[i] = disks.taylor[0, 1, i] - disks.radius[i] - (belt.surface + height)
    contacts = np.int64(append_negative(search.gap, beads, 0, search.touching, np.uint64(0)))
    for k in range(contacts):
        i = np.uint64(search.touching[k])
        overlap = -search.gap[i]
        vx = disks.taylor[1, 0, i] * per_step - belt_x
        vz = disks.taylor[1, 1, i] * per_step - belt_z
        fx, fz = disk_force(law, overlap, (0.0, -1.0), (vx, vz), disks.mass[i], belt.inverse_mass)
        disks.force[0, i] += fx
        disks.force[1, i] += fz
        normal_power, shear_power = dissipated_powers(law, overlap, (0.0, -1.0), (vx, vz), (fx, fz))
        normal_loss += normal_power
        shear_loss += shear_power
        power += fx * belt_x + fz * belt_z
        force_x += fx
        force_z += fz
        largest = max(largest, 0.5 * overlap / disks.radius[i])
    return contacts, largest, normal_loss, shear_loss, power, (force_x, force_z)


@kernel
def stored_in_belt(law, disks, belt, time):
    """Return the energy (J) in the springs of all beads on the belt."""
    height, energy = belt_state(belt, time)[0] + belt.surface, 0.0
    for i in range(disks.radius.size):
        overlap = disks.radius[i] + height - disks.taylor[0, 1, i]
        energy += elastic_energy(law, overlap) if overlap > 0.0 else 0.0
    return energy


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
