"""The contacts of every step of the real loops against all pairs: no list may miss one."""

from itertools import product

import numpy as np
import pytest

from sim.engine.dynamics.disks import Gear, Verlet
from sim.engine.systems import shaking
from tests.engine_motion.disks import DiskMotion
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_MASS,
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


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("skin", [0.1, 0.5])
def test_no_contact_of_two_beams_that_meet_head_on_is_missed(skin, seed):
    """All use up their half of the skin at the same time, which is the worst that may happen."""
    rng = np.random.default_rng(seed)
    position = lattice((5, 4, 3), 2.7 * RADIUS, 0.1, rng, FAR)
    velocity = np.zeros_like(position)
    velocity[:, 0] = 0.5 + 0.3 * rng.choice([-1.0, 1.0], len(position))
    box = (5 * 2.7 * RADIUS, 4 * 2.7 * RADIUS)
    motion = SphereMotion(position, velocity, box=box, skin=skin * SIZE, room=30)
    met_pairs, _, list_count = follow_spheres(motion, np.full(len(position), RADIUS), 500)
    assert len(met_pairs) > 30
    assert list_count > 5


def follow_beads(motion: DiskMotion, radius, steps: int) -> tuple[set, int]:
    """Advance step by step; return who met and the number of lists.

    Forces act where the predictor puts the beads, so this is where contacts are looked for.
    """
    terms = 6 if isinstance(motion.integrator, Gear) else 3
    reach, met_pairs, list_count, last = np.add.outer(radius, radius), set(), 0, None
    for _ in range(steps):
        predicted = motion.taylor[:terms].sum(axis=0)
        motion.loop.sums[:] = 0.0
        motion.run(1)
        touching = all_pairs(predicted, reach, motion.length)
        assert motion.loop.sums[shaking.CONTACTS] == 2 * len(touching)
        assert touching <= listed_pairs(motion.pairs, motion.disks.label)
        met_pairs |= touching
        list_count += last is None or not np.array_equal(last, motion.pairs.anchor)
        last = motion.pairs.anchor.copy()
    return met_pairs, list_count


def crowd(seed: int, spacing: float, kind: str, integrator, skin: float):
    """Beads far above the belt, in layers of one speed each or in two beams, and their radii."""
    rng, shape = np.random.default_rng(seed), (8, 7)
    position = lattice(shape, spacing * BEAD, 0.1, rng, 40 * BEAD)
    radius = 0.5 * BEAD * rng.uniform(0.5, 1.3, len(position))
    velocity = rng.normal(0, 0.1 if kind == "layers" else 0.0, position.shape)
    layer = rng.uniform(-1, 1, shape[1])[np.arange(len(position)) % shape[1]]
    beam = rng.choice([-1.0, 1.0], len(position))
    velocity[:, 0] += 0.5 + 0.3 * (layer if kind == "layers" else beam)
    options = {"radius": radius, "mass": BEAD_MASS * (2 * radius / BEAD) ** 2}
    options |= {"integrator": integrator, "skin": skin * BEAD, "width": shape[0] * spacing * BEAD}
    return DiskMotion(position, velocity, **options), radius


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("integrator", [Gear, Verlet])
@pytest.mark.parametrize(("kind", "spacing"), [("layers", 1.0), ("beams", 1.4)])
@pytest.mark.parametrize("skin", [0.1, 0.3])
def test_no_contact_of_the_beads_is_missed(skin, kind, spacing, integrator, seed):
    met_pairs, list_count = follow_beads(*crowd(seed, spacing, kind, integrator, skin), steps=500)
    assert len(met_pairs) > 50
    assert 3 < list_count < 300
