"""Forces between disks in two dimensions (x, z), without rotation."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.compile import assume_no_alias, inlined, kernel
from sim.engine.contact.damping import disk_force, dissipated_powers, elastic_energy
from sim.engine.dynamics.cells import nearest_image
from sim.engine.dynamics.neighbors import find_touching

#: Taylor terms per coordinate: position and five derivatives.
TERMS = 6


class Disks(NamedTuple):
    """The beads, one column each, in SI units.

    ``taylor`` (6, 2, N): term k is the k-th time derivative of the position (x, z) times Δt^k/k!,
    so term 0 is the position and term 1 the velocity times Δt; ``force`` (2, N), ``radius`` (N,),
    ``mass`` (N,). ``label`` (1, N) is the bead's number in the initial state: the neighbor list
    keeps the beads sorted by position.
    """

    taylor: np.ndarray
    force: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    label: np.ndarray


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


@inlined
def disk_forces(law, disks, pairs, search, time_step):
    """Add the forces of all touching pairs, each disk's evaluated for itself.

    Returns the number of touching pairs, the largest overlap relative to the sum of the radii, and
    the powers (W) that normal and shear damping take.
    """
    assume_no_alias()
    x, force, mass = disks.taylor, disks.force, disks.mass
    largest, normal_loss, shear_loss = 0.0, 0.0, 0.0
    per_step = 1.0 / time_step
    touching = find_touching(x[0], pairs, 0, pairs.start[-1], 0, search.gap)
    for k in range(touching):
        p = np.uint64(pairs.touching[k])
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        dx = nearest_image(x[0, 0, j] - x[0, 0, i], pairs.box, 0)
        dz = x[0, 1, j] - x[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        reach = pairs.reach[p]
        overlap = reach - distance
        nx, nz = dx / distance, dz / distance
        velocity_i = (x[1, 0, i] * per_step, x[1, 1, i] * per_step)
        velocity_j = (x[1, 0, j] * per_step, x[1, 1, j] * per_step)
        vx, vz = velocity_i[0] - velocity_j[0], velocity_i[1] - velocity_j[1]
        fx, fz = disk_force(law, overlap, (nx, nz), (vx, vz), mass[i], 1.0 / mass[j])
        force[0, i] += fx
        force[1, i] += fz
        normal_power_i, shear_power_i = dissipated_powers(
            law, overlap, (nx, nz), velocity_i, (fx, fz)
        )
        fx, fz = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), mass[j], 1.0 / mass[i])
        force[0, j] += fx
        force[1, j] += fz
        normal_power_j, shear_power_j = dissipated_powers(
            law, overlap, (-nx, -nz), velocity_j, (fx, fz)
        )
        normal_loss += normal_power_i + normal_power_j
        shear_loss += shear_power_i + shear_power_j
        largest = max(largest, overlap / reach)
    return touching, largest, normal_loss, shear_loss


@kernel
def stored_in_disks(law, disks, pairs):
    """Return the energy (J) in the springs of all touching pairs."""
    x, energy = disks.taylor[0], 0.0
    for p in range(pairs.start[-1]):
        i, j = pairs.first[p], pairs.second[p]
        dx, dz = nearest_image(x[0, j] - x[0, i], pairs.box, 0), x[1, j] - x[1, i]
        overlap = pairs.reach[p] - sqrt(dx * dx + dz * dz)
        energy += elastic_energy(law, overlap) if overlap > 0.0 else 0.0
    return energy
