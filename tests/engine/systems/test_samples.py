"""Samples, many at once and one by one, with pauses; paths, fields and tables besides profiles."""

import numpy as np
import pytest

from sim.engine.dynamics.cells import BlowUp
from sim.engine.observe.profiles import EDGES, LEVELS, WAVES, bed_energies, wave_power, waves
from sim.engine.systems import build, replica
from tests.engine_motion.points import belt_point, chute_point, sums_of

CHUTE = chute_point(depth=2, cell=5)
BELT = belt_point(beads=40, width=8, obstacle=1.5)


def running_system(point):
    """Return a system in motion."""
    system = build(point, 0)
    system.settle()
    for _ in range(9):
        system.sample()
    return system


def take_samples(point, samples: int, at_once: int) -> tuple[dict, list]:
    """Return series and profiles of some samples, so many at once."""
    system, found = running_system(point), []
    while (left := samples - sum(len(one.values["mean_velocity"]) for one in found)) > 0:
        one = system.sample(min(at_once, left), profiles=True)
        copies = [type(several)(*map(np.copy, several)) for several in one.profiles]
        found.append(one._replace(profiles=copies))
    series = {name: np.concatenate([one.values[name] for one in found]) for name in system.series}
    arrays = zip(*(sum(map(tuple, one.profiles), ()) for one in found), strict=True)
    return series, [np.concatenate(several) for several in arrays]


@pytest.mark.parametrize("point", [CHUTE, BELT], ids=["chute", "belt"])
def test_many_at_once_are_those_taken_one_by_one(point):
    several, together = take_samples(point, 23, 10)
    one_by_one, apart = take_samples(point, 23, 1)
    for name, values in one_by_one.items():
        assert values.shape == (23,) and np.array_equal(several[name], values), name
    for mine, theirs in zip(together, apart, strict=True):
        assert np.array_equal(mine, theirs)


def test_samples_of_the_belt_are_what_array_arithmetic_makes_of_the_state():
    """To the bit: the sums are those of numpy, in its order."""
    system = running_system(BELT)
    p, disks = system.parameters, system.disks
    width, squares = system.box.length[0], system.slices.squares
    for _ in range(20):
        sample = system.sample(1, profiles=True)
        row, field = sample.first(), sample.profiles[2]
        (x, z), velocity, mass = disks.taylor[0], disks.taylor[1] / p.time_step, disks.mass
        assert row["kinetic_energy"] == 0.5 * (mass * (velocity**2).sum(axis=0)).sum()
        assert row["height_of_mass"] == np.average(z, weights=mass)
        assert row["potential_energy"] == p.gravity * float(mass @ z)
        assert row["base_occupancy"] == (np.abs(z) < p.amplitude * p.diameter).mean()
        wave = np.exp(2j * np.pi / width * x)
        power = sum(abs((wave**k).sum()) ** 2 for k in range(1, WAVES + 1)) / (WAVES * len(x))
        assert row["wave_power"] == power
        column = np.floor(x / squares.width).astype(int) % squares.columns
        level = np.floor((z - squares.lowest) / squares.height).astype(int)
        inside = (level >= 0) & (level < LEVELS)
        place = (column * LEVELS + level)[inside]
        for found, weights in ((field.count, None), (field.moved, velocity[0][inside])):
            expected = np.bincount(place, weights, minlength=squares.columns * LEVELS)
            assert np.array_equal(found[0].ravel(), expected)


def test_samples_of_the_chute_are_what_array_arithmetic_makes_of_the_state():
    system = running_system(CHUTE)
    spheres = system.spheres
    for _ in range(5):
        row = system.advance()
        speed, rim = ((parts**2).sum(axis=0) for parts in (spheres.velocity, spheres.rim))
        assert row["kinetic_energy"] == 0.5 * (spheres.mass * speed).sum()
        assert row["rotational_energy"] == 0.5 * 0.4 * (spheres.mass * rim).sum()
        assert row["height_of_mass"] == np.average(spheres.position[2], weights=spheres.mass)


@pytest.mark.parametrize("point", [CHUTE, BELT], ids=["chute", "belt"])
def test_a_blow_up_holds_the_samples_before_it(point):
    whole = running_system(point)
    rows = [whole.advance() for _ in range(12)]
    overlap = [row["largest_overlap"] for row in rows]
    last = int(np.argmax(overlap))
    assert last > 0, "the test needs a largest overlap that comes late"
    limit = 0.5 * (overlap[last] + max(overlap[:last]))
    system = running_system(point)
    system.parameters = point.model_copy(update={"overlap_limit": limit})
    with pytest.raises(BlowUp, match="an overlap exceeds overlap_limit at step") as error:
        system.sample(12)
    found = error.value.samples.values["mean_velocity"]
    assert list(found) == [row["mean_velocity"] for row in rows[: len(found)]]
    assert len(found) == next(k for k in range(12) if overlap[k] > limit)
    with pytest.raises(BlowUp) as error:
        system.sample(12)
    assert error.value.samples is None


POINTS = [
    belt_point(beads=20, width=5, prior_frequency=30, prior_cycles=2),
    chute_point(depth=2, cell=4),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.system)
def test_no_more_than_some_steps_lie_between_two_pauses(point, monkeypatch):
    most = point.particles * point.sample_steps // 3
    monkeypatch.setattr(replica, "MOST_WORK", most)
    system, runs = build(point, 0), []
    advance = system._advance

    def advanced(steps):
        runs.append(steps)
        return advance(steps)

    monkeypatch.setattr(system, "_advance", advanced)
    system.pause = lambda: runs.append(None)
    for act in (system.settle, system.advance, system.trace):
        runs.clear()
        act()
        stretches = [steps for steps in runs if steps is not None]
        assert all(0 < steps * point.particles <= most for steps in stretches)
        assert act == system.settle or None in runs


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
