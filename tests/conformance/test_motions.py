"""What holds for every motion of belt and plane: a motion is tested by being registered."""

from math import pi

import numpy as np
import pytest

from sim.engine.boundary.drive import plane_position, plane_velocity, vibration
from sim.engine.replicate import Replicate
from sim.engine.states import pack, unpack
from sim.engine.systems import build
from sim.engine.systems.start import vibration as belt_vibration
from sim.parameters import Parameters, parse_point, require_compatible_source
from sim.parameters.laws import MOTION
from tests.conformance import names_of
from tests.engine_motion.helpers import belt_states
from tests.engine_motion.points import energy_residual, series_of

MOTIONS = names_of(MOTION)
FREQUENCY, GRAVITY = 30, (0.0, 0.0, -9.8)
CONVEYOR = {"depth": 2, "cell": 8, "shape": "disc", "transient": 1, "average": 29}
BELT = {"beads": 40, "width": 8, "transient": 2, "average": 6}

with_motions = pytest.mark.parametrize("motion", MOTIONS)


def point_of(motion: str, system: str = "conveyor", **values) -> Parameters:
    """Return a point of a motion; only points that are not harmonic say so."""
    given = {"system": system, "frequency": FREQUENCY} | values
    return parse_point(given | ({} if motion in MOTION.usual else {"motion": motion}), "test")


@with_motions
def test_a_plane_moves_with_the_derivative_of_its_place_and_repeats_itself(motion):
    point = point_of(motion, amplitude=0.5, amplitude_along=0.8)
    drive, size = vibration(point, GRAVITY), point.diameter
    time, step = np.linspace(0.001, 2.4 / FREQUENCY, 50), 1e-7
    for axis in (0, 1):
        moved = plane_position(drive, axis, time + step) - plane_position(drive, axis, time - step)
        velocity = plane_velocity(drive, axis, time)
        assert moved / (2 * step) == pytest.approx(velocity, abs=1e-5)
        # The mean along x may be any.
        place, later = (plane_position(drive, axis, time + n / FREQUENCY) for n in (0, 100))
        assert np.ptp(later - place) < 1e-6 * size and (
            axis == 0 or abs(later - place).max() < 1e-9
        )
        again = plane_velocity(drive, axis, time + 100 / FREQUENCY)
        assert again == pytest.approx(velocity, abs=1e-7)
    cycle = plane_velocity(drive, 1, (np.arange(1000) + 0.5) / 1000 / FREQUENCY)
    assert abs(cycle.mean()) < 1e-3 * np.abs(cycle).max()


@with_motions
def test_a_belt_moves_with_the_derivative_of_its_height_and_repeats_itself(motion):
    point = point_of(motion, "belt", phase=30, vibration_angle=30)
    belt, time, step = belt_vibration(point, FREQUENCY), np.linspace(0, 0.1, 50), 1e-7
    height, velocity = belt_states(belt, time)
    rate = (belt_states(belt, time + step)[0] - belt_states(belt, time - step)[0]) / (2 * step)
    assert velocity[:, 1] == pytest.approx(rate, abs=1e-5)
    again = belt_states(belt, time + 100 / FREQUENCY)
    assert again[0] == pytest.approx(height, abs=1e-9 * point.diameter)
    assert again[1] == pytest.approx(velocity, abs=1e-7)
    # The plane of a conveyor has the same motion, A_z in diameters, without the phase.
    plane = point_of(motion, amplitude=point.amplitude)
    drive = vibration(plane, GRAVITY)
    late = time + point.phase / 360 / FREQUENCY
    scale = point.diameter / plane.diameter
    assert height == pytest.approx(scale * plane_position(drive, 1, late), abs=1e-9)


