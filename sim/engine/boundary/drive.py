"""The drive of particles on a plane: gravity, and the motion of the plane.

Positions and velocities are relative to the plane, so contacts, bumps and neighbor list know
nothing of its motion. A plane with the velocity u adds the acceleration -du/dt to all free
particles. Gravity alone is a type of its own, whose compiled loop computes no motion.
"""

from math import cos, pi, radians, sin
from typing import Any, NamedTuple

import numpy as np

from sim.engine.boundary.motion import Harmonic, displacements, motion_of, shape_of, states
from sim.engine.compile import by_type, call_by_type, inlined
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.schedule import courses
from sim.parameters.spheres import SphereParameters


class Tilt(NamedTuple):
    """Gravity as it turns in the plane of x and z, which no acceleration of a frame goes with.

    ``strength`` (m/s²); (K,) numbers of ``steps`` after which the plane has ``angles`` (degrees),
    and gravity there ``along`` x and ``upward`` (m/s²). The angle is linear between them.
    """

    strength: float
    steps: np.ndarray
    angles: np.ndarray
    along: np.ndarray
    upward: np.ndarray


#: Gravity (m/s²) along x, y, z, or as it turns.
Pull = tuple[float, float, float] | Tilt


def constant_gravity(p: SphereParameters, angle: float) -> tuple[float, float, float]:
    """Return gravity (m/s²) along x, y, z on a plane with this inclination (degrees)."""
    slope = radians(angle)
    return p.gravity * sin(slope), 0.0, -p.gravity * cos(slope)


def tilt_of(p: SphereParameters, sample_steps: int) -> Tilt | None:
    """Return how gravity turns, between whole samples; None for a point without a schedule."""
    if not p.schedule:
        return None
    course = courses(p.schedule).get("angle", [(0.0, p.angle)])
    steps = [float(p.samples_in(time) * sample_steps) for time, _ in course]
    along, _, upward = zip(*(constant_gravity(p, angle) for _, angle in course), strict=True)
    angles = [angle for _, angle in course]
    return Tilt(p.gravity, *map(np.array, (steps, angles, along, upward)))


@inlined
def tilt_after(tilt, step):
    """Return the angle (degrees) after a number of steps, and gravity along x and z (m/s²)."""
    steps, angles = tilt.steps, tilt.angles
    k, last = 0, steps.size - 1
    while k < last and steps[k + 1] <= step:
        k += 1
    if k == last or step <= steps[0] or angles[k] == angles[k + 1]:
        # To the bit as on a plane that is never tilted.
        return angles[k], tilt.along[k], tilt.upward[k]
    share = (step - steps[k]) / (steps[k + 1] - steps[k])
    angle = angles[k] + share * (angles[k + 1] - angles[k])
    slope = angle * (pi / 180.0)
    return angle, tilt.strength * sin(slope), -tilt.strength * cos(slope)


@by_type
def gravity_in(pull, step):
    """Return gravity (m/s²) along x, y, z in a step."""
    if getattr(pull, "instance_class", None) is Tilt:
        return _turned_gravity
    return lambda pull, step: pull


def _turned_gravity(pull, step):
    _, along, upward = tilt_after(pull, step - 1)
    return along, 0.0, upward


class Gravity(NamedTuple):
    """``gravity`` as it pulls; the plane rests."""

    gravity: Pull


class Vibration(NamedTuple):
    """A plane that moves along x and z, each as a s(ωt), by the functions s of its ``motion``.

    ``gravity`` as it pulls; ``rate`` ω (1/s); ``amplitude`` a (m) along x and z; ``work`` (1,) of
    the plane on the particles (J), a sum over steps.
    """

    gravity: Pull
    rate: float
    amplitude: tuple[float, float]
    motion: NamedTuple
    work: np.ndarray


