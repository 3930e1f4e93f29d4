"""The chute: its initial state, its samples, tiny and large systems, same seed same bits."""

import numpy as np
import pytest

from sim.engine.dynamics.cells import BlowUp
from sim.engine.systems import build
from tests.engine_motion.helpers import wrapped
from tests.engine_motion.points import chute_point, sums_of

SMALL = {"cell": 5, "depth": 1.24}


def test_initial_state_is_random_without_overlaps_gradients_or_spin():
    p = chute_point(depth=5, cell=8, initial_velocity=7.0, initial_agitation=0.2)
    system = build(p, 0)
    state = system.snapshot()
    position, velocity = state["position"], state["particle_velocity"]
    assert len(position) == p.particles == 320
    side = 8 * p.diameter
    for i in range(319):
        apart = wrapped(position[i + 1 :] - position[i], side, side, 0.0)
        assert np.linalg.norm(apart, axis=1).min() >= p.diameter
    assert position[:, 2].min() >= 0.5 * p.diameter
    layer = 320 * np.pi / 6 * p.diameter / (64 * p.initial_packing)
    assert position[:, 2].max() <= 0.5 * p.diameter + layer
    unit = p.velocity_unit
    assert velocity.mean(axis=0) == pytest.approx([7.0 * unit, 0, 0], abs=1e-12 * unit)
    agitation = velocity - velocity.mean(axis=0)
    assert np.sqrt((agitation**2).sum(axis=1).mean()) == pytest.approx(0.2 * unit, rel=0.1)
    height = position[:, 2] - position[:, 2].mean()
    correlation = (agitation[:, 0] * height).mean() / (agitation[:, 0].std() * height.std())
    assert abs(correlation) < 5 / np.sqrt(320)
    assert not state["particle_spin"].any()
    assert system.spheres.mass == pytest.approx(p.mass, rel=1e-14)
    assert state["radius"] == pytest.approx(0.5 * p.diameter, rel=1e-14)


def test_same_seed_gives_the_same_bits_and_replicates_differ():
    def end(seed, replicate):
        system = build(chute_point(**SMALL, seed=seed), replicate)
        samples = [system.advance() for _ in range(10)]
        return system.snapshot(), samples

    state, samples = end(1, 0)
    again, repeated = end(1, 0)
    assert all(np.array_equal(state[name], again[name]) for name in state)
    assert samples == repeated
    for other in (end(1, 1), end(2, 0)):
        assert not np.array_equal(state["position"], other[0]["position"])


def test_sample_is_what_the_state_and_the_impulses_say():
    p = chute_point(**SMALL)
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


@pytest.mark.parametrize("settings", [{"depth": 0.04}, {"depth": 0.08}, {"depth": 0.11, "cell": 3}])
def test_one_two_and_few_particles_flow(settings):
    p = chute_point(**{"cell": 5} | settings)
    assert p.particles <= 2
    system = build(p, 0)
    for _ in range(200):
        sample = system.advance()
    assert np.isfinite(list(sample.values())).all()
    assert sample["mean_velocity"] > 0.4


def test_twenty_thousand_particles_flow():
    system = build(chute_point(depth=2, cell=100, sample_interval=0.01), 0)
    samples = [system.advance() for _ in range(5)]
    assert len(system.spheres.mass) == 20_000
    assert all(np.isfinite(list(sample.values())).all() for sample in samples)


def test_too_soft_spheres_blow_up_with_a_reason():
    system = build(chute_point(depth=20, cell=5, stiffness=0.5), 0)
    with pytest.raises(BlowUp, match=r"overlap exceeds overlap_limit at step \d+ \(t\* = "):
        for _ in range(200):
            system.advance()


@pytest.mark.parametrize("depth", [0.3, 0.7, 0.9, 1.2, 3.0, 12.0])
def test_every_depth_can_be_filled_at_the_highest_packing(depth):
    system = build(chute_point(depth=depth, cell=10, initial_packing=0.35), 0)
    assert len(system.spheres.mass) == round(100 * depth)


def test_profiles_hold_the_whole_flow():
    """But for what the lowest spheres dip into the plane, some 1e-6 of the volume."""
    p = chute_point(**SMALL)
    system = build(p, 0)
    for _ in range(19):
        system.advance()
    profiles = system.profiles(sums_of(system))
    packing, velocity = profiles["packing_profile"], profiles["velocity_profile"]
    volume = packing.sum() * p.slice_height * p.diameter * (5 * p.diameter) ** 2
    assert volume == pytest.approx(p.particles * np.pi / 6 * p.diameter**3, rel=1e-4)
    filled = packing > 0
    assert np.isfinite(velocity[filled]).all() and np.isnan(velocity[~filled]).all()
    assert (profiles["granular_temperature_profile"][filled] >= 0).all()
    mean = np.average(velocity[filled], weights=packing[filled])
    assert mean == pytest.approx(system.spheres.velocity[0].mean(), rel=1e-4)
