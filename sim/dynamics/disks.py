"""Forces between disks in two dimensions (x, z), without rotation."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.compile import inlined, vectorised
from sim.contact.damping import disk_force
from sim.dynamics.cells import nearest_image
from sim.dynamics.neighbors import find_touching

#: Taylor terms kept per coordinate: position and five derivatives.
TERMS = 6

#: Pairs that are examined together.
BLOCK = 256


class Disks(NamedTuple):
    """The beads, one column each, in SI units.

    ``taylor`` (6, 2, N): term k is the k-th time derivative of the position (x, z) times Δt^k/k!,
    so term 0 is the position and term 1 the velocity times Δt; ``force`` (2, N), ``radius`` (N,),
    ``mass`` (N,). ``label`` (1, N) is the bead's number in the initial state: the neighbor list
    keeps the beads sorted by place.
    """

    taylor: np.ndarray
    force: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    label: np.ndarray


class Work(NamedTuple):
    """Scratch of the search for contacts: ``gap`` (m² or m) and which beads are ``touching``."""

    gap: np.ndarray
    touching: np.ndarray


def make_disks(position, velocity, radius, mass, time_step: float) -> Disks:
    """Return disks at these positions and velocities, (N, 2), with all higher derivatives zero."""
    number = len(position)
    taylor = np.zeros((TERMS, 2, number))
    taylor[0] = np.transpose(position)
    taylor[1] = np.transpose(velocity) * time_step
    return Disks(
        taylor,
        np.zeros((2, number)),
        np.broadcast_to(np.asarray(radius, float), number).copy(),
        np.broadcast_to(np.asarray(mass, float), number).copy(),
        np.arange(number).reshape(1, number),
    )


def make_work(beads: int) -> Work:
    """Return scratch space for this many beads."""
    return Work(np.zeros(max(BLOCK, beads)), np.zeros(beads + 8, np.uint32))


@inlined
def pair_forces(law, disks, pairs, box, work, time_step):
    """Add the forces of all touching pairs, each disk's as it sees the contact itself.

    Returns the number of touching pairs and the largest overlap relative to the sum of the radii.
    """
    vectorised()
    x, force, mass = disks.taylor, disks.force, disks.mass
    largest = 0.0
    per_step = 1.0 / time_step
    touching = find_touching(x[0], pairs, box, 0, pairs.start[-1], 0, work.gap)
    for k in range(touching):
        p = np.uint64(pairs.touching[k])
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        dx = nearest_image(x[0, 0, j] - x[0, 0, i], box, 0)
        dz = x[0, 1, j] - x[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        reach = pairs.reach[p]
        overlap = reach - distance
        nx, nz = dx / distance, dz / distance
        vx = (x[1, 0, i] - x[1, 0, j]) * per_step
        vz = (x[1, 1, i] - x[1, 1, j]) * per_step
        fx, fz = disk_force(law, overlap, (nx, nz), (vx, vz), mass[i], 1.0 / mass[j])
        force[0, i] += fx
        force[1, i] += fz
        fx, fz = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), mass[j], 1.0 / mass[i])
        force[0, j] += fx
        force[1, j] += fz
        largest = max(largest, overlap / reach)
    return touching, largest
