"""Order of spheres at known positions."""

import numpy as np
import pytest

from sim.measures.order import MIN_BONDS, coherent_bonds, crystalline_share, layer_order

SIZE = 1e-3


def crystal(cells: int, high: int) -> tuple[np.ndarray, float]:
    """Face-centred cubic positions (N, 3) at contact, and the side of the cell they fill."""
    edge = np.sqrt(2) * SIZE
    basis = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    corner = np.stack(np.meshgrid(*map(np.arange, (cells, cells, high)), indexing="ij"), -1)
    return edge * (corner.reshape(-1, 1, 3) + basis).reshape(-1, 3), cells * edge


def scattered_positions(number: int, side: float, height: float) -> np.ndarray:
    return np.random.default_rng(1).uniform(0, 1, (number, 3)) * [side, side, height]


def test_spheres_of_a_crystal_are_crystalline_across_the_edges_of_the_cell_but_not_of_its_top():
    position, side = crystal(4, 4)
    bonds = coherent_bonds(position, side, SIZE)
    inside = (position[:, 2] > 0.1 * SIZE) & (position[:, 2] < position[:, 2].max() - 0.1 * SIZE)
    assert (bonds[inside] == 12).all()
    assert (bonds[~inside] == MIN_BONDS).all()
    shifted = position + np.array([3.7 * side, -0.4 * side, 0.02])
    assert (coherent_bonds(shifted, side, SIZE) == bonds).all()


def test_scattered_spheres_are_not_crystalline():
    position = scattered_positions(256, 5 * SIZE, 10 * SIZE)
    assert crystalline_share(position, np.full(256, True), 5 * SIZE, SIZE) < 0.05


def test_share_is_of_the_chosen_spheres():
    position, side = crystal(4, 4)
    above = scattered_positions(256, side, 6 * SIZE) + np.array([0, 0, 8 * SIZE])
    mixed = np.vstack([position, above])
    lower = np.arange(len(mixed)) < len(position)
    assert crystalline_share(mixed, lower, side, SIZE) == 1.0
    assert crystalline_share(mixed, ~lower, side, SIZE) < 0.1
    assert np.isnan(crystalline_share(mixed, lower & ~lower, side, SIZE))


@pytest.mark.parametrize("spacing", [0.72, 0.82, 1.0])
def test_layers_of_any_spacing_are_found(spacing):
    heights = SIZE * spacing * np.repeat(np.arange(10), 30)
    assert layer_order(heights, SIZE) == pytest.approx(1.0, abs=1e-6)
    rng = np.random.default_rng(2)
    blurred = layer_order(heights + 0.1 * SIZE * rng.normal(size=300), SIZE)
    assert 0.6 < blurred < 1.0
    assert layer_order(rng.uniform(0, 10 * SIZE, 300), SIZE) < 0.2
