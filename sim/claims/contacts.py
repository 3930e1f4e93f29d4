"""Single contacts along prescribed paths, and the linear spring as a reference."""

from math import sqrt

import numpy as np

from sim.engine.compile import kernel
from sim.engine.contact.friction import blank_memory, contact_force


@kernel
def contact_path(law, overlap, normal, slip):
    """Follow one contact along a path of overlaps (n,), normals (n, 3) and slips (n, 3).

    Returns normal forces (n,), tangential forces (n, 3) and memories (n, M).
    """
    steps = overlap.size
    force, tangential = np.zeros(steps), np.zeros((steps, 3))
    memory = blank_memory(law)
    memories = np.zeros((steps, len(memory)))
    for k in range(steps):
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        s = (slip[k, 0], slip[k, 1], slip[k, 2])
        approach = overlap[k] - (overlap[k - 1] if k else 0.0)
        force[k], t, memory, _ = contact_force(law, overlap[k], approach, n, s, memory)
        for d in range(3):
            tangential[k, d] = t[d]
        for m in range(len(memory)):
            memories[k, m] = memory[m]
    return force, tangential, memories


@kernel
def vector_spring(slip, normal_force, stiffness, friction):
    """Cundall and Strack's spring: force (n, 2) after slips (n, 2), cut to friction times F_N."""
    force = np.empty_like(slip)
    x, y = 0.0, 0.0
    for k in range(normal_force.size):
        x, y = x + stiffness * slip[k, 0], y + stiffness * slip[k, 1]
        excess = max(1.0, sqrt(x * x + y * y) / (friction * normal_force[k]))
        x, y = x / excess, y / excess
        force[k, 0] = x
        force[k, 1] = y
    return force


def random_curve(seed: int, steps: int) -> np.ndarray:
    """Return a smooth closed random curve (steps + 1, 2) from the origin, of size one."""
    rng = np.random.default_rng(seed)
    mode = np.arange(1, 6)
    angle = 2 * np.pi * np.linspace(0, 1, steps + 1)[:, None] * mode
    sines, cosines = rng.normal(size=(2, 5, 2)) / mode[:, None]
    curve = np.sin(angle) @ sines + (np.cos(angle) - 1) @ cosines
    return curve / np.abs(curve).max()
