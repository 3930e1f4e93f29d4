"""Forces between disks in two dimensions (x, z), without rotation."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.compile import kernel
from sim.contact.damping import disk_force
from sim.dynamics.neighbors import nearest_image

#: Taylor terms kept per coordinate: position and five derivatives.
TERMS = 6


class Disks(NamedTuple):
    """The beads, in SI units.

    ``taylor`` (6, N, 2): term k is the k-th time derivative of the position (x, z) times Δt^k/k!,
    so term 0 is the position and term 1 the velocity times Δt; ``force`` (N, 2), ``radius`` (N,),
    ``mass`` (N,).
    """

    taylor: np.ndarray
    force: np.ndarray
    radius: np.ndarray
    mass: np.ndarray


def make_disks(position, velocity, radius, mass, time_step: float) -> Disks:
    """Return disks at these positions and velocities, (N, 2), with all higher derivatives zero."""
    position = np.asarray(position, float)
    taylor = np.zeros((TERMS, *position.shape))
    taylor[0] = position
    taylor[1] = np.asarray(velocity, float) * time_step
    number = len(position)
    return Disks(
        taylor,
        np.zeros_like(position),
        np.broadcast_to(np.asarray(radius, float), number).copy(),
        np.broadcast_to(np.asarray(mass, float), number).copy(),
    )


@kernel
def pair_forces(law, disks, pairs, box, time_step):
    """Add the forces of all touching pairs, each disk's as it sees the contact itself.

    Returns the number of touching pairs and the largest overlap relative to the sum of the radii.
    """
    contacts, largest = 0, 0.0
    position, moved = disks.taylor[0], disks.taylor[1]
    per_step = 1.0 / time_step
    for i in range(disks.radius.size):
        own_x, own_z = 0.0, 0.0
        for p in range(pairs.start[i], pairs.start[i + 1]):
            j = pairs.second[p]
            dx = nearest_image(position[j, 0] - position[i, 0], box, 0)
            dz = position[j, 1] - position[i, 1]
            square = dx * dx + dz * dz
            reach = pairs.reach[p]
            if square < reach * reach:
                distance = sqrt(square)
                overlap = reach - distance
                nx, nz = dx / distance, dz / distance
                vx = (moved[i, 0] - moved[j, 0]) * per_step
                vz = (moved[i, 1] - moved[j, 1]) * per_step
                mass, partner = disks.mass[i], disks.mass[j]
                fx, fz = disk_force(law, overlap, (nx, nz), (vx, vz), mass, 1.0 / partner)
                own_x += fx
                own_z += fz
                fx, fz = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), partner, 1.0 / mass)
                disks.force[j, 0] += fx
                disks.force[j, 1] += fz
                contacts += 1
                largest = max(largest, overlap / reach)
        disks.force[i, 0] += own_x
        disks.force[i, 1] += own_z
    return contacts, largest
