"""Random initial positions, and controls that claims need: unequal spheres, a bumpy plane, beds
shaken or pushed before.
"""

from typing import get_args

import numpy as np
import pytest

from sim.engine.dynamics.cells import BlowUp, make_box
from sim.engine.states import flatten
from sim.engine.systems import belt, build, start
from sim.engine.systems.packed_base import MAX_OVERLAP, random_close_packing
from sim.engine.systems.start import random_packing
from sim.parameters import BeltParameters
from sim.parameters.images import PACKING, SLICE, TOP
from tests.engine_motion.helpers import wrapped
from tests.engine_motion.points import belt_point, chute_point, energy_residual

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
    flat = random_packing(make_box(*length[:-1]), 0.0, radius[:1], rng)
    assert flat[0, -1] == radius[0]


BUMPY = {"cell": 5, "depth": 2, "bumps": 0.8}
UNEQUAL = {"cell": 5, "depth": 2, "diameter_spread": 0.2}
SMALL = {"beads": 40, "width": 8}


def test_unequal_spheres_weigh_as_much_as_equal_ones():
    system = build(chute_point(**UNEQUAL), 0)
    p, spheres = system.parameters, system.spheres
    size = spheres.radius / (0.5 * p.diameter)
    assert spheres.mass == pytest.approx(p.mass * size**3, rel=1e-12)
    assert spheres.mass.mean() == pytest.approx(p.mass, rel=1e-12)
    assert 0.75 < size.min() < 0.9 and 1.1 < size.max() < 1.25
    assert p.time_step < 0.75 * chute_point(cell=5, depth=2).time_step


@pytest.mark.parametrize("values", [UNEQUAL, BUMPY | UNEQUAL])
def test_the_plane_and_what_is_glued_to_it_take_up_the_momentum(values):
    """Weight and base forces change the momentum of the flow, and nothing else does."""
    system = build(chute_point(**values), 0)
    spheres = system.spheres
    before = spheres.velocity @ spheres.mass
    rows = [system.advance() for _ in range(60)]
    time = 60 * system.sample_steps * system.time_step
    shear = np.mean([row["base_shear_force"] for row in rows])
    normal = np.mean([row["base_normal_force"] for row in rows])
    force = np.array([system.weight[0] - shear, normal - system.weight[1]])
    change = (spheres.velocity @ spheres.mass - before)[[0, 2]]
    assert force * time == pytest.approx(change, abs=1e-10 * np.hypot(*system.weight) * time)
    series = {name: np.array([row[name] for row in rows]) for name in system.series}
    assert abs(energy_residual(series, system.ledger)) < 1e-3


def test_glued_spheres_lie_on_the_plane_and_stay():
    system = build(chute_point(**BUMPY), 0)
    start = system.snapshot()
    glued = start["fixed"] == 1
    p = system.parameters
    assert glued.sum() == round(0.4 * 25 / (np.pi / 4 * 0.64)) and (~glued).sum() == p.particles
    assert start["position"][glued, 2] == pytest.approx(0.4 * p.diameter, rel=1e-12)
    assert start["position"][~glued, 2].min() >= 1.3 * p.diameter
    places = start["position"][glued]
    for i in range(len(places) - 1):
        apart = wrapped(places[i + 1 :] - places[i], 5 * p.diameter, 5 * p.diameter, 0.0)
        assert np.linalg.norm(apart, axis=1).min() >= 0.8 * p.diameter
    for _ in range(40):
        system.advance()
    end = system.snapshot()
    assert np.array_equal(end["position"][glued], start["position"][glued])
    assert not end["particle_velocity"][glued].any() and not end["particle_spin"][glued].any()
    assert (end["position"][~glued] != start["position"][~glued]).all()


def test_ordered_bumps_lie_on_a_lattice():
    """Also where the whole lattice that comes nearest would overlap."""
    square = [((side, side), bumps, (n, n)) for side, bumps, n in ((5, 0.8, 5), (6, 3, 2))]
    for cell, bumps, rows in (*square, ((5.94, 5.94), 3, (1, 1)), ((9, 4.5), 0.8, (9, 4))):
        values = {"depth": 1, "bumps": bumps, "bump_coverage": 0.45}
        system = build(chute_point(cell=[*cell], bump_arrangement="ordered", **values), 0)
        start, p = system.snapshot(), system.parameters
        places = start["position"][start["fixed"] == 1] / p.diameter
        assert len(places) == p.glued_particles == rows[0] * rows[1]
        assert places[:, 2] == pytest.approx(bumps / 2)
        along, across = (
            side * (np.arange(n) + 0.5) / n for side, n in zip(cell, rows, strict=True)
        )
        lattice = [(x, y) for x in along for y in across]
        assert np.allclose(sorted(map(tuple, places[:, :2].round(9))), lattice)
        assert min(np.divide(cell, rows)) >= bumps


