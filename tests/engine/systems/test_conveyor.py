"""A vibrating plane against exact solutions: sliding, rolling, bouncing, energy and weight."""

from math import pi

import numpy as np
import pytest

from sim.engine.boundary.drive import plane_position, plane_velocity, vibration
from sim.engine.systems import build
from sim.parameters import ConveyorParameters
from sim.verify.exact import block_on_plane, doubling

GRAVITY, FREQUENCY, DIAMETER = 9.8, 20.0, 1e-3
RATE = 2 * pi * FREQUENCY

#: A vertical amplitude in diameters that shakes with the acceleration of gravity.
OF_GRAVITY = GRAVITY / RATE**2 / DIAMETER


def one_particle(**changes) -> ConveyorParameters:
    """Return one particle on a plane that shakes."""
    usual = {"frequency": FREQUENCY, "shape": "disc", "depth": 0.2, "cell": 5, "gravity": GRAVITY}
    return ConveyorParameters(**usual | {"initial_agitation": 0, "stiffness": 1000} | changes)


def cycles(parameters, count: int, name: str = "mean_velocity") -> np.ndarray:
    """Return a time series (C, samples of a cycle) over the first cycles."""
    system, each = build(parameters, 0), parameters.samples_per_cycle
    found = [system.advance()[name] for _ in range(count * each)]
    return np.reshape(found, (count, each))


def transport_of_a_block(friction: float, strength: float, ratio: float, steps: int = 20_000):
    """Mean velocity of a block on a plane that never throws it, over A_x ω, by Coulomb's friction.

    Time in 1/ω, accelerations in g; z = A_z sin ωt with A_z ω² = ``strength`` g, x = ``ratio`` z.
    """
    phase = np.arange(steps + 1) * 2 * pi / steps
    plane = ratio * strength * np.cos(phase)
    most = friction * (1 - strength * np.sin(0.5 * (phase[1:] + phase[:-1]))) * 2 * pi / steps
    return block_on_plane(plane[1:], most, 12).mean() / (ratio * strength)


def test_a_block_below_take_off_slides_and_sticks_as_coulomb_says():
    friction, strength, ratio = 0.4, 0.8, 1.0
    amplitude = strength * OF_GRAVITY
    point = one_particle(
        friction=friction,
        rotation=False,
        restitution=0.3,
        amplitude=amplitude,
        amplitude_along=ratio * amplitude,
    )
    found = cycles(point, 25)[-3:].mean() / (ratio * amplitude * DIAMETER * RATE)
    exact = transport_of_a_block(friction, strength, ratio)
    assert found == pytest.approx(exact, rel=0.03)
    assert exact > 0.2


@pytest.mark.parametrize(("shape", "share"), [("sphere", 2 / 7), ("disc", 1 / 3)])
def test_a_particle_that_rolls_follows_the_plane_by_its_inertia(shape, share):
    """A plane that shakes sideways takes along β/(1 + β) of its velocity, I = β m r²."""
    number = {"sphere": {"depth": 1 / 9, "cell": 3}, "disc": {}}[shape]
    point = one_particle(shape=shape, amplitude=0, amplitude_along=1, friction=1, **number)
    point = point.model_copy(update={"restitution": 0.3})
    system = build(point, 0)
    for _ in range(5 * point.samples_per_cycle):
        system.advance()
    velocity, plane = [], []
    for _ in range(3 * point.samples_per_cycle):
        velocity.append(system.advance()["mean_velocity"])
        time = system.flow.step[0] * system.time_step
        interval = system.sample_steps * system.time_step
        ends = plane_position(system.drive, 0, np.array([time - interval, time]))
        plane.append(np.diff(ends)[0] / interval)
    slope = np.polyfit(plane, velocity, 1)[0]
    assert slope == pytest.approx(share, rel=5e-3)


@pytest.mark.parametrize(("strength", "period"), [(1.42, 1), (1.6, 2)])
def test_a_bouncing_ball_doubles_its_period_where_the_exact_map_does(strength, period):
    """With e = 0.5 at Γ = 1.527."""
    assert (strength < doubling(0.5)) == (period == 1)
    point = one_particle(
        friction=0,
        rotation=False,
        restitution=0.5,
        stiffness=300,
        steps_per_collision=40,
        amplitude=strength * OF_GRAVITY,
        amplitude_along=0,
        initial_height=7.5,
        samples_per_cycle=1,
    )
    height = cycles(point, 70, "height_of_mass")[-10:, 0] / DIAMETER
    assert height.mean() > 2
    even, odd = height[::2], height[1::2]
    assert np.ptp(even) < 0.06 and np.ptp(odd) < 0.06
    assert (abs(even.mean() - odd.mean()) > 1) == (period == 2)


