"""Forces between spheres, and between spheres and the plane, in three dimensions.

Touching pairs are gathered into blocks of work rows, the law is evaluated over a whole block in one
loop without branches, which the compiler turns into vector instructions, and the results are added
to the particles. One flat work array with a constant stride between its rows lets the compiler see
that the rows do not overlap.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.compile import inlined, kernel
from sim.contact.friction import MEMORY, contact_force
from sim.dynamics.neighbors import STAMP, nearest_image

#: Pairs examined per block; about a third of them touch in a dense flow.
BLOCK = 256

#: Distance between rows of the work array: not a power of two, or all rows would compete for the
#: same few lines of the cache.
STRIDE = BLOCK + 8

# Rows of the work array: geometry and motion in, forces out, memory in and out.
DX, DY, DZ, SQUARE, REACH = range(5)
VX, VY, VZ, WX, WY, WZ = range(5, 11)
FX, FY, FZ, MX, MY, MZ, OVERLAP_ROW = range(11, 18)
MEMORY_ROW = 18
ROWS = MEMORY_ROW + MEMORY


class Spheres(NamedTuple):
    """The particles: (N, 3) arrays in SI units, and (N,) radius (m), mass (kg), inertia (kg m²).

    ``velocity`` and ``spin`` (angular velocity, 1/s) belong to the half step before ``position``;
    ``force`` and ``torque`` those of the last evaluation.
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    inertia: np.ndarray


class Work(NamedTuple):
    """Scratch of the force pass: ``rows`` (flat) and the ``pair`` that each column belongs to."""

    rows: np.ndarray
    pair: np.ndarray


def make_spheres(position, velocity, radius, mass) -> Spheres:
    """Return solid spheres (I = 2/5 m r²) at rest in rotation; radius and mass may be scalars."""
    position = np.ascontiguousarray(position, float)
    number = len(position)
    radius = np.broadcast_to(np.asarray(radius, float), number).copy()
    mass = np.broadcast_to(np.asarray(mass, float), number).copy()
    zeros = [np.zeros((number, 3)) for _ in range(3)]
    velocity = np.ascontiguousarray(velocity, float)
    return Spheres(position, velocity, *zeros, radius, mass, 0.4 * mass * radius**2)


def make_work() -> Work:
    """Return scratch space for one thread."""
    return Work(np.zeros(ROWS * STRIDE), np.zeros(BLOCK, np.int64))


@inlined
def load_memory(rows, k, memory, index, step):
    """Copy a contact's memory into column k, or zeros if it did not touch in the last step."""
    held = 1.0 if memory[index, STAMP] == step - 1 else 0.0
    for m in range(MEMORY):
        rows[(MEMORY_ROW + m) * STRIDE + k] = memory[index, m] * held


@inlined
def store_memory(rows, k, memory, index, step):
    """Copy column k back into a contact's memory and mark it as touching at this step."""
    for m in range(MEMORY):
        memory[index, m] = rows[(MEMORY_ROW + m) * STRIDE + k]
    memory[index, STAMP] = step


@inlined
def evaluate(law, rows, touching, time_step):
    """Apply the law to all columns: forces, moments, memory and overlap relative to the reach."""
    for k in range(touching):
        distance = sqrt(rows[SQUARE * STRIDE + k])
        reach = rows[REACH * STRIDE + k]
        overlap = reach - distance
        scale = 1.0 / distance
        nx = rows[DX * STRIDE + k] * scale
        ny = rows[DY * STRIDE + k] * scale
        nz = rows[DZ * STRIDE + k] * scale
        wx, wy, wz = rows[WX * STRIDE + k], rows[WY * STRIDE + k], rows[WZ * STRIDE + k]
        sx = rows[VX * STRIDE + k] - (wy * nz - wz * ny)
        sy = rows[VY * STRIDE + k] - (wz * nx - wx * nz)
        sz = rows[VZ * STRIDE + k] - (wx * ny - wy * nx)
        along = sx * nx + sy * ny + sz * nz
        slip = (
            (sx - along * nx) * time_step,
            (sy - along * ny) * time_step,
            (sz - along * nz) * time_step,
        )
        memory = (
            rows[(MEMORY_ROW + 0) * STRIDE + k],
            rows[(MEMORY_ROW + 1) * STRIDE + k],
            rows[(MEMORY_ROW + 2) * STRIDE + k],
            rows[(MEMORY_ROW + 3) * STRIDE + k],
            rows[(MEMORY_ROW + 4) * STRIDE + k],
            rows[(MEMORY_ROW + 5) * STRIDE + k],
            rows[(MEMORY_ROW + 6) * STRIDE + k],
        )
        force, (tx, ty, tz), memory = contact_force(law, overlap, (nx, ny, nz), slip, memory)
        rows[FX * STRIDE + k] = tx - force * nx
        rows[FY * STRIDE + k] = ty - force * ny
        rows[FZ * STRIDE + k] = tz - force * nz
        rows[MX * STRIDE + k] = ny * tz - nz * ty
        rows[MY * STRIDE + k] = nz * tx - nx * tz
        rows[MZ * STRIDE + k] = nx * ty - ny * tx
        rows[(MEMORY_ROW + 0) * STRIDE + k] = memory[0]
        rows[(MEMORY_ROW + 1) * STRIDE + k] = memory[1]
        rows[(MEMORY_ROW + 2) * STRIDE + k] = memory[2]
        rows[(MEMORY_ROW + 3) * STRIDE + k] = memory[3]
        rows[(MEMORY_ROW + 4) * STRIDE + k] = memory[4]
        rows[(MEMORY_ROW + 5) * STRIDE + k] = memory[5]
        rows[(MEMORY_ROW + 6) * STRIDE + k] = memory[6]
        rows[OVERLAP_ROW * STRIDE + k] = overlap / reach


