"""Random initial positions, and controls that claims need: unequal spheres, a bumpy plane, beds
shaken or pushed before.
"""

import numpy as np
import pytest

from sim.engine.dynamics.cells import make_box
from sim.engine.systems import build
from sim.engine.systems.start import random_packing
from tests.engine_motion.helpers import wrapped
from tests.engine_motion.points import belt_point, chute_point, sums_of

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


def test_positions_are_uniform_where_there_is_room():
    """A dilute layer: each eighth of it holds its share within five standard deviations."""
    radius = np.full(4000, 0.05 * UNIT)
    box, rng = make_box(20e-3, 20e-3), np.random.default_rng(5)
    position = random_packing(box, 20e-3, radius, rng)
    share, _ = np.histogramdd(position, bins=2, range=[(0, 20e-3)] * 3)
    assert np.abs(share / 4000 - 1 / 8).max() < 5 * np.sqrt(7 / 64 / 4000)


def test_one_particle_fits_into_a_layer_without_height():
    box, rng = make_box(3e-3, 3e-3), np.random.default_rng(0)
    position = random_packing(box, 0.0, np.array([0.5 * UNIT]), rng)
    assert position[0, 2] == 0.5 * UNIT


@pytest.mark.parametrize("length", [(5e-3, 0.0), (4e-3, 4e-3, 0.0)])
def test_what_cannot_fit_is_an_error_that_says_so(length):
    radius, rng = np.full(60, 0.5 * UNIT), np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"only \d+ of 60 particles fit"):
        random_packing(make_box(*length[:-1]), 1.0 * UNIT, radius, rng)


BUMPY = {"cell": 5, "depth": 2, "bumps": 0.8}
UNEQUAL = {"cell": 5, "depth": 2, "diameter_spread": 0.2}


def changes(system, samples: int) -> dict[str, float]:
    """Return how much each time series changes from the first to the last of some samples."""
    rows = [system.advance() for _ in range(samples)]
    return {name: rows[-1][name] - rows[0][name] for name in system.series}


def residual(system, samples: int) -> float:
    """Return what the energy ledger lacks, relative to the energy turned over."""
    change = changes(system, samples)
    lacking = sum(sign * change[name] for name, sign in system.ledger.terms.items())
    return lacking / sum(change[name] for name in system.ledger.turnover)


def test_unequal_spheres_weigh_as_much_as_equal_ones():
    system = build(chute_point(**UNEQUAL), 0)
    p, spheres = system.parameters, system.spheres
    size = spheres.radius / (0.5 * p.diameter)
    assert spheres.mass == pytest.approx(p.mass * size**3, rel=1e-12)
    assert spheres.mass.mean() == pytest.approx(p.mass, rel=1e-12)
    assert 0.75 < size.min() < 0.9 and 1.1 < size.max() < 1.25
    assert p.time_step < 0.75 * chute_point(cell=5, depth=2).time_step


@pytest.mark.parametrize("values", [BUMPY, UNEQUAL, BUMPY | UNEQUAL])
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


@pytest.mark.parametrize("values", [BUMPY, UNEQUAL])
def test_the_energy_ledger_closes(values):
    assert abs(residual(build(chute_point(**values), 0), 160)) < 1e-3


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
    for cell, bumps, rows in ((5, 0.8, 5), (6, 3, 2), (5.94, 3, 1)):
        values = {"depth": 1, "bumps": bumps, "bump_coverage": 0.45}
        system = build(chute_point(cell=cell, bump_arrangement="ordered", **values), 0)
        start, p = system.snapshot(), system.parameters
        places = start["position"][start["fixed"] == 1] / p.diameter
        assert len(places) == p.glued_particles == rows**2
        assert places[:, 2] == pytest.approx(bumps / 2)
        steps = cell * (np.arange(rows) + 0.5) / rows
        lattice = [(x, y) for x in steps for y in steps]
        assert np.allclose(sorted(map(tuple, places[:, :2].round(9))), lattice)
        assert cell / rows >= bumps


def test_averages_leave_out_what_is_glued():
    system = build(chute_point(**BUMPY), 0)
    profile, _ = sums_of(system)
    row = system.advance()
    moving = system.spheres.mass > 0
    now = system.spheres.velocity[0, moving].mean()
    assert row["mean_velocity"] == pytest.approx(now, rel=0.05)
    volume = 4 / 3 * np.pi * (0.5e-3) ** 3
    assert profile.weight.sum() == pytest.approx(moving.sum() * volume, rel=1e-9)


def test_a_bumpy_plane_slows_the_flow():
    def end(**values):
        system = build(chute_point(cell=5, depth=2, initial_velocity=5.0, **values), 0)
        return [system.advance() for _ in range(200)][-1]["mean_velocity"]

    assert end(bumps=1.0) < 0.7 * end()


def test_all_beads_can_start_with_a_velocity():
    small = {"beads": 40, "width": 8}
    still, pushed = (build(belt_point(**small, initial_velocity=v), 0) for v in (0, 3))
    for system in (still, pushed):
        system.settle()
    unit = pushed.parameters.velocity_unit
    gained = pushed._velocity() - still._velocity()
    assert gained[0] == pytest.approx(3 * unit, rel=1e-9) and not gained[1].any()


def test_a_bed_shaken_before_starts_in_motion_at_phase_zero():
    """It moves forwards at that phase, faster than the mean of the cycle to come; in four beds."""
    small = {"beads": 40, "width": 8, "frequency": 17, "prior_frequency": 30, "prior_cycles": 20}
    p = belt_point(**small)
    starts, means = [], []
    for replicate in range(4):
        system = build(p, replicate)
        system.settle()
        starts.append(system._velocity()[0].mean())
        assert system.loop.step[0] == 0 and system.disks.taylor[0, 1].min() > -0.5 * p.diameter
        means.append(np.mean([system.advance()["mean_velocity"] for _ in range(20)]))
    assert p.samples_per_cycle == 20 and min(starts) > 0.02 * p.velocity_amplitude
    assert 0.3 < np.mean(means) / np.mean(starts) < 1
