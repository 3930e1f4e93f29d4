"""The grid of cells, the neighbor list against all pairs, and what it carries over."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.engine.contact.friction import VECTOR
from sim.engine.dynamics import neighbors
from sim.engine.dynamics.cells import LIST_FULL, NOT_FINITE, OK, make_box
from sim.engine.dynamics.neighbors import double_room, empty_pair_list
from tests.engine_motion.helpers import all_pairs, compiled, listed_pairs, pair_names

refresh = compiled(neighbors.refresh)

UNIT = 1e-3

#: Numbers that a contact keeps here.
MEMORY = 7


class Gas:
    """Particles and their neighbor list; ``label`` (1, N) says where each was at the start.

    ``position`` (D, N) and ``radius`` (N,) follow the order of the list.
    """

    def __init__(self, position, radius, length, skin: float, room: int = 80):
        self.length, self.box = length, make_box(*length[:-1])
        self.position, self.radius = np.array(position.T, order="C"), radius.copy()
        self.label = np.arange(len(radius)).reshape(1, -1)
        self.pairs = empty_pair_list(radius, self.box, skin, room)
        self.memory = np.zeros((MEMORY, len(self.pairs.touching)))

    def rebuild(self) -> bool:
        """Wrap the particles and build the list anew; return whether there was room."""
        return self.refresh() == OK

    def refresh(self) -> int:
        """Do what the loop over steps does when the list no longer holds; return its status."""
        status, order = refresh(self.pairs, self.position, self.radius, self.memory)
        if status == OK:
            self.adopt(order)
        return status

    def adopt(self, order) -> None:
        """Bring radii and labels into the order of the list."""
        self.radius, self.label = self.radius[order], self.label[:, order]

    def names(self) -> list[tuple[int, int]]:
        """The listed pairs by the labels of their partners, in the order of the list."""
        return pair_names(self.pairs, self.label)

    def listed(self) -> set[tuple[int, int]]:
        """The listed pairs by label."""
        return listed_pairs(self.pairs, self.label)

    def expected(self) -> set[tuple[int, int]]:
        """Every pair within reach plus skin, from all distances."""
        place = np.argsort(self.label[0])
        radius = self.radius[place]
        reach = np.add.outer(radius, radius) + self.pairs.skin
        return all_pairs(self.position.T[place], reach, self.length)


def random_gas(rng, number: int, length, height: float, spread: float):
    """Random positions, unwrapped by up to three periods, and radii of a polydisperse gas."""
    extent = np.array([*length[:-1], height])
    position = rng.random((number, len(length))) * extent
    position[:, :-1] += rng.integers(-3, 4, (number, len(length) - 1)) * extent[:-1]
    return position, 0.5 * UNIT * rng.uniform(1 - spread, 1 + spread, number)


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
    gas.pairs.drift[:], gas.pairs.clock[:] = 1.0, 7.0
    assert not gas.pairs.valid[0] and gas.rebuild() and gas.pairs.valid[0]
    assert not gas.pairs.drift.any() and gas.pairs.clock[0] == 0.0
    assert (gas.position[:-1].T >= 0).all() and (length[:-1] >= gas.position[:-1].T).all()
    assert gas.listed() == gas.expected()
    number = gas.pairs.start[-1]
    first, second = gas.pairs.first[:number], gas.pairs.second[:number]
    assert np.array_equal(gas.pairs.reach[:number], gas.radius[first] + gas.radius[second])
    assert np.array_equal(gas.radius, start[1][gas.label[0]])


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


def test_refreshing_reports_what_is_not_finite_and_what_has_no_room():
    length = (4e-3, 4e-3, 0.0)
    start = random_gas(np.random.default_rng(2), 100, length, 2e-3, 0.0)
    tight = Gas(*start, length, 0.3 * UNIT, room=0)
    assert tight.refresh() == LIST_FULL
    for bad in (np.nan, np.inf):
        tight.position[1, 7] = bad
        assert tight.refresh() == NOT_FINITE and not tight.pairs.valid[0]