@inlined
def _gather_pairs(spheres, pairs, box, start, stop, work, step):
    """Gather the touching pairs among ``start``..``stop``; return their number."""
    rows, x = work.rows, spheres.position
    first, second = pairs.first, pairs.second
    for k in range(stop - start):
        i, j = np.uint64(first[start + k]), np.uint64(second[start + k])
        dx = nearest_image(x[j, 0] - x[i, 0], box, 0)
        dy = nearest_image(x[j, 1] - x[i, 1], box, 1)
        dz = nearest_image(x[j, 2] - x[i, 2], box, 2)
        rows[SQUARE * STRIDE + k] = dx * dx + dy * dy + dz * dz
    touching = 0
    for k in range(stop - start):
        reach = pairs.reach[start + k]
        work.pair[touching] = start + k
        touching += 1 if rows[SQUARE * STRIDE + k] < reach * reach else 0
    for k in range(touching):
        p = work.pair[k]
        i, j = np.uint64(first[p]), np.uint64(second[p])
        dx = nearest_image(x[j, 0] - x[i, 0], box, 0)
        dy = nearest_image(x[j, 1] - x[i, 1], box, 1)
        dz = nearest_image(x[j, 2] - x[i, 2], box, 2)
        rows[DX * STRIDE + k] = dx
        rows[DY * STRIDE + k] = dy
        rows[DZ * STRIDE + k] = dz
        rows[SQUARE * STRIDE + k] = dx * dx + dy * dy + dz * dz
        rows[REACH * STRIDE + k] = pairs.reach[p]
        for d in range(3):
            rows[(VX + d) * STRIDE + k] = spheres.velocity[j, d] - spheres.velocity[i, d]
            rows[(WX + d) * STRIDE + k] = (
                spheres.radius[i] * spheres.spin[i, d] + spheres.radius[j] * spheres.spin[j, d]
            )
        load_memory(rows, k, pairs.memory, p, step)
    return touching


@inlined
def _scatter_pairs(spheres, pairs, work, touching, step):
    """Add the block's forces and torques to both particles; return the largest overlap."""
    rows, largest = work.rows, 0.0
    for k in range(touching):
        p = work.pair[k]
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        for d in range(3):
            force = rows[(FX + d) * STRIDE + k]
            moment = rows[(MX + d) * STRIDE + k]
            spheres.force[i, d] += force
            spheres.force[j, d] -= force
            spheres.torque[i, d] += spheres.radius[i] * moment
            spheres.torque[j, d] += spheres.radius[j] * moment
        store_memory(rows, k, pairs.memory, p, step)
        largest = max(largest, rows[OVERLAP_ROW * STRIDE + k])
    return largest


@kernel
def pair_forces(law, spheres, pairs, box, work, time_step, step):
    """Add the forces of all touching pairs.

    Returns the number of touching pairs and the largest overlap relative to the sum of the radii.
    """
    contacts = 0
    largest = 0.0
    number = pairs.start[-1]
    for start in range(0, number, BLOCK):
        stop = min(start + BLOCK, number)
        touching = _gather_pairs(spheres, pairs, box, start, stop, work, step)
        evaluate(law, work.rows, touching, time_step)
        largest = max(largest, _scatter_pairs(spheres, pairs, work, touching, step))
        contacts += touching
    return contacts, largest
