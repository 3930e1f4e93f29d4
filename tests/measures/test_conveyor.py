"""Measures of a vibrating plane: its acceleration over gravity, and its transport."""

import numpy as np
import pytest

from sim.engine.boundary.drive import plane_position, plane_velocity, vibration
from sim.parameters import ConveyorParameters
from tests.measures.measuring import measured


def make_run(point: ConveyorParameters, velocity: float) -> dict:
    """Return the arrays of a replicate with a velocity (m/s) that the measures need."""
    limits = {name: value for name, (value, _) in point.limits.items()}
    return point.model_dump() | limits | {"velocity": velocity}


def cycle_and_drive(point: ConveyorParameters):
    """Return the times (s) of a cycle and the drive of the plane."""
    return np.linspace(0, 1 / point.frequency, 20_001), vibration(point, (0, 0, -point.gravity))


def test_the_shaking_strength_is_the_largest_acceleration_along_z_over_gravity():
    point = ConveyorParameters(frequency=23, amplitude=0.7, amplitude_along=0.2, phase_along=50)
    time, drive = cycle_and_drive(point)
    velocity = np.gradient(plane_position(drive, 1, time), time)
    largest = np.abs(np.gradient(velocity, time)[5:-5]).max()
    found = measured(make_run(point, 0.1), "conveyor")["shaking_strength"]
    assert found == pytest.approx(largest / point.gravity, rel=1e-3)


def test_what_goes_as_fast_as_the_plane_at_its_fastest_is_transported_wholly():
    point = ConveyorParameters(frequency=23, amplitude=0.7, amplitude_along=0.2, phase_along=50)
    time, drive = cycle_and_drive(point)
    fastest = plane_velocity(drive, 0, time).max()
    assert measured(make_run(point, fastest), "conveyor")["transport_efficiency"] == pytest.approx(
        1, rel=1e-6
    )
    assert measured(make_run(point, -fastest), "conveyor")["transport_efficiency"] == pytest.approx(
        -1, rel=1e-6
    )


def test_a_plane_that_moves_up_and_down_alone_has_no_efficiency():
    point = ConveyorParameters(amplitude_along=0)
    assert set(measured(make_run(point, 0.0), "conveyor")) == {"shaking_strength"}
