"""The grid of cells: images, wrapping, counting sort."""

import numpy as np
import pytest

from sim.engine.dynamics import cells as engine
from sim.engine.dynamics.cells import make_box, reorder, sort_by_cell
from tests.engine_motion.helpers import compiled, nearest_images, wrapped
from tests.engine_motion.lists import UNIT, random_gas

wrap, assign_cells = compiled(engine.wrap), compiled(engine.assign_cells)


@pytest.mark.parametrize("length", [(3e-3, 0.0), (3e-3, 4e-3, 0.0)])
def test_nearest_images_are_shortest_and_the_last_direction_is_open(length):
    rng = np.random.default_rng(3)
    differences = rng.uniform(-20, 20, (len(length), 500)) * UNIT
    images = nearest_images(differences, make_box(*length[:-1]))
    expected = wrapped(differences.T, *length).T
    assert images == pytest.approx(expected, abs=1e-12 * UNIT)
    assert np.array_equal(images[-1], differences[-1])


def test_wrapping_moves_by_whole_periods_into_the_cell():
    rng = np.random.default_rng(0)
    start = rng.uniform(-20, 20, (3, 500)) * UNIT
    moved = start.copy()
    wrap(moved, make_box(3e-3, 4e-3))
    period = np.array([[3e-3], [4e-3]])
    assert np.array_equal(moved[2], start[2])
    assert (moved[:2] >= 0).all() and (moved[:2] <= period).all()
    laps = (start - moved)[:2] / period
    assert laps == pytest.approx(np.round(laps), abs=1e-12)


@pytest.mark.parametrize("length", [(5e-3, 0.0), (5e-3, 4e-3, 0.0)])
def test_cells_are_counted_by_column_and_no_smaller_than_asked_for(length):
    """The open direction comes last, so that the cells above each other follow each other."""
    rng, size = np.random.default_rng(4), 1.3 * UNIT
    place = random_gas(rng, 300, length, 6 * UNIT, 0.0)[0].T.copy()
    box, cells = make_box(*length[:-1]), np.zeros(len(length), np.int64)
    wrap(place, box)
    cell = assign_cells(place, box, size, cells)
    widths = np.array([*(np.array(length[:-1]) / cells[:-1]), size])
    assert (widths >= size).all()
    place[-1] -= place[-1].min()
    index = np.floor(place / widths[:, None]).astype(int)
    assert np.array_equal(cell, np.ravel_multi_index(tuple(index), tuple(cells)))


def test_sorting_by_cell_is_a_stable_sort():
    rng = np.random.default_rng(5)
    cell = rng.integers(0, 40, 500)
    order, begin = sort_by_cell(cell, np.array([41]))
    assert np.array_equal(order, np.argsort(cell, kind="stable"))
    assert np.array_equal(begin, np.searchsorted(np.sort(cell), np.arange(42)))


def test_reordering_takes_all_rows_along_and_leaves_what_is_empty_alone():
    rng = np.random.default_rng(6)
    order, array = rng.permutation(50), rng.random((4, 50))
    expected = array[:, order]
    reorder(array, order)
    assert np.array_equal(array, expected)
    reorder(np.empty((4, 0)), order)
