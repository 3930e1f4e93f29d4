"""The neighbor list against all pairs, and what it carries over."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.dynamics.neighbors import STAMP, empty_pair_list, grown, make_box, rebuild, wrap
from tests.engine_helpers import wrapped

UNIT = 1e-3


def built(position, radius, box, skin, room: int = 80, step: int = 0):
    pairs = empty_pair_list(len(position), position.shape[1], skin, room)
    assert rebuild(pairs, position, radius, box, step)
    return pairs


def listed(pairs) -> set[tuple[int, int]]:
    """The pairs of a list; they come sorted by their first particle, which is the lower one."""
    number = pairs.start[-1]
    first, second = pairs.first[:number], pairs.second[:number]
    assert (first < second).all() and (np.diff(first) >= 0).all()
    for i in range(len(pairs.start) - 1):
        assert (first[pairs.start[i] : pairs.start[i + 1]] == i).all()
    found = set(zip(first.tolist(), second.tolist(), strict=True))
    assert len(found) == number
    return found


def all_pairs(position, radius, length, skin) -> set[tuple[int, int]]:
    """Every pair within reach plus skin, from all distances."""
    found = set()
    for i in range(len(position) - 1):
        apart = wrapped(position[i + 1 :] - position[i], *length)
        near = (apart**2).sum(axis=1) < (radius[i] + radius[i + 1 :] + skin) ** 2
        found |= {(i, i + 1 + int(k)) for k in np.flatnonzero(near)}
    return found


def gas(rng, number: int, length, height: float, spread: float):
    """Random positions, unwrapped by up to three periods, and radii of a polydisperse gas."""
    extent = np.array([*length[:-1], height])
    position = rng.random((number, len(length))) * extent
    position[:, :-1] += rng.integers(-3, 4, (number, len(length) - 1)) * extent[:-1]
    return position, 0.5 * UNIT * rng.uniform(1 - spread, 1 + spread, number)


@settings(max_examples=300, deadline=None, derandomize=True)
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
    position, radius = gas(np.random.default_rng(seed), number, length, height * UNIT, spread)
    box = make_box(*length)
    wrap(position, box)
    pairs = built(position, radius, box, skin * UNIT, room=130)
    assert listed(pairs) == all_pairs(position, radius, length, skin * UNIT)
    first, second = pairs.first[: pairs.start[-1]], pairs.second[: pairs.start[-1]]
    assert np.array_equal(pairs.reach[: pairs.start[-1]], radius[first] + radius[second])


@pytest.mark.parametrize("length", [(5e-3, 0.0), (5e-3, 4e-3, 0.0)])
def test_particles_far_above_and_below_the_others_are_found_too(length):
    """A few that fly a thousand diameters off must neither be lost nor cost a cell each."""
    rng = np.random.default_rng(1)
    position, radius = gas(rng, 200, length, 6 * UNIT, 0.3)
    position[:20, -1] += 1.0
    position[20:25, -1] -= 0.3
    position[25:27] = [[1e-3] * len(length), [1.2e-3] * len(length)]
    position[25:27, -1] += 40.0
    box = make_box(*length)
    wrap(position, box)
    found = listed(built(position, radius, box, 0.2 * UNIT))
    assert found == all_pairs(position, radius, length, 0.2 * UNIT)
    assert (25, 26) in found


@pytest.mark.parametrize("length", [(4e-3, 0.0), (4e-3, 4e-3, 0.0)])
def test_one_and_two_particles(length):
    box = make_box(*length)
    one = np.full((1, len(length)), 0.1 * UNIT)
    assert listed(built(one, np.array([0.5 * UNIT]), box, 0.3 * UNIT)) == set()
    two = np.concatenate([one, one])
    two[1, 0] += 4e-3 - 1.2 * UNIT
    radius = np.full(2, 0.5 * UNIT)
    assert listed(built(two, radius, box, 0.3 * UNIT)) == {(0, 1)}
    assert listed(built(two, radius, box, 0.1 * UNIT)) == set()


def test_wrapping_moves_by_whole_periods_into_the_cell():
    rng = np.random.default_rng(0)
    start = rng.uniform(-20, 20, (500, 3)) * UNIT
    moved = start.copy()
    wrap(moved, make_box(3e-3, 4e-3, 0.0))
    assert np.array_equal(moved[:, 2], start[:, 2])
    assert (moved[:, :2] >= 0).all() and (moved[:, :2] <= [3e-3, 4e-3]).all()
    laps = (start - moved)[:, :2] / [3e-3, 4e-3]
    assert laps == pytest.approx(np.round(laps), abs=1e-12)


def test_memory_goes_with_the_pairs_that_touched_last_and_with_no_others():
    rng = np.random.default_rng(5)
    length, box = (6e-3, 6e-3, 0.0), make_box(6e-3, 6e-3, 0.0)
    position, radius = gas(rng, 150, length, 5 * UNIT, 0.2)
    pairs = built(position, radius, box, 0.3 * UNIT)
    number = pairs.start[-1]
    pairs.memory[:number, :STAMP] = rng.random((number, STAMP))
    touched = rng.random(number) < 0.4
    pairs.memory[:number, STAMP] = np.where(touched, 17, 16)
    names = zip(pairs.first[:number].tolist(), pairs.second[:number].tolist(), strict=True)
    before = {name: pairs.memory[k].copy() for k, name in enumerate(names) if touched[k]}
    position += rng.normal(0, 0.05 * UNIT, position.shape)
    assert rebuild(pairs, position, radius, box, 17)
    kept = 0
    for k in range(pairs.start[-1]):
        name = int(pairs.first[k]), int(pairs.second[k])
        if name in before:
            assert np.array_equal(pairs.memory[k], before[name])
            kept += 1
        else:
            assert pairs.memory[k, STAMP] == -1.0
    assert kept > 50
    assert len(before) > kept


def test_a_full_list_is_left_as_it_was_and_doubled_room_helps():
    rng = np.random.default_rng(6)
    length, box = (4e-3, 4e-3, 0.0), make_box(4e-3, 4e-3, 0.0)
    position, radius = gas(rng, 100, length, 4 * UNIT, 0.0)
    pairs = empty_pair_list(100, 3, 0.3 * UNIT, 1)
    spread_out = position * [1, 1, 50]
    assert rebuild(pairs, spread_out, radius, box, 0)
    before = listed(pairs), pairs.memory.copy(), pairs.anchor.copy()
    assert not rebuild(pairs, position, radius, box, 0)
    assert listed(pairs) == before[0]
    assert np.array_equal(pairs.memory, before[1]) and np.array_equal(pairs.anchor, before[2])
    for _ in range(5):
        pairs = grown(pairs)
    assert rebuild(pairs, position, radius, box, 0)
    assert listed(pairs) == all_pairs(position, radius, length, 0.3 * UNIT)
    assert np.array_equal(pairs.anchor, position)