COMBINED = [
    {},
    {"shape": "disc", "cell": 10},
    {"shape": "disc", "cell": 10, "rotation": False, "diameter_spread": 0.3},
    {"bumps": 0.6, "angle": 10, "phase_along": 90},
    {"law": "spring_dashpot", "shape": "disc", "cell": 10},
    {"law": "hertz", "steps_per_collision": 100},
    {"law": "drag", "shape": "disc", "cell": 10, "steps_per_collision": 100},
    {"overtone": 3, "overtone_amplitude": 0.2, "overtone_along": 0.3, "overtone_phase": 40},
]


#: Laws whose work other tests have; compiling them for a plane that moves takes long.
RARE = ("spring_dashpot", "hertz", "drag")


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param(one, marks=pytest.mark.long) if one.get("law") in RARE else one
        for one in COMBINED
    ],
)
def test_energy_adds_up_and_the_plane_carries_the_weight(changes):
    usual = {"depth": 2, "cell": 5, "frequency": 30, "transient": 10, "average": 20}
    point = ConveyorParameters(**usual | changes)
    system, count = build(point, 0), 30 * point.samples_per_cycle
    samples = [system.advance() for _ in range(count)]
    gain = {name: samples[-1][name] - samples[0][name] for name in system.ledger.terms}
    missing = sum(sign * gain[name] for name, sign in system.ledger.terms.items())
    assert gain["plane_work"] > 0
    assert abs(missing) < 5e-3 * gain["plane_work"]
    normal_force = np.mean([one["base_normal_force"] for one in samples[count // 3 :]])
    assert normal_force == pytest.approx(system.weight[1], rel=0.1)


def test_a_plane_of_two_frequencies_is_where_the_formula_says():
    """A sin(ωt + φ) + B sin(kωt + ψ), with amplitudes of its own along and across."""
    amplitudes = {"amplitude": 0.5, "amplitude_along": 0.4, "phase_along": 70}
    drive = vibration(one_particle(**COMBINED[-1] | amplitudes), (0.0, 0.0, -GRAVITY))
    time, step = np.linspace(0, 1 / FREQUENCY, 40), 1e-7
    second = np.sin(3 * RATE * time + np.radians(40))
    for axis, first, of_second in (
        (0, 0.4 * np.sin(RATE * time + np.radians(70)), 0.3),
        (1, 0.5 * np.sin(RATE * time), 0.2),
    ):
        place = DIAMETER * (first + of_second * second)
        assert plane_position(drive, axis, time) == pytest.approx(place, abs=1e-15)
        ends = (plane_position(drive, axis, time + shift) for shift in (-step, step))
        rate = np.subtract(*ends) / (-2 * step)
        assert rate == pytest.approx(plane_velocity(drive, axis, time), abs=1e-6)


def test_a_plane_at_rest_carries_a_resting_bed():
    point = ConveyorParameters(depth=2, cell=5, amplitude=0, amplitude_along=0, restitution=0.3)
    system = build(point, 0)
    last = [system.advance() for _ in range(20 * point.samples_per_cycle)][-1]
    assert last["base_normal_force"] == pytest.approx(system.weight[1], rel=1e-3)
    assert abs(last["base_shear_force"]) < 1e-3 * system.weight[1]
    assert last["plane_work"] == 0


def test_a_flow_goes_on_under_another_motion_with_its_contacts():
    """It ends in an odd step; tests/conformance/test_motions.py compares velocities."""
    usual = {"depth": 2, "cell": 5, "frequency": 40, "samples_per_cycle": 5}
    first = build(ConveyorParameters(**usual, steps_per_collision=41), 0)
    for _ in range(9 * 5):
        first.advance()
    assert first.flow.step[0] % 2 == 1
    second = build(ConveyorParameters(**usual, amplitude=0.3, phase_along=90), 0)
    second.take_over(first)
    touching = second.pairs.slot[second.pairs.slot >= 0]
    assert second.flow.step[0] == 0 and len(touching)
    assert np.abs(second.memory[0][:, touching]).max(axis=0).min() > 0