def test_a_bed_shaken_or_pushed_before_starts_in_motion():
    """At phase zero it moves forwards, faster than the mean of the cycle to come; in four beds."""
    p = belt_point(**SMALL, frequency=17, prior_frequency=30, prior_cycles=20)
    starts, means = [], []
    for replicate in range(4):
        system = build(p, replicate)
        system.settle()
        starts.append(system._velocity()[0].mean())
        assert system.loop.step[0] == 0 and system.disks.taylor[0, 1].min() > -0.5 * p.diameter
        means.append(np.mean([system.advance()["mean_velocity"] for _ in range(20)]))
    assert p.samples_per_cycle == 20 and min(starts) > 0.02 * p.velocity_amplitude
    assert 0.3 < np.mean(means) / np.mean(starts) < 1
    still, pushed = (build(belt_point(**SMALL, initial_velocity=v), 0) for v in (0, 3))
    for system in (still, pushed):
        system.settle()
    gained = pushed._velocity() - still._velocity()
    assert gained[0] == pytest.approx(3 * pushed.parameters.velocity_unit, rel=1e-9)
    assert not gained[1].any()


TINY = {"beads": 6, "width": 8.0, "settle_velocity_squared": 1e-4, "prior_cycles": 1}

#: Other values where three quarters of the usual one is none.
OTHER = {"corrector_order": 4, "corrections": 2, "prior_frequency": 30.0, "samples_per_cycle": 10}
OTHER |= dict.fromkeys(("obstacle", "initial_velocity", "trajectory", "phase"), 1.5)
OTHER |= dict.fromkeys(("seed", "replicates", "prior_cycles", "slice_height"), 2)

#: What a point has beside the parameter that it changes; only laws that golden points have, too.
REDUCED = {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"}
BESIDE = {"ghost_mass": REDUCED, "stiffness_keeps": {"stiffness": 500.0}}
BESIDE |= {"trajectory_contacts": {"trajectory": 1.5}}

#: Parameters that the bed does not know, as their effect begins with the shaking.
SHAKING = {"frequency", "vibration_angle", "initial_velocity", "prior_frequency", "prior_cycles"}
SHAKING |= {"steps_per_cycle", "samples_per_cycle", "slice_height", "transient", "average", "limit"}
SHAKING |= {"phase_0_profiles", "fluctuation_profiles", "belt_forces", "trajectory"}
SHAKING |= {"protocol", "target", "replicates", "trajectory_contacts"}

#: Parameters that need no bed, or give another start.
STARTS = {"system", "start_from", "initial_state"}

NAMES = BeltParameters.model_fields.keys() - STARTS - REDUCED.keys()


@pytest.fixture(autouse=True)
def _no_beds():
    start.beds.clear()


def other_value(name):
    """Return a value of a parameter that its points usually do not have."""
    field = BeltParameters.model_fields[name]
    usual = TINY.get(name, field.default)
    if choices := get_args(field.annotation):
        return next(choice for choice in choices if choice != usual)
    if isinstance(usual, bool):
        return not usual
    return OTHER.get(name) or type(usual)(0.75 * usual)


def settled_state(**values):
    """Return all that moves in a point, by name, when the shaking starts."""
    system = build(belt_point(**TINY | values), 0)
    system.settle()
    return flatten({name: getattr(system, name) for name in system.state_names})


@pytest.mark.parametrize("name", sorted({*NAMES, "reduced"}))
def test_a_bed_is_shared_where_it_would_be_the_same_to_the_bit(name):
    beside = BESIDE.get(name, {})
    changed = REDUCED if name == "reduced" else beside | {name: other_value(name)}
    anew = settled_state(**changed)
    start.beds.clear()
    first = settled_state(**beside)
    for values, expected in ((changed, anew), (beside, first)):
        state = settled_state(**values)
        assert state.keys() == expected.keys()
        for path, value in state.items():
            assert np.array_equal(value, expected[path], equal_nan=True), path
    assert len(start.beds) == (1 if name in SHAKING else 2)


def test_beds_of_replicates_and_time_steps_are_their_own():
    beds = [build(belt_point(**TINY), *which) for which in ((0,), (1,), (0, 2))]
    for bed in beds:
        bed.settle()
    assert len(start.beds) == 3


def test_a_shared_bed_moves_alone():
    first, second = (build(belt_point(**TINY), 0) for _ in range(2))
    first.settle()
    first.sample(5)
    second.settle()
    assert np.array_equal(settled_state()["disks.taylor"], flatten(second.disks)["taylor"])


def test_memory_is_bounded_and_the_oldest_bed_goes(monkeypatch):
    settled_state(seed=1)
    monkeypatch.setattr(start, "ROOM", int(2.5 * start._size(*start.beds.values())))
    settled_state(seed=2)
    kept = set(start.beds)
    settled_state(seed=1)
    settled_state(seed=3)
    assert len(start.beds) == 2 and len(kept & set(start.beds)) == 1


def test_a_bed_that_fails_is_not_kept(monkeypatch):
    monkeypatch.setattr(belt, "SETTLING_LIMIT", 0.0)
    for _ in range(2):
        with pytest.raises(BlowUp, match="the bed is not at rest"):
            settled_state()
    assert not start.beds


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