@with_motions
@pytest.mark.parametrize(
    "changes",
    [
        {"angle": 10, "amplitude_along": 0.5},
        pytest.param({"law": "hertz"}, marks=pytest.mark.long),
    ],
)
def test_the_work_of_a_plane_is_what_its_flow_has_gained_and_lost(motion, changes):
    point = point_of(motion, **CONVEYOR | changes)
    system, found = build(point, 0), series_of(point)
    work = found["plane_work"][-1] - found["plane_work"][0]
    turnover = sum(found[name][-1] - found[name][0] for name in system.ledger.turnover)
    assert work > 0 and abs(energy_residual(found, system.ledger)) * turnover < 5e-3 * work
    weight = found["base_normal_force"][len(found["base_normal_force"]) // 3 :].mean()
    assert weight == pytest.approx(system.weight[1], rel=0.1)


@with_motions
def test_the_work_of_a_belt_is_what_its_bed_has_gained_and_lost(motion):
    point = point_of(motion, "belt", **BELT)
    system, found = build(point, 0), series_of(point)
    assert abs(energy_residual(found, system.ledger)) < 5e-3


def laboratory(system, time: float) -> np.ndarray:
    """Return the velocities of all spheres in the laboratory (3, N), in the order of the start."""
    velocity = system.spheres.velocity[:, np.argsort(system.spheres.label[0])].copy()
    velocity[0] += plane_velocity(system.drive, 0, time)
    velocity[2] += plane_velocity(system.drive, 1, time)
    return velocity


@with_motions
def test_a_flow_goes_on_under_a_motion_and_from_its_states(motion):
    for first, second in (("harmonic", motion), (motion, "harmonic")):
        before, after = point_of(first, **CONVEYOR), point_of(second, **CONVEYOR, amplitude=0.3)
        require_compatible_source(after, before, "p")
        one, other = build(before, 0), build(after, 0)
        for _ in range(2 * before.samples_per_cycle):
            one.advance()
        ended = laboratory(one, (one.flow.step[0] - 0.5) * one.time_step)
        other.take_over(one)
        assert laboratory(other, -0.5 * other.time_step) == pytest.approx(ended, abs=1e-12)
    replicate = Replicate(before, 0)
    replicate.recorder.take_snapshot()
    replicate.recorder.take(replicate.system.sample())
    again = Replicate.from_state(before, 0, unpack(pack(replicate.state())))
    assert replicate.system.advance() == again.system.advance()


@pytest.mark.skipif("sine" not in MOTIONS, reason="tests/data/motions.py is not loaded")
def test_the_harmonic_motion_of_a_plugin_is_that_of_talus():
    """Collisions make any difference of rounding grow, so no longer than for the first of them."""
    for given in ({}, {"angle": 10, "amplitude_along": 0.5}):
        short = CONVEYOR | {"average": 1, "transient": 0} | given
        one, other = (series_of(point_of(name, **short)) for name in ("harmonic", "sine"))
        for name, values in one.items():
            assert other[name] == pytest.approx(values, abs=1e-9 * np.abs(values).max()), name
        assert one["plane_work"][-1] != 0 and one["largest_overlap"].max() > 0


@pytest.mark.skipif("ellipse" not in MOTIONS, reason="docs/examples/ellipse.py is not loaded")
def test_an_ellipse_is_the_harmonic_motion_where_nothing_lags():
    def at(time: float, **given) -> np.ndarray:
        name = "ellipse" if given else "harmonic"
        belt = belt_vibration(point_of(name, "belt", phase=30, **given), 20.0)
        height, velocity = belt_states(belt, np.array([time]))
        return np.array([*height, *velocity[0]])

    usual, before = at(0.013), at(0.013 - 1 / 80)
    assert at(0.013, belt_lag=0) == pytest.approx(usual, rel=1e-12)
    assert at(0.013, belt_lag=90) == pytest.approx([usual[0], before[1], usual[2]], rel=1e-9)


@pytest.mark.skipif("saw" not in MOTIONS, reason="tests/data/motions.py is not loaded")
def test_a_saw_carries_a_bed_in_the_direction_of_its_slow_way():
    point = point_of("saw", **CONVEYOR, amplitude=0.3)
    drive = vibration(point_of("saw", amplitude=0.5, amplitude_along=0.8, running=0.2), GRAVITY)
    places = plane_position(drive, 0, np.array([0.0, 0.7, 1.0, 3.0]) / FREQUENCY) / 0.8e-3
    assert places == pytest.approx([0, 2 + 0.7 * 0.4 * pi, 0.4 * pi, 1.2 * pi], abs=1e-5)
    velocity = series_of(point)["mean_velocity"][-400:].mean()
    assert velocity > 0.02 * 0.3e-3 * 2 * pi * FREQUENCY
