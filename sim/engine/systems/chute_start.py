"""Initial states of chute and conveyor: particles at random above the plane, others glued to it."""

from math import pi
from typing import NamedTuple

import numpy as np

from sim.engine.dynamics.cells import Box, make_box
from sim.engine.systems.packing import random_packing
from sim.parameters.spheres import SphereParameters


class Layer(NamedTuple):
    """Spheres: ``position`` and ``velocity`` (N, 3), ``radius`` and ``mass`` (N,), SI.

    Glued spheres come last; they have no mass. ``height`` (m) is that of the filled region.
    """

    position: np.ndarray
    velocity: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    height: float


def initial_layer(p: SphereParameters, box: Box, replicate: int) -> Layer:
    """Return the initial state of a replicate of spheres, or of discs in the plane y = 0.

    Raises ``ValueError`` when the particles do not fit.
    """
    rng = np.random.default_rng([p.seed, replicate])
    dimension, solid, root = (2, 4.0, np.sqrt) if p.is_flat else (3, 6.0, np.cbrt)
    cell, in_space = (make_box(box.length[0]), _insert_y) if p.is_flat else (box, np.asarray)
    height = p.depth * pi / solid * p.diameter / p.initial_packing
    size = _relative_diameters(p, rng)
    # The flow weighs as much as one of equal particles.
    size /= root((size**dimension).mean())
    radius = 0.5 * p.diameter * size
    position = random_packing(cell, height, radius, rng)
    velocity = _random_velocities(p, position.shape, rng)
    mass = p.mass * size**dimension
    mobile = Layer(in_space(position), in_space(velocity), radius, mass, height)
    if not p.bumps:
        return mobile
    return _lift_above(mobile, p, in_space(_bump_positions(p, cell, replicate)))


def _relative_diameters(p: SphereParameters, rng) -> np.ndarray:
    """Return diameters (N,) over the nominal diameter."""
    if p.diameter_spread > 0.0:
        return rng.uniform(1.0 - p.diameter_spread, 1.0 + p.diameter_spread, p.particles)
    return np.ones(p.particles)


def _random_velocities(p: SphereParameters, shape: tuple[int, ...], rng) -> np.ndarray:
    """Return random velocities (N, D) about the common one, m/s."""
    velocity = rng.normal(0.0, p.initial_agitation * p.velocity_unit / shape[1] ** 0.5, shape)
    velocity -= velocity.mean(axis=0)
    velocity[:, 0] += p.initial_velocity * p.velocity_unit
    return velocity


def _insert_y(flat: np.ndarray) -> np.ndarray:
    """Return vectors (N, 2) along x and z as (N, 3)."""
    return np.insert(flat, 1, 0.0, axis=1)


def _bump_positions(p: SphereParameters, box: Box, replicate: int) -> np.ndarray:
    """Return positions of the particles that are glued to the plane."""
    radius = p.bumps * p.diameter / 2
    if p.bump_arrangement == "random":
        rng = np.random.default_rng([p.seed, replicate, 1])
        return random_packing(box, 0.0, np.full(p.glued_particles, radius), rng)
    centres = (np.arange(p.bump_rows) + 0.5) / p.bump_rows
    grid = np.meshgrid(*(length * centres for length in box.length[:-1]), [radius])
    return np.stack([axis.ravel() for axis in grid], axis=1)


def _lift_above(mobile: Layer, p: SphereParameters, glued: np.ndarray) -> Layer:
    """Return the mobile particles, raised by a bump, followed by those glued at these positions."""
    diameter = p.bumps * p.diameter
    return Layer(
        np.concatenate([mobile.position + np.array([0.0, 0.0, diameter]), glued]),
        np.concatenate([mobile.velocity, np.zeros_like(glued)]),
        np.concatenate([mobile.radius, np.full(len(glued), diameter / 2)]),
        np.concatenate([mobile.mass, np.zeros(len(glued))]),
        mobile.height + diameter,
    )
