"""Samples, many at once and one by one, with pauses; paths, fields and tables besides profiles."""

import numpy as np
import pytest

from sim.engine.dynamics.cells import BlowUp
from sim.engine.systems import build, replica
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
    system.overlap_limit = limit
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
    path, p = system.trace(), system.parameters
    assert path.shape == (41, 40, 2) and system.loop.step[0] == 2 * p.steps_per_cycle
    assert system.coordinates["path_time"][2][-1] == pytest.approx(1 / 30)
    assert np.abs(np.diff(path, axis=0)).max() < 0.5 * p.width * p.diameter
    final = system.snapshot()["position"]
    laps = (final - path[-1]) / (p.width * p.diameter)
    assert laps[:, 0] == pytest.approx(np.round(laps[:, 0]), abs=1e-9)
    assert final[:, 1] == pytest.approx(path[-1][:, 1])
    odd = settled_belt(frequency=30, steps_per_cycle=1990, samples_per_cycle=10)
    odd.trace()
    assert odd.loop.step[0] == 1990


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


def test_a_sample_of_a_chute_is_what_the_state_and_the_impulses_say():
    p = chute_point(cell=5, depth=1.24)
    system = build(p, 0)
    samples = []
    for _ in range(40):
        before = system.spheres.velocity.mean(axis=1)
        sample = system.advance()
        interval = p.sample_steps * p.time_step
        change = (system.spheres.velocity.mean(axis=1) - before) / interval
        weight = p.particles * p.mass * p.gravity
        along, _, down = np.array(system.gravity) * p.particles * p.mass
        force = p.particles * p.mass * change
        assert along - sample["base_shear_force"] == pytest.approx(force[0], abs=1e-11 * weight)
        assert sample["base_normal_force"] + down == pytest.approx(force[2], abs=1e-11 * weight)
        samples.append(sample)
    state = system.snapshot()
    velocity, spin = state["particle_velocity"], state["particle_spin"]
    inertia = 0.4 * p.mass * (0.5 * p.diameter) ** 2
    assert np.mean([each["base_normal_force"] for each in samples]) > 0.5 * weight
    assert sample["mean_velocity"] == pytest.approx(velocity[:, 0].mean(), rel=0.02)
    flux = sample["mean_velocity"] * p.particles * p.mass / (5 * p.diameter) ** 2
    assert sample["mass_flux"] == pytest.approx(flux, rel=1e-12)
    assert sample["kinetic_energy"] == pytest.approx(0.5 * p.mass * (velocity**2).sum())
    assert sample["rotational_energy"] == pytest.approx(0.5 * inertia * (spin**2).sum())
    assert sample["height_of_mass"] == pytest.approx(state["position"][:, 2].mean())
    assert 0.1 < np.mean([each["contact_number"] for each in samples]) < 6
    assert 1e-4 < sample["largest_overlap"] < 0.05
