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
    """Return the initial state of a replicate of spheres.

    Raises ``ValueError`` when the particles do not fit.
    """
    rng = np.random.default_rng([p.seed, replicate])
    height = p.depth * pi / 6.0 * p.diameter / p.initial_packing
    size = _relative_diameters(p, rng)
    if p.diameter_spread > 0.0:
        # The flow weighs as much as one of equal spheres.
        size /= np.cbrt((size**3).mean())
    radius = 0.5 * p.diameter * size
    position = random_packing(box, height, radius, rng)
    velocity = _random_velocities(p, position.shape, rng)
    mobile = Layer(position, velocity, radius, p.mass * size**3, height)
    if not p.bumps:
        return mobile
    return _lift_above(mobile, p, _bump_positions(p, box, replicate))


def initial_row(p: SphereParameters, box: Box, replicate: int) -> Layer:
    """Return the initial state of a replicate of discs, all in the plane y = 0.

    Raises ``ValueError`` when the discs do not fit.
    """
    rng = np.random.default_rng([p.seed, replicate])
    height = p.depth * pi / 4.0 * p.diameter / p.initial_packing
    size = _relative_diameters(p, rng)
    size /= np.sqrt((size**2).mean())
    radius = 0.5 * p.diameter * size
    flat = make_box(box.length[0])
    position = random_packing(flat, height, radius, rng)
    velocity = _random_velocities(p, position.shape, rng)
    mobile = Layer(_insert_y(position), _insert_y(velocity), radius, p.mass * size**2, height)
    if not p.bumps:
        return mobile
    return _lift_above(mobile, p, _insert_y(_bump_positions(p, flat, replicate)))


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
