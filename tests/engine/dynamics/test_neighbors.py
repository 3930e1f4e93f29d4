"""The neighbor list against all pairs, what it carries over, and how long it holds in a flow."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.engine.dynamics.cells import LIST_FULL, NOT_FINITE, OK, make_box
from sim.engine.dynamics.mean_flow import AGE, SLOPE, allowed_stray, set_stream
from sim.engine.dynamics.neighbors import Bond, empty_pair_list
from tests.engine_motion.helpers import (
    MASS,
    RADIUS,
    all_pairs,
    lattice,
    listed_pairs,
    pair_names,
)
from tests.engine_motion.motion import DiskMotion, SphereMotion

UNIT = 1e-3


class Gas:
    """Particles and their neighbor list, which the kernel of spheres or of beads rebuilds.

    ``position`` (D, N), ``radius`` (N,) and ``label`` (1, N), which says where each was at the
    start, follow the order of the list; of spheres ``memory`` (7, C) is that of contacts.
    """

    def __init__(self, position, radius, length, skin: float, room: int = 80, beyond: float = 0.0):
        self.length, self.beyond, still = length, beyond, np.zeros_like(position)
        options = {"radius": radius, "skin": skin, "room": room}
        if len(length) == 2:
            self.motion = DiskMotion(position, still, width=length[0], **options)
            particles, self.position = self.motion.disks, self.motion.disks.taylor[0]
        else:
            self.motion = SphereMotion(position, still, box=length[:2], reach=beyond, **options)
            particles, self.position = self.motion.spheres, self.motion.spheres.position
            self.memory = self.motion.memory[0]
        self.radius, self.label = particles.radius, particles.label

    @property
    def pairs(self):
        """The list."""
        return self.motion.pairs

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
        reach = np.add.outer(radius, radius) + self.pairs.skin + self.beyond
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
    beyond=st.floats(0.0, 0.3),
    seed=st.integers(0, 2**32 - 1),
)
def test_list_holds_exactly_the_pairs_within_reach(
    dimension, number, width, aspect, height, spread, skin, beyond, seed
):
    """Gases in boxes down to three diameters, thin layers and columns, across every boundary.

    The law of spheres may reach beyond contact.
    """
    beyond *= dimension == 3
    width = max(width, 2 * (1 + spread + skin + beyond))
    length = (width * UNIT, 0.0) if dimension == 2 else (width * UNIT, aspect * width * UNIT, 0.0)
    start = random_gas(np.random.default_rng(seed), number, length, height * UNIT, spread)
    gas = Gas(*start, length, skin * UNIT, room=130, beyond=beyond * UNIT)
    gas.pairs.drift[:], gas.pairs.clock[:] = 1.0, 7.0
    assert not gas.pairs.valid[0] and gas.motion.refresh() == OK and gas.pairs.valid[0]
    assert not gas.pairs.drift.any() and gas.pairs.clock[0] == 0.0
    assert (gas.position[:-1].T >= 0).all() and (length[:-1] >= gas.position[:-1].T).all()
    assert gas.listed() == gas.expected()
    number = gas.pairs.start[-1]
    first, second = gas.pairs.first[:number], gas.pairs.second[:number]
    assert np.array_equal(gas.pairs.reach[:number], gas.radius[first] + gas.radius[second])
    assert np.array_equal(gas.radius, start[1][gas.label[0]])


@pytest.mark.parametrize("turning", [3, 6])
def test_memory_goes_with_the_pairs_that_touched_last_and_with_no_others(turning):
    """Its first numbers are vectors as the force on the first partner: they follow the order."""
    rng = np.random.default_rng(5)
    length = (6e-3, 6e-3, 0.0)
    gas = Gas(*random_gas(rng, 150, length, 5 * UNIT, 0.2), length, 0.3 * UNIT)
    gas.motion.bond = Bond(turning, 0.0)
    assert gas.motion.refresh() == OK
    names, slot = gas.names(), gas.pairs.slot
    is_touching = rng.random(len(names)) < 0.4
    slot[: len(names)] = np.where(is_touching, rng.permutation(len(names)), -1)
    gas.memory[:] = rng.random(gas.memory.shape)
    old_memories = {
        name: gas.memory[:, slot[k]].copy() for k, name in enumerate(names) if is_touching[k]
    }
    turned_memories = {
        (j, i): np.where(np.arange(len(m)) < turning, -m, m) for (i, j), m in old_memories.items()
    }
    gas.position += rng.normal(0, 0.05 * UNIT, gas.position.shape)
    assert gas.motion.refresh() == OK
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
    assert gas.motion.refresh() == OK
    gas.pairs.slot[: gas.pairs.start[-1]] = np.arange(gas.pairs.start[-1])
    gas.position[2] /= 50
    old_memories = (
        gas.listed(),
        *(array.copy() for array in gas.pairs if isinstance(array, np.ndarray)),
    )
    place, memory = gas.position.copy(), gas.memory.copy()
    assert gas.motion.refresh() != OK
    assert gas.listed() == old_memories[0]
    arrays = (array for array in gas.pairs if isinstance(array, np.ndarray))
    for old, new in zip(old_memories[1:], arrays, strict=True):
        assert np.array_equal(old, new, equal_nan=True)
    assert np.array_equal(gas.position, place) and np.array_equal(gas.memory, memory)
    for _ in range(5):
        gas.motion.make_room()
    gas.pairs.slot[:] = -1
    assert gas.motion.refresh() == OK
    assert gas.listed() == gas.expected()
    assert np.array_equal(gas.pairs.anchor, gas.position)


def test_refreshing_reports_what_is_not_finite_and_what_has_no_room():
    length = (4e-3, 4e-3, 0.0)
    start = random_gas(np.random.default_rng(2), 100, length, 2e-3, 0.0)
    tight = Gas(*start, length, 0.3 * UNIT, room=0)
    assert tight.motion.refresh() == LIST_FULL
    for bad in (np.nan, np.inf):
        tight.position[1, 7] = bad
        assert tight.motion.refresh() == NOT_FINITE and not tight.pairs.valid[0]


FAR = 40 * RADIUS
BOX = make_box(FAR, FAR)


def shortening(strain):
    """The factor by which a shear shortens a distance at most."""
    return np.sqrt(1 + strain**2 / 4) - strain / 2


@pytest.mark.parametrize(("slope", "age"), [(0.0, 500), (300.0, 0), (300.0, 100), (-50.0, 300)])
def test_allowed_stray_is_half_of_what_the_shear_leaves_beyond_the_reach(slope, age):
    radius, skin, step = RADIUS * np.array([0.7, 1.2, 1.0]), 0.4e-3, 5e-6
    pairs = empty_pair_list(radius, BOX, skin)
    pairs.clock[AGE], pairs.clock[SLOPE] = age, abs(slope)
    reach, factor = 2.4 * RADIUS, shortening(abs(slope) * age * step)
    expected = 0.5 * ((reach + skin) * factor - reach)
    assert expected > 0.0
    assert allowed_stray(pairs, step) == pytest.approx(expected, rel=1e-12)
    pairs.clock[AGE], pairs.clock[SLOPE] = 2000, 1000.0
    assert allowed_stray(pairs, step) == 0.0


def list_with_stream(height, speed):
    """The list of spheres at these heights and speeds once it knows their flow."""
    pairs = empty_pair_list(np.full(len(height), RADIUS), BOX, 0.2 * RADIUS)
    set_stream(pairs, height, speed)
    return pairs


def test_stream_of_a_linear_profile_is_that_profile_relative_to_its_mean():
    height = np.random.default_rng(2).uniform(0, 10 * 2 * RADIUS, 500)
    speed = 0.3 + 40.0 * height
    pairs = list_with_stream(height, speed)
    assert pairs.clock[SLOPE] == pytest.approx(40.0, rel=1e-9)
    inside = (height > 2 * RADIUS) & (height < 9 * 2 * RADIUS)
    expected = speed - speed.mean()
    assert pairs.stream[inside] == pytest.approx(expected[inside], abs=1e-12)
    assert np.abs(pairs.stream - expected).max() < 40.0 * 2 * RADIUS


@pytest.mark.parametrize("seed", range(2))
def test_stream_differs_between_two_heights_by_no_more_than_the_slope_allows(seed):
    """What the shear of the whole list stands for, in flows as irregular as one likes."""
    rng = np.random.default_rng(seed)
    height = rng.exponential(4 * RADIUS, 200) + FAR * (rng.random(200) < 0.05)
    pairs = list_with_stream(height, rng.normal(0, 0.3, 200) + np.sin(height / RADIUS))
    assert pairs.stream.any()
    height_differences = np.abs(np.subtract.outer(height, height))
    stream_differences = np.abs(np.subtract.outer(pairs.stream, pairs.stream))
    assert (stream_differences <= pairs.clock[SLOPE] * height_differences + 1e-12).all()


SIZE = 2 * RADIUS

#: Every step is looked at, which takes long.
SEEDS = [0, pytest.param(1, marks=pytest.mark.long)]


def follow_spheres(motion: SphereMotion, radius, steps: int) -> tuple[set, int, int]:
    """Advance step by step; return who met, how often a list outlived its plain skin, and lists.

    Without a mean flow a list would be given up once a sphere has strayed half a skin from the mean
    displacement of all.
    """
    reach, met_pairs, outlived_steps = np.add.outer(radius, radius), set(), 0
    list_count, last, listed = 0, None, set()
    for _ in range(steps):
        place = motion.position
        motion.run(1)
        i, j, _, _ = motion.contacts()
        touching = all_pairs(place, reach, motion.length)
        assert (
            set(zip(np.minimum(i, j).tolist(), np.maximum(i, j).tolist(), strict=True)) == touching
        )
        if last is None or not np.array_equal(last, motion.pairs.anchor):
            listed = listed_pairs(motion.pairs, motion.spheres.label)
            last, list_count = motion.pairs.anchor.copy(), list_count + 1
        assert touching <= listed
        met_pairs |= touching
        displacement = motion.spheres.position - motion.pairs.anchor
        largest_stray = np.linalg.norm(
            displacement - displacement.mean(axis=1)[:, None], axis=0
        ).max()
        outlived_steps += motion.pairs.valid[0] and largest_stray > 0.5 * motion.pairs.skin
    return met_pairs, outlived_steps, list_count


def profile(kind: str, height):
    """Speed over height (in units of the particle): one that shears, turns round, or jumps."""
    return {"linear": height, "wavy": 2 * np.sin(height), "split": 2 * np.sign(height - 2.0)}[kind]


#: Skin, agitation and threads of flows.
LISTS = [(0.1, 0.02, 1), (0.3, 0.1, 2), (0.8, 0.02, 1)]
KINDS = ["linear", "wavy", "split"]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("kind", "skin", "agitation", "threads"),
    [
        pytest.param(kind, *lists, marks=[pytest.mark.long] * (KINDS.index(kind) != number))
        for kind, (number, lists) in product(KINDS, enumerate(LISTS))
    ],
)
def test_no_contact_of_a_dense_sheared_flow_is_missed(skin, agitation, threads, kind, seed):
    rng = np.random.default_rng(seed)
    shape, spacing = (5, 4, 4), 2.1 * RADIUS
    position = lattice(shape, spacing, 0.03, rng, FAR)
    radius = RADIUS * rng.uniform(0.9, 1.1, len(position))
    velocity = rng.normal(0, agitation, position.shape)
    velocity[:, 0] += 1.0 + 0.3 * profile(kind, (position[:, 2] - FAR) / spacing)
    box = tuple(max(spacing * n, (2.2 + 2 * skin) * SIZE) for n in shape[:2])
    options = {"box": box, "radius": radius, "mass": MASS * (radius / RADIUS) ** 3}
    options |= {"skin": skin * SIZE, "room": 40, "threads": threads}
    met_pairs, outlived_steps, list_count = follow_spheres(
        SphereMotion(position, velocity, **options), radius, 500
    )
    assert len(met_pairs) > 70
    assert outlived_steps > 10
    assert 2 < list_count < 400


@pytest.mark.parametrize("seed", SEEDS)
def test_no_contact_is_missed_where_the_mean_flow_alone_brings_spheres_together(seed):
    """Sparse rows that slide over each other, closer than a diameter: nothing strays at all.

    Spheres of two rows are out of each other's list at first, and only the shear makes them meet.
    Two rows apart from the others let the profile reach the ends of the flow.
    """
    rng = np.random.default_rng(seed)
    x, y, row = (index.ravel() for index in np.indices((4, 3, 6)))
    shift = rng.uniform(0.4, 0.6, 6).cumsum()
    height = np.array([0.0, 4.0, 5.8, 7.6, 9.4, 13.4])
    position = RADIUS * np.stack([4.5 * (x + shift[row]), 3.0 * y, height[row]], axis=1)
    position[:, 2] += FAR
    velocity = np.zeros_like(position)
    velocity[:, 0] = rng.choice([-200.0, 200.0]) * (position[:, 2] - position[:, 2].mean())
    box = (4 * 4.5 * RADIUS, 3 * 3 * RADIUS)
    motion = SphereMotion(position, velocity, box=box, skin=0.2 * SIZE)
    met_pairs, outlived_steps, _ = follow_spheres(motion, np.full(len(position), RADIUS), 1200)
    assert len(met_pairs) > 20
    assert outlived_steps > 20
