"""The inclined plane z = 0: a sphere of infinite radius and mass that obeys the spheres' law."""

from typing import NamedTuple

import numpy as np

from sim.compile import inlined, kernel
from sim.contact.friction import MEMORY
from sim.dynamics.spheres import (
    BLOCK,
    DX,
    DY,
    DZ,
    FX,
    MX,
    OVERLAP_ROW,
    REACH,
    SQUARE,
    STRIDE,
    VX,
    WX,
    evaluate,
    load_memory,
    store_memory,
)


class Plane(NamedTuple):
    """The plane's side of each contact: ``memory`` (N, 8), contact memory and last step."""

    memory: np.ndarray


def make_plane(particles: int) -> Plane:
    """Return a plane that nothing has touched yet."""
    memory = np.zeros((particles, MEMORY + 1))
    memory[:, MEMORY] = -1.0
    return Plane(memory)


@inlined
def _gather(spheres, plane, start, work, step):
    """Gather touching spheres from ``start`` on until the block is full; return count and next."""
    rows = work.rows
    touching = 0
    i = start
    number = spheres.radius.size
    while i < number and touching < BLOCK:
        height = spheres.position[i, 2]
        if height < spheres.radius[i]:
            work.pair[touching] = i
            rows[DX * STRIDE + touching] = 0.0
            rows[DY * STRIDE + touching] = 0.0
            rows[DZ * STRIDE + touching] = -height
            rows[SQUARE * STRIDE + touching] = height * height
            rows[REACH * STRIDE + touching] = spheres.radius[i]
            for d in range(3):
                rows[(VX + d) * STRIDE + touching] = -spheres.velocity[i, d]
                rows[(WX + d) * STRIDE + touching] = spheres.radius[i] * spheres.spin[i, d]
            load_memory(rows, touching, plane.memory, i, step)
            touching += 1
        i += 1
    return touching, i


@kernel
def plane_forces(law, spheres, plane, work, time_step, step):
    """Add the forces of the plane.

    Returns the number of touching spheres, the largest overlap relative to a diameter, and the sum
    of the forces on the spheres along x and z (N).
    """
    contacts, largest, along, upward = 0, 0.0, 0.0, 0.0
    start = 0
    while start < spheres.radius.size:
        touching, start = _gather(spheres, plane, start, work, step)
        evaluate(law, work.rows, touching, time_step)
        for k in range(touching):
            i = work.pair[k]
            for d in range(3):
                spheres.force[i, d] += work.rows[(FX + d) * STRIDE + k]
                spheres.torque[i, d] += spheres.radius[i] * work.rows[(MX + d) * STRIDE + k]
            along += work.rows[FX * STRIDE + k]
            upward += work.rows[(FX + 2) * STRIDE + k]
            largest = max(largest, 0.5 * work.rows[OVERLAP_ROW * STRIDE + k])
            store_memory(work.rows, k, plane.memory, i, step)
        contacts += touching
    return contacts, largest, along, upward
