"""Samples that are taken many at once: those taken one by one, and what the state says of them."""

import numpy as np
import pytest

from sim.engine.dynamics.status import BlowUp
from sim.engine.observe.field import LEVELS, WAVES
from sim.engine.systems import build
from tests.engine_motion.points import belt_point, chute_point

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
