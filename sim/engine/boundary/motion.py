"""Motions of belt and plane; the type of a motion's numbers selects its compiled function."""

from collections.abc import Callable
from math import cos, pi, sin
from typing import Any, NamedTuple

import numpy as np

from sim.base.additions import plain_name, plugin_error
from sim.engine.compile import (
    by_type,
    call_by_type,
    inlined,
    inlined_with_calls,
    kernel,
    make_numbers,
    require_numbers,
)
from sim.parameters import Parameters
from sim.parameters.laws import MOTION

#: Parts of a cycle in which the velocity along x of a plug-in's motion is integrated, each by the
#: rule of Gauss and Legendre with these nodes.
PANELS = 1024
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)

#: Differences allowed relative to the largest value: of a motion from itself a thousand cycles
#: later, and of heights from the integral of their derivative.
PERIOD_TOLERANCE, HEIGHT_TOLERANCE = 1e-3, 0.02

#: The functions ``state`` of plug-ins' motions, by the types of their numbers.
_states: dict[type, Callable[..., Any]] = {}


class Harmonic(NamedTuple):
    """The harmonic motion, a sin(ωt + φ); that of a plane may have a second frequency.

    A plane adds b sin(kωt + ψ), with ``overtone`` k and for x and z ``phase`` φ (rad) and
    ``second`` b (m); ``second_phase`` ψ (rad) is that of both.
    """

    overtone: float = 1.0
    phase: tuple[float, float] = (0.0, 0.0)
    second: tuple[float, float] = (0.0, 0.0)
    second_phase: float = 0.0


def motion_of(p: Parameters) -> NamedTuple:
    """Return the motion of a point."""
    motion = make_numbers(MOTION, p, lambda kind, one: _states.update({kind: one.state}), p)
    if MOTION.is_own(option := getattr(p, MOTION.name, "")):
        try:
            _require_sound(motion)
        except ValueError as error:
            raise plugin_error(MOTION.name, plain_name(option), error) from None
    return motion


def _require_sound(motion: NamedTuple) -> None:
    """Refuse a motion that is not finite, not of period 2π, or not as high as its derivative says.

    Raises ``ValueError``. Velocities may jump, so heights follow from derivatives only roughly.
    """
    panel = 2.0 * pi / PANELS
    angles = (panel * np.arange(PANELS)[:, None] + 0.5 * panel * (1.0 + NODES)).ravel()
    cycles = [angles, *(angles + 2.0 * pi * turns for turns in (1, 1000))]
    first, *later = results = [call_by_type(states, motion, cycle) for cycle in cycles]
    for cycle, values in zip(cycles, results, strict=True):
        if not (is_finite := np.isfinite(values).all(axis=0)).all():
            angle, state = cycle[~is_finite][0], values[:, ~is_finite][:, 0].tolist()
            raise ValueError(f"what state returns at the angle {angle:.4g} is not finite: {state}")
    largest = np.abs(first).max(axis=1, keepdims=True)
    for cycle, values in zip(cycles[1:], later, strict=True):
        is_same = (np.abs(values - first) <= PERIOD_TOLERANCE * largest).all(axis=0)
        if not is_same.all():
            angle, first_angle = cycle[~is_same][0], angles[~is_same][0]
            raise ValueError(
                f"state has not the period 2π: at the angles {first_angle:.4g} and {angle:.4g} it "
                f"returns {first[:, ~is_same][:, 0].tolist()} and "
                f"{values[:, ~is_same][:, 0].tolist()}"
            )
    slope = first[2].reshape(PANELS, NODES.size)
    integral = np.cumsum(0.5 * panel * (slope * WEIGHTS).sum(axis=1))
    height = call_by_type(states, motion, panel * np.arange(PANELS + 1))[0]
    rise = height[1:] - height[0]
    worst = int(np.argmax(np.abs(rise - integral)))
    if not abs(rise[worst] - integral[worst]) <= HEIGHT_TOLERANCE * np.abs(first[[0, 2]]).max():
        raise ValueError(
            f"from 0 to the angle {panel * (worst + 1):.4g} the height that state returns changes "
            f"by {rise[worst]:.4g}, the integral of the derivative that it returns by "
            f"{integral[worst]:.4g}"
        )


@by_type
def shape_of(motion, angle):
    """Return the result of a motion's function ``state``, see `sim.parameters.laws.motion`."""
    if motion.instance_class is Harmonic:
        return lambda motion, angle: (sin(angle), cos(angle), cos(angle))
    state = inlined_with_calls(_states[motion.instance_class])
    return lambda motion, angle: checked_state(motion, state(motion, angle))


@by_type
def checked_state(motion, returned):
    """Return the result of a motion's ``state``; refuse other than three numbers when compiled."""
    require_numbers(_states[motion.instance_class], "what state returns", returned, 3)
    return lambda motion, returned: returned


@kernel
def states(motion, angles):
    """Return the results (3, K) of ``state`` at angles (K,)."""
    results = np.empty((3, angles.size))
    for k in range(angles.size):
        results[0, k], results[1, k], results[2, k] = shape_of(motion, angles[k])
    return results


@kernel
def displacements(motion, angles):
    """Return how far a base has moved along x from angle 0 to others (K,), in amplitudes."""
    panel, path = 2.0 * pi / PANELS, np.zeros(PANELS + 1)
    for k in range(PANELS):
        path[k + 1] = path[k] + _displacement_within(motion, k * panel, panel)
    displacement = np.empty(angles.size)
    for i in range(angles.size):
        cycles = np.floor(angles[i] / (2.0 * pi))
        rest = angles[i] - cycles * 2.0 * pi
        k = min(int(rest / panel), PANELS - 1)
        part = _displacement_within(motion, k * panel, rest - k * panel)
        displacement[i] = cycles * path[PANELS] + path[k] + part
    return displacement


@inlined
def _displacement_within(motion, begin, length):
    """Return how far a base moves along x in a short part of a cycle, in amplitudes."""
    displacement = 0.0
    for k in range(NODES.size):
        displacement += WEIGHTS[k] * shape_of(motion, begin + 0.5 * length * (1.0 + NODES[k]))[1]
    return 0.5 * length * displacement
