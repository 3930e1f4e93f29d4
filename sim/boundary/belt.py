"""The vibrating belt: a rigid line that moves harmonically and carries a ghost disk per contact."""

from math import cos, sin
from typing import NamedTuple

from sim.compile import inlined, kernel
from sim.contact.damping import disk_force


class Belt(NamedTuple):
    """x = A_x sin(ωt + φ), z = A_z sin(ωt + φ) (Gallas et al., Eq. 1).

    ``amplitude_x``, ``amplitude_z`` (m); ``angular_frequency`` ω (1/s), 0 for a belt at rest;
    ``phase`` φ (rad); ``surface`` (m), height of the ghost's surface above the line: 0 for a ghost
    below the line, half a mean diameter for one centred on it.
    """

    amplitude_x: float
    amplitude_z: float
    angular_frequency: float
    phase: float
    surface: float


@inlined
def belt_state(belt, time):
    """Return height (m) and velocity (x, z) (m/s) of the belt."""
    angle = belt.angular_frequency * time + belt.phase
    speed = belt.angular_frequency * cos(angle)
    return (
        belt.amplitude_z * sin(angle),
        (belt.amplitude_x * speed, belt.amplitude_z * speed),
    )


@kernel
def belt_forces(law, disks, belt, time, time_step):
    """Add the forces of the belt; return the number of contacts and the largest overlap / diameter.

    The ghost lies right below the bead and moves with the belt, so the normal is vertical.
    """
    height, (belt_x, belt_z) = belt_state(belt, time)
    contacts, largest = 0, 0.0
    per_step = 1.0 / time_step
    for i in range(disks.radius.size):
        overlap = disks.radius[i] + belt.surface + height - disks.taylor[0, i, 1]
        if overlap > 0.0:
            vx = disks.taylor[1, i, 0] * per_step - belt_x
            vz = disks.taylor[1, i, 1] * per_step - belt_z
            fx, fz = disk_force(law, overlap, (0.0, -1.0), (vx, vz), disks.mass[i], 0.0)
            disks.force[i, 0] += fx
            disks.force[i, 1] += fz
            contacts += 1
            largest = max(largest, 0.5 * overlap / disks.radius[i])
    return contacts, largest
