"""The initial state of a chute: spheres at random above the plane, and those glued to it."""

from math import pi
from typing import NamedTuple

import numpy as np

from sim.engine.dynamics.cells import Box
from sim.engine.systems.packing import random_packing
from sim.parameters import ChuteParameters


class Layer(NamedTuple):
    """Spheres: ``position`` and ``velocity`` (N, 3), ``radius`` and ``mass`` (N,), SI.

    Glued spheres come last; they have no mass. ``height`` (m) is what they fill.
    """

    position: np.ndarray
    velocity: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    height: float


def initial_layer(p: ChuteParameters, box: Box, replicate: int) -> Layer:
    """Return the initial state of a replicate.

    Raises ``ValueError`` when the particles do not fit.
    """
    rng = np.random.default_rng([p.seed, replicate])
    height = p.depth * pi / 6.0 * p.diameter / p.initial_packing
    size = np.ones(p.particles)
    if p.diameter_spread > 0.0:
        size = rng.uniform(1.0 - p.diameter_spread, 1.0 + p.diameter_spread, p.particles)
        # The flow shall weigh as much as one of equal spheres.
        size /= np.cbrt((size**3).mean())
    radius = 0.5 * p.diameter * size
    position = random_packing(box, height, radius, rng)
    velocity = rng.normal(0.0, p.initial_agitation * p.velocity_unit / 3**0.5, position.shape)
    velocity -= velocity.mean(axis=0)
    velocity[:, 0] += p.initial_velocity * p.velocity_unit
    mobile = Layer(position, velocity, radius, p.mass * size**3, height)
    return _above_bumps(mobile, p, box, replicate) if p.bumps > 0.0 else mobile


def _above_bumps(mobile: Layer, p: ChuteParameters, box: Box, replicate: int) -> Layer:
    """Lift the spheres and put those that are glued to the plane below them."""
    rng = np.random.default_rng([p.seed, replicate, 1])
    diameter = p.bumps * p.diameter
    radius = np.full(p.glued, diameter / 2)
    glued = random_packing(box, 0.0, radius, rng)
    lifted = mobile.position + np.array([0.0, 0.0, diameter])
    return Layer(
        np.concatenate([lifted, glued]),
        np.concatenate([mobile.velocity, np.zeros_like(glued)]),
        np.concatenate([mobile.radius, radius]),
        np.concatenate([mobile.mass, np.zeros(len(radius))]),
        mobile.height + diameter,
    )
