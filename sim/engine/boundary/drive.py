"""The drive of particles on a plane: gravity, and the motion of the plane.

Positions and velocities are relative to the plane, so contacts, bumps and neighbor list know
nothing of its motion. A plane with the velocity u adds the acceleration -du/dt to all free
particles. Gravity alone is a type of its own, whose compiled loop computes no motion. The plane
moves harmonically, at one or two frequencies, or by the motion of a plug-in.
"""

from math import pi, radians
from typing import NamedTuple

import numpy as np

from sim.engine.boundary.own_motion import displacements, heights, own_motion, shape_of
from sim.engine.compile import implements, inlined, kernel
from sim.parameters.conveyor import ConveyorParameters


class Gravity(NamedTuple):
    """``gravity`` (m/s²) along x, y, z; the plane rests."""

    gravity: tuple[float, float, float]


class Vibration(NamedTuple):
    """A plane that moves along x and z, each as a sin(ωt + φ) + b sin(kωt + ψ).

    ``gravity`` (m/s²); ``rate`` ω (1/s) and ``overtone`` k; for x and z ``amplitude`` a (m) with
    ``phase`` φ (rad) and ``second`` b (m) with the ``second_phase`` ψ (rad) of both; ``work`` (1,)
    of the plane on the particles (J), a sum over steps.
    """

    gravity: tuple[float, float, float]
    rate: float
    overtone: float
    amplitude: tuple[float, float]
    phase: tuple[float, float]
    second: tuple[float, float]
    second_phase: float
    work: np.ndarray


class OwnVibration(NamedTuple):
    """A plane with the motion of a plug-in: x = A_x s_x(ωt), z = A_z s_z(ωt).

    The type of ``motion``, the plug-in's parameters, selects s_x and s_z; all else as in
    `Vibration`.
    """

    gravity: tuple[float, float, float]
    rate: float
    amplitude: tuple[float, float]
    motion: NamedTuple
    work: np.ndarray


def vibration(
    p: ConveyorParameters, gravity: tuple[float, float, float]
) -> Vibration | OwnVibration:
    """Return the vibration of a point under this gravity (m/s²)."""
    sigma, rate, motion = p.diameter, 2.0 * pi * p.frequency, own_motion(p)
    amplitude = (p.amplitude_along * sigma, p.amplitude * sigma)
    if motion is not None:
        return OwnVibration(gravity, rate, amplitude, motion, np.zeros(1))
    return Vibration(
        gravity,
        rate,
        float(p.overtone),
        amplitude,
        (radians(p.phase_along), 0.0),
        (p.overtone_along * sigma, p.overtone_amplitude * sigma),
        radians(p.overtone_phase),
        np.zeros(1),
    )


def plane_velocity(drive, axis, time):
    """Return the velocity (m/s) of a vibrating plane along x (axis 0) or z (1)."""
    if isinstance(drive, Vibration):
        return _harmonic_velocity(drive, axis, time)
    return _own_velocities(drive, axis, np.ravel(time)).reshape(np.shape(time))


@implements(plane_velocity)
def _plane_velocity(drive, axis, time):
    return _harmonic_velocity if drive.instance_class is Vibration else _own_velocity


def _harmonic_velocity(drive, axis, time):
    angle, second_rate = drive.rate * time, drive.overtone * drive.rate
    first = drive.amplitude[axis] * drive.rate * np.cos(angle + drive.phase[axis])
    second = second_rate * np.cos(drive.overtone * angle + drive.second_phase)
    return first + drive.second[axis] * second


def _own_velocity(drive, axis, time):
    _, along, upward = shape_of(drive.motion, drive.rate * time)
    return drive.amplitude[axis] * drive.rate * (upward if axis == 1 else along)


@kernel
def _own_velocities(drive, axis, times):
    velocities = np.empty(times.size)
    for k in range(times.size):
        velocities[k] = plane_velocity(drive, axis, times[k])
    return velocities


def plane_position(drive: Vibration | OwnVibration, axis: int, time: np.ndarray) -> np.ndarray:
    """Return the position (m) of a vibrating plane along x (axis 0) or z (1)."""
    angle = drive.rate * time
    if isinstance(drive, OwnVibration):
        shape = heights if axis == 1 else displacements
        return drive.amplitude[axis] * shape(drive.motion, angle)
    first = drive.amplitude[axis] * np.sin(angle + drive.phase[axis])
    return first + drive.second[axis] * np.sin(drive.overtone * angle + drive.second_phase)


def acceleration(drive, step, time_step):
    """Return the acceleration (m/s²) along x, y, z of a particle without contacts, in a step.

    It takes velocities from half a step before the time of the last step to half a step after it.
    """
    raise NotImplementedError


@implements(acceleration)
def _acceleration(drive, step, time_step):
    if drive.instance_class is Gravity:
        return lambda drive, step, time_step: drive.gravity
    return lambda drive, step, time_step: _frame_acceleration(drive, step, time_step)


@inlined
def _velocities_around(drive, axis, step, time_step):
    """Return the velocities (m/s) of the plane half a step before and after a step's forces."""
    before, after = (step - 1.5) * time_step, (step - 0.5) * time_step
    return plane_velocity(drive, axis, before), plane_velocity(drive, axis, after)


@inlined
def _frame_acceleration(drive, step, time_step):
    gx, gy, gz = drive.gravity
    x_before, x_after = _velocities_around(drive, 0, step, time_step)
    z_before, z_after = _velocities_around(drive, 1, step, time_step)
    return gx - (x_after - x_before) / time_step, gy, gz - (z_after - z_before) / time_step


def note_work(drive, step, time_step, along, upward):
    """Add the work of a moving plane that pushes with a force along x and z (N) in a step."""
    raise NotImplementedError


@implements(note_work)
def _note_work(drive, step, time_step, along, upward):
    if drive.instance_class is Gravity:
        return lambda drive, step, time_step, along, upward: None
    return lambda drive, step, time_step, along, upward: _add_work(
        drive, step, time_step, along, upward
    )


@inlined
def _add_work(drive, step, time_step, along, upward):
    x_before, x_after = _velocities_around(drive, 0, step, time_step)
    z_before, z_after = _velocities_around(drive, 1, step, time_step)
    ux, uz = 0.5 * (x_before + x_after), 0.5 * (z_before + z_after)
    drive.work[0] += (along * ux + upward * uz) * time_step
