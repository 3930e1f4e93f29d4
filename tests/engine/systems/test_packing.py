"""Random initial positions: no overlaps, inside the layer, as dense as asked, or an error."""

import numpy as np
import pytest

from sim.engine.dynamics.cells import make_box
from sim.engine.systems.start import random_packing
from tests.engine_motion.helpers import wrapped

UNIT = 1e-3


def least_gap(position, radius, length) -> float:
    """Smallest distance between surfaces, over all pairs and periodic images (m)."""
    least = np.inf
    for i in range(len(position) - 1):
        apart = wrapped(position[i + 1 :] - position[i], *length)
        least = min(least, (np.linalg.norm(apart, axis=1) - radius[i] - radius[i + 1 :]).min())
    return least


@pytest.mark.parametrize(
    ("length", "packing", "spread"),
    [
        ((3e-3, 3e-3, 0.0), 0.35, 0.0),
        ((6e-3, 5e-3, 0.0), 0.32, 0.2),
        ((12e-3, 0.0), 0.4, 0.0),
        ((12e-3, 0.0), 0.3, 0.5),
    ],
)
def test_particles_are_inside_without_overlap_at_the_packing_asked_for(length, packing, spread):
    rng = np.random.default_rng(3)
    radius = 0.5 * UNIT * rng.uniform(1 - spread, 1 + spread, 150)
    volume = np.pi * radius**2 if len(length) == 2 else 4 / 3 * np.pi * radius**3
    height = volume.sum() / (packing * np.prod(length[:-1]))
    position = random_packing(make_box(*length[:-1]), height, radius, rng)
    assert least_gap(position, radius, length) >= 0.0
    assert (position[:, :-1] >= 0).all() and (position[:, :-1] < length[:-1]).all()
    assert (position[:, -1] >= radius).all() and (position[:, -1] <= radius + height).all()
    assert position[:, -1].max() > 0.8 * height


def test_positions_are_uniform_where_there_is_room():
    """A dilute layer: each eighth of it holds its share within five standard deviations."""
    radius = np.full(4000, 0.05 * UNIT)
    box, rng = make_box(20e-3, 20e-3), np.random.default_rng(5)
    position = random_packing(box, 20e-3, radius, rng)
    share, _ = np.histogramdd(position, bins=2, range=[(0, 20e-3)] * 3)
    assert np.abs(share / 4000 - 1 / 8).max() < 5 * np.sqrt(7 / 64 / 4000)


def test_the_generator_decides():
    box, radius = make_box(6e-3, 6e-3), np.full(50, 0.5 * UNIT)
    first, again, other = (
        random_packing(box, 5e-3, radius, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_one_particle_fits_into_a_layer_without_height():
    box, rng = make_box(3e-3, 3e-3), np.random.default_rng(0)
    position = random_packing(box, 0.0, np.array([0.5 * UNIT]), rng)
    assert position[0, 2] == 0.5 * UNIT


@pytest.mark.parametrize("length", [(5e-3, 0.0), (4e-3, 4e-3, 0.0)])
def test_what_cannot_fit_is_an_error_that_says_so(length):
    radius, rng = np.full(60, 0.5 * UNIT), np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"only \d+ of 60 particles fit"):
        random_packing(make_box(*length[:-1]), 1.0 * UNIT, radius, rng)
