"""Paths of particles, fields and tables that a run leaves besides its profiles."""

import numpy as np
import pytest

from sim.engine.observe.field import wave_power, waves
from sim.engine.observe.profiles import EDGES
from sim.engine.observe.totals import bed_energies
from sim.engine.systems import build
from tests.engine_motion.points import belt_point, chute_point, sums_of


def settled_belt(**values):
    system = build(belt_point(**{"beads": 40, "width": 8} | values), 0)
    system.settle()
    return system


def test_the_path_of_a_belt_is_one_cycle_from_phase_zero():
    system = settled_belt(frequency=30)
    for _ in range(7):
        system.advance()
    path = system.trace()
    p = system.parameters
    assert path.shape == (41, 40, 2) and system.loop.step[0] == 2 * p.steps_per_cycle
    assert system.coordinates["path_time"][2][-1] == pytest.approx(1 / 30)
    assert np.abs(np.diff(path, axis=0)).max() < 0.5 * p.width * p.diameter
    final = system.snapshot()["position"]
    laps = (final - path[-1]) / (p.width * p.diameter)
    assert laps[:, 0] == pytest.approx(np.round(laps[:, 0]), abs=1e-9)
    assert final[:, 1] == pytest.approx(path[-1][:, 1])


def test_an_odd_number_of_steps_is_shared_out_among_the_intervals():
    system = settled_belt(frequency=30, steps_per_cycle=1990, samples_per_cycle=10)
    system.trace()
    assert system.loop.step[0] == 1990


def test_the_path_of_a_fast_chute_is_not_folded_into_the_cell():
    """A path as long as the way that the mean velocity tells."""
    p = chute_point(cell=4, depth=2, initial_velocity=30.0, friction=0.1)
    system = build(p, 0)
    for _ in range(8):
        system.advance()
    velocity = system.spheres.velocity[0].mean()
    path, time = system.trace(), system.coordinates["path_time"][2]
    way = (path[-1] - path[0])[:, 0]
    assert path.shape == (41, p.particles, 3)
    assert way.mean() == pytest.approx(velocity * time[-1], rel=0.1)
    assert way.min() > 0.5 * way.mean()


def test_the_field_counts_every_bead_once_where_it_is():
    system = settled_belt(frequency=60)
    system.sample(29)
    *_, field = sums = sums_of(system)
    assert field.count.sum() == 40 and field.samples == 1
    x, z = system.disks.taylor[0]
    column, level = int(x[3] / 1e-3) % 8, int(np.floor((z[3] + 1e-3) / 1e-3))
    assert field.count[column, level] >= 1
    assert field.moved.sum() == pytest.approx(system._velocity()[0].sum())
    tables = system.tables(sums)
    assert np.nansum(tables["field_density"]) * 1e-6 == pytest.approx(40)
    assert np.isnan(tables["field_velocity"][tables["field_density"] == 0]).all()


def test_waves_of_beads_in_one_place_are_as_strong_as_can_be_and_even_beads_have_none():
    found = np.zeros((2, 5, 2))
    for x, sums in zip((np.full(40, 1e-3), np.arange(40) * 0.2e-3), found, strict=True):
        waves(x, 8e-3, sums)
    assert wave_power(found, 40) == pytest.approx([40, 0], abs=1e-12)


def test_occupancy_counts_beads_within_an_amplitude_of_the_mean_belt():
    taylor = np.zeros((6, 2, 40))
    taylor[0, 1] = np.linspace(-2e-3, 6e-3, 40)
    *_, found = bed_energies(taylor, np.ones(40), 1e-5, 1.5e-3)
    assert found == (np.abs(taylor[0, 1]) < 1.5e-3).mean()


def test_overlaps_of_all_contacts_are_counted_in_their_intervals():
    system = build(chute_point(cell=4, depth=3), 0)
    rows = [system.advance() for _ in range(60)]
    last = system.sample(1, profiles=True)
    rows.append(last.first())
    overlaps = last.profiles[1]
    assert 0 < overlaps.counts.sum() < 12 * system.parameters.particles
    largest = EDGES[np.flatnonzero(overlaps.counts).max()]
    assert largest <= max(row["largest_overlap"] for row in rows)
    x, r = system.spheres.position, system.spheres.radius
    resting = ((r - x[2]) / (2 * r))[x[2] < r]
    expected, _ = np.histogram(resting, EDGES)
    assert (overlaps.counts[0] >= expected).all()