def vibration(p: ConveyorParameters, gravity: Pull) -> Vibration:
    """Return the vibration of a point under this gravity."""
    amplitude = (p.amplitude_along * p.diameter, p.amplitude * p.diameter)
    return Vibration(gravity, 2.0 * pi * p.frequency, amplitude, motion_of(p), np.zeros(1))


def plane_velocity(drive: Vibration, axis: int, time: Any) -> Any:
    """Return the velocity (m/s) of a vibrating plane along x (axis 0) or z (1)."""
    if isinstance(drive.motion, Harmonic):
        return _harmonic_velocity(drive.motion, drive, axis, time)
    rates = call_by_type(states, drive.motion, np.ravel(drive.rate * time))[1 + axis]
    return drive.amplitude[axis] * drive.rate * rates.reshape(np.shape(time))


def plane_position(drive: Vibration, axis: int, time: np.ndarray) -> np.ndarray:
    """Return the position (m) of a vibrating plane along x (axis 0) or z (1)."""
    angle, motion = drive.rate * time, drive.motion
    if isinstance(motion, Harmonic):
        first = drive.amplitude[axis] * np.sin(angle + motion.phase[axis])
        second = np.sin(motion.overtone * angle + motion.second_phase)
        return first + motion.second[axis] * second
    shapes = call_by_type(states if axis == 1 else displacements, motion, angle)
    return drive.amplitude[axis] * (shapes[0] if axis == 1 else shapes)


@by_type
def velocity_by(motion, drive, axis, time):
    """Return the velocity (m/s) of a plane by the type of its motion."""
    # Two frequencies are a sum that no function of one angle and one amplitude gives.
    return _harmonic_velocity if motion.instance_class is Harmonic else _velocity_by_shape


def _harmonic_velocity(motion, drive, axis, time):
    angle, second_rate = drive.rate * time, motion.overtone * drive.rate
    first = drive.amplitude[axis] * drive.rate * np.cos(angle + motion.phase[axis])
    second = second_rate * np.cos(motion.overtone * angle + motion.second_phase)
    return first + motion.second[axis] * second


def _velocity_by_shape(motion, drive, axis, time):
    _, along, upward = shape_of(motion, drive.rate * time)
    return drive.amplitude[axis] * drive.rate * (upward if axis == 1 else along)


@by_type
def acceleration(drive, step, time_step):
    """Return the acceleration (m/s²) along x, y, z of a particle without contacts, in a step.

    It takes velocities from half a step before the time of the last step to half a step after it.
    """
    if drive.instance_class is Gravity:
        return lambda drive, step, time_step: gravity_in(drive.gravity, step)
    return _frame_acceleration


@inlined
def _velocities_around(drive, axis, step, time_step):
    """Return the velocities (m/s) of the plane half a step before and after a step's forces."""
    before, after = (step - 1.5) * time_step, (step - 0.5) * time_step
    motion = drive.motion
    return velocity_by(motion, drive, axis, before), velocity_by(motion, drive, axis, after)


def _frame_acceleration(drive, step, time_step):
    gx, gy, gz = gravity_in(drive.gravity, step)
    x_before, x_after = _velocities_around(drive, 0, step, time_step)
    z_before, z_after = _velocities_around(drive, 1, step, time_step)
    return gx - (x_after - x_before) / time_step, gy, gz - (z_after - z_before) / time_step


@by_type
def note_work(drive, step, time_step, along, upward):
    """Add the work of a moving plane that pushes with a force along x and z (N) in a step."""
    if drive.instance_class is Gravity:
        return lambda drive, step, time_step, along, upward: None
    return _add_work


def _add_work(drive, step, time_step, along, upward):
    x_before, x_after = _velocities_around(drive, 0, step, time_step)
    z_before, z_after = _velocities_around(drive, 1, step, time_step)
    ux, uz = 0.5 * (x_before + x_after), 0.5 * (z_before + z_after)
    drive.work[0] += (along * ux + upward * uz) * time_step
