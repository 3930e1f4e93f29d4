"""The grid of cells, the neighbor list against all pairs, and what it carries over."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.engine.contact.friction import VECTOR
from sim.engine.dynamics import cells
from sim.engine.dynamics.cells import LIST_FULL, NOT_FINITE, OK, make_box, reorder, sort_by_cell
from sim.engine.dynamics.neighbors import double_room
from tests.engine_motion.helpers import compiled, nearest_images, wrapped
from tests.engine_motion.lists import UNIT, Gas, random_gas

wrap, assign_cells = compiled(cells.wrap), compiled(cells.assign_cells)


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


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    dimension=st.sampled_from([2, 3]),
    number=st.integers(1, 120),
    width=st.floats(3.0, 12.0),
    aspect=st.floats(1.0, 1.7),
    height=st.floats(0.1, 30.0),
    spread=st.floats(0.0, 0.5),
    skin=st.floats(0.0, 0.4),
    seed=st.integers(0, 2**32 - 1),
)
def test_list_holds_exactly_the_pairs_within_reach(
    dimension, number, width, aspect, height, spread, skin, seed
):
    """Gases in boxes down to three diameters, thin layers and columns, across every boundary."""
    width = max(width, 2 * (1 + spread + skin))
    length = (width * UNIT, 0.0) if dimension == 2 else (width * UNIT, aspect * width * UNIT, 0.0)
    start = random_gas(np.random.default_rng(seed), number, length, height * UNIT, spread)
    gas = Gas(*start, length, skin * UNIT, room=130)
    assert gas.rebuild()
    assert gas.listed() == gas.expected()
    number = gas.pairs.start[-1]
    first, second = gas.pairs.first[:number], gas.pairs.second[:number]
    assert np.array_equal(gas.pairs.reach[:number], gas.radius[first] + gas.radius[second])
    assert np.array_equal(gas.radius, start[1][gas.label[0]])


@pytest.mark.parametrize("length", [(5e-3, 0.0), (5e-3, 4e-3, 0.0)])
def test_particles_far_above_and_below_the_others_are_found_too(length):
    """A few that fly a thousand diameters off must neither be lost nor cost a cell each."""
    rng = np.random.default_rng(1)
    position, radius = random_gas(rng, 200, length, 6 * UNIT, 0.3)
    position[:20, -1] += 1.0
    position[20:25, -1] -= 0.3
    position[25:27] = [[1e-3] * len(length), [1.2e-3] * len(length)]
    position[25:27, -1] += 40.0
    gas = Gas(position, radius, length, 0.2 * UNIT)
    assert gas.rebuild()
    assert gas.listed() == gas.expected()
    assert (25, 26) in gas.listed()


@pytest.mark.parametrize("length", [(4e-3, 0.0), (4e-3, 4e-3, 0.0)])
def test_one_and_two_particles(length):
    one = np.full((1, len(length)), 0.1 * UNIT)
    one_gas = Gas(one, np.array([0.5 * UNIT]), length, 0.3 * UNIT)
    assert one_gas.rebuild() and one_gas.listed() == set()
    two = np.concatenate([one, one])
    two[1, 0] += 4e-3 - 1.2 * UNIT
    for skin, expected in ((0.3, {(0, 1)}), (0.1, set())):
        pair = Gas(two, np.full(2, 0.5 * UNIT), length, skin * UNIT)
        assert pair.rebuild() and pair.listed() == expected


def test_memory_goes_with_the_pairs_that_touched_last_and_with_no_others():
    """Its first three numbers are a force on the first partner: they follow the partners' order."""
    rng = np.random.default_rng(5)
    length = (6e-3, 6e-3, 0.0)
    gas = Gas(*random_gas(rng, 150, length, 5 * UNIT, 0.2), length, 0.3 * UNIT)
    assert gas.rebuild()
    names, slot = gas.names(), gas.pairs.slot
    is_touching = rng.random(len(names)) < 0.4
    slot[: len(names)] = np.where(is_touching, rng.permutation(len(names)), -1)
    gas.memory[:] = rng.random(gas.memory.shape)
    old_memories = {
        name: gas.memory[:, slot[k]].copy() for k, name in enumerate(names) if is_touching[k]
    }
    turned_memories = {
        (j, i): np.where(np.arange(len(m)) < VECTOR, -m, m) for (i, j), m in old_memories.items()
    }
    gas.position += rng.normal(0, 0.05 * UNIT, gas.position.shape)
    assert gas.rebuild()
    kept_count = swapped_count = 0
    for name, place in zip(gas.names(), gas.pairs.slot, strict=False):
        if name in old_memories:
            assert np.array_equal(gas.memory[:, place], old_memories[name])
            kept_count += 1
        elif name in turned_memories:
            assert np.array_equal(gas.memory[:, place], turned_memories[name])
            swapped_count += 1
        else:
            assert place == -1
    assert kept_count > 50 and swapped_count > 5
    assert len(old_memories) > kept_count + swapped_count


def test_a_full_list_is_left_as_it_was_and_doubled_room_helps():
    rng = np.random.default_rng(6)
    length = (4e-3, 4e-3, 0.0)
    position, radius = random_gas(rng, 100, length, 4 * UNIT, 0.0)
    gas = Gas(position * [1, 1, 50], radius, length, 0.3 * UNIT, room=1)
    assert gas.rebuild()
    gas.pairs.slot[: gas.pairs.start[-1]] = np.arange(gas.pairs.start[-1])
    gas.position[2] /= 50
    old_memories = (
        gas.listed(),
        *(array.copy() for array in gas.pairs if isinstance(array, np.ndarray)),
    )
    place, memory = gas.position.copy(), gas.memory.copy()
    assert not gas.rebuild()
    assert gas.listed() == old_memories[0]
    arrays = (array for array in gas.pairs if isinstance(array, np.ndarray))
    for old, new in zip(old_memories[1:], arrays, strict=True):
        assert np.array_equal(old, new, equal_nan=True)
    assert np.array_equal(gas.position, place) and np.array_equal(gas.memory, memory)
    for _ in range(5):
        gas.pairs = double_room(gas.pairs)
    gas.pairs.slot[:] = -1
    assert gas.rebuild()
    assert gas.listed() == gas.expected()
    assert np.array_equal(gas.pairs.anchor, gas.position)


def test_refreshing_starts_the_count_of_steps_and_the_drift_anew():
    length = (4e-3, 4e-3, 0.0)
    gas = Gas(*random_gas(np.random.default_rng(2), 60, length, 4e-3, 0.1), length, 0.3 * UNIT)
    gas.pairs.drift[:], gas.pairs.clock[:] = 1.0, 7.0
    assert not gas.pairs.valid[0]
    assert gas.refresh() == OK and gas.pairs.valid[0]
    assert not gas.pairs.drift.any() and gas.pairs.clock[0] == 0.0
    assert (gas.position[:2] >= 0).all() and (gas.position[:2] <= 4e-3).all()
    assert gas.listed() == gas.expected()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_refreshing_reports_what_is_not_finite_and_what_has_no_room(bad):
    length = (4e-3, 4e-3, 0.0)
    start = random_gas(np.random.default_rng(2), 100, length, 2e-3, 0.0)
    tight = Gas(*start, length, 0.3 * UNIT, room=0)
    assert tight.refresh() == LIST_FULL
    tight.position[1, 7] = bad
    assert tight.refresh() == NOT_FINITE
    assert not tight.pairs.valid[0]
