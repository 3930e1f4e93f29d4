"""The contacts of every step of the real loops against all pairs: no list may miss one."""

from itertools import product

import numpy as np
import pytest

from tests.engine_motion.helpers import (
    MASS,
    RADIUS,
    all_pairs,
    lattice,
    listed_pairs,
)
from tests.engine_motion.spheres import SphereMotion

FAR = 40 * RADIUS
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
