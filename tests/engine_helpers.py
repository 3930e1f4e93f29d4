"""What the engine's tests share: constants, laws, drivers of single contacts, start states."""

from math import pi, sqrt

import numpy as np

from sim.boundary.belt import belt_state
from sim.compile import kernel
from sim.contact.cube_root import cube_root
from sim.contact.damping import disk_force
from sim.contact.friction import MEMORY, contact_force
from sim.contact.spring_damping import SpringDamping, spring_damping
from sim.contact.walton_braun import WaltonBraun, walton_braun
from sim.dynamics.gear import correct, flush, predict

#: The chute's spheres and the belt's mean bead, SI.
RADIUS, MASS, GRAVITY = 0.5e-3, 1.492e-6, 9.8
BEAD, BEAD_MASS, BEAD_GRAVITY = 1e-3, 1e-6, 10.0

#: Published stiffness Y (N/m) and damping (1/s) of the beads.
YOUNG = 1e3 * BEAD_GRAVITY * BEAD_MASS / BEAD
DAMPING = 50 * BEAD_GRAVITY

EXPONENTS = (0.0, 1 / 3, 1.0, 2.0)
MEMORIES = ("separation", "shrink", "reset")
CAPS = ("before", "after")


def sphere_law(**changes) -> WaltonBraun:
    """The base case of the chute, changed."""
    return walton_braun(**{"stiffness": 100.0, "restitution": 0.85, "friction": 0.4} | changes)


def bead_law(**changes) -> SpringDamping:
    """The base case of the belt, changed."""
    base = {"stiffness": YOUNG, "damping": DAMPING, "shear_damping": DAMPING}
    return spring_damping(**base | changes)


def collision_time(law: WaltonBraun) -> float:
    """Duration (s) of a collision of two of the chute's spheres."""
    restitution = sqrt(law.loading / law.unloading)
    return 0.5 * pi * sqrt(0.5 * MASS / law.loading) * (1.0 + restitution)


def weight_components(angle: float) -> tuple[float, float, float]:
    """Gravity (m/s2) on a plane inclined by ``angle`` degrees."""
    slope = np.radians(angle)
    return float(GRAVITY * np.sin(slope)), 0.0, float(-GRAVITY * np.cos(slope))


@kernel
def cube_roots(x):
    """Cube roots (n,) of x (n,) as the law takes them."""
    roots = np.empty_like(x)
    for k in range(x.size):
        roots[k] = cube_root(x[k])
    return roots


@kernel
def contact_path(law, overlap, normal, slip):
    """Take one contact along a path of overlaps (n,), normals (n, 3) and slips (n, 3).

    Returns normal forces (n,), tangential forces (n, 3) and memories (n, 7).
    """
    steps = overlap.size
    force, tangential = np.zeros(steps), np.zeros((steps, 3))
    memories = np.zeros((steps, MEMORY))
    memory = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for k in range(steps):
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        s = (slip[k, 0], slip[k, 1], slip[k, 2])
        force[k], t, memory = contact_force(law, overlap[k], n, s, memory)
        for d in range(3):
            tangential[k, d] = t[d]
        for m in range(MEMORY):
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


@kernel
def disk_forces(law, overlap, normal, velocity, mass, inverse_partner_mass):
    """Force (n, 2) on a disk in each of n contacts; the arguments are arrays over contacts."""
    force = np.zeros((overlap.size, 2))
    for k in range(overlap.size):
        n, v = (normal[k, 0], normal[k, 1]), (velocity[k, 0], velocity[k, 1])
        fx, fz = disk_force(law, overlap[k], n, v, mass[k], inverse_partner_mass[k])
        force[k, 0] = fx
        force[k, 1] = fz
    return force


@kernel
def belt_states(belt, time):
    """Height (n,) and velocity (n, 2) of the belt at times (n,)."""
    height, velocity = np.empty(time.size), np.empty((time.size, 2))
    for k in range(time.size):
        height[k], v = belt_state(belt, time[k])
        velocity[k, 0] = v[0]
        velocity[k, 1] = v[1]
    return height, velocity


@kernel
def damped_oscillation(integrator, taylor, stiffness, damping, steps, drive=0.0):
    """Advance Taylor terms (6, N, 2) of x'' = drive - stiffness x - damping x' by some steps."""
    for _ in range(steps):
        predict(integrator, taylor)
        for i in range(taylor.shape[1]):
            for d in range(2):
                speed = taylor[1, i, d] / integrator.time_step
                acceleration = drive - stiffness * taylor[0, i, d] - damping * speed
                correct(integrator, taylor, i, d, acceleration)


@kernel
def flushed(taylor):
    """Set vanishing Taylor terms to zero, in place."""
    flush(taylor)


def lattice(shape: tuple[int, ...], spacing: float, jitter: float, rng, base=0.0) -> np.ndarray:
    """Positions (N, D) on a cubic lattice, one spacing above ``base`` (m), each moved at random.

    ``jitter`` is the largest displacement per direction in spacings.
    """
    points = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    points = points.reshape(-1, len(shape)).astype(float)
    points += jitter * rng.uniform(-1, 1, points.shape)
    points[:, -1] += 1.0 + base / spacing
    return spacing * points


def rotation(rng) -> np.ndarray:
    """A random proper rotation (3, 3)."""
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return frame * np.linalg.det(frame)


def wrapped(difference: np.ndarray, *length: float) -> np.ndarray:
    """Differences (N, D) of positions as nearest periodic images; a length of 0 is an open edge."""
    length = np.array(length)
    period = np.where(length > 0, length, np.inf)
    return difference - length * np.round(difference / period)
