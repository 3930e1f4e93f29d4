"""A base that is a slice of a random packing: filled, closed, without order, without overlaps."""

import numpy as np
import pytest

from sim.engine.systems import build
from sim.engine.systems.packed_base import MAX_OVERLAP, random_close_packing
from sim.parameters.images import PACKING, SLICE, TOP
from tests.engine_motion.points import chute_point

ROUGH = {"bumps": 0.8, "bump_arrangement": "packing", "law": "hertz", "depth": 1}


def gaps(place: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Distances (N, N) of the nearest images; of a sphere with itself it is infinite."""
    apart = place[:, None] - place
    apart -= sides * np.round(apart / sides)
    return np.sqrt((apart**2).sum(axis=-1)) + np.diag(np.full(len(place), np.inf))


def test_the_packing_has_its_fraction_without_overlap_or_order():
    sides = np.array([6.0, 5.0, 5.0])
    place = random_close_packing(sides, np.random.default_rng(3))
    assert len(place) * np.pi / 6 / sides.prod() == pytest.approx(PACKING, rel=0.005)
    apart = gaps(place, sides)
    assert apart.min() >= 1 - MAX_OVERLAP
    # As many near neighbors along each direction: the squares of unit vectors have the mean 1/3.
    first, second = np.nonzero(apart < 1.2)
    bonds = place[first] - place[second]
    bonds -= sides * np.round(bonds / sides)
    assert (bonds**2 / (bonds**2).sum(axis=1)[:, None]).mean(axis=0) == pytest.approx(
        1 / 3, abs=0.04
    )
    waves = np.exp(2j * np.pi * place[:, 2, None] * np.linspace(0.9, 1.4, 40)).mean(axis=0)
    assert np.abs(waves).max() < 0.25


@pytest.mark.parametrize("cell", [[7, 4], 5])
def test_the_base_is_a_closed_rough_slice_below_all_that_flows(cell):
    p = chute_point(cell=cell, **ROUGH)
    start = build(p, 0).snapshot()
    glued = start["fixed"] == 1
    place, top = start["position"] / (0.8 * p.diameter), TOP
    base, sides = place[glued], np.array([p.cell, p.breadth, 1e6]) / 0.8
    assert len(base) == p.glued_particles
    assert base[:, 2].min() == pytest.approx(0.5)
    assert np.ptp(base[:, 2]) == pytest.approx(SLICE, abs=0.1) and base[:, 2].max() + 0.5 < top
    assert base[:, 2].std() > 0.25
    assert gaps(base, sides).min() >= 1 - MAX_OVERLAP - 1e-9
    seen = np.stack(np.meshgrid(*(np.linspace(0, side, 60, False) for side in sides[:2])), -1)
    apart = seen.reshape(-1, 1, 2) - base[:, :2]
    apart -= sides[:2] * np.round(apart / sides[:2])
    assert ((apart**2).sum(axis=-1) < 0.25).any(axis=1).mean() > 0.75
    radius = start["radius"][~glued] / (0.8 * p.diameter)
    assert (place[~glued, 2] - radius).min() >= top - 1e-9


def test_each_replicate_has_a_base_of_its_own_and_always_the_same():
    p = chute_point(cell=4, replicates=2, **ROUGH)
    first, again, other = (build(p, k).snapshot()["position"] for k in (0, 0, 1))
    assert np.array_equal(first, again) and first.shape == other.shape
    assert not np.allclose(first, other)
