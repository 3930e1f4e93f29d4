"""Motions of plug-ins: how belt or plane move, which the type of a motion's numbers tells."""

from math import pi
from typing import NamedTuple

import numpy as np

from sim.base.additions import fault
from sim.engine.compile import implements, inlined, kernel
from sim.engine.plugged import adopt, made, require_numbers
from sim.parameters import Parameters
from sim.parameters.choices import named
from sim.parameters.motions import MOTION

#: Parts of a cycle in which the velocity along x of a plug-in's motion is integrated, each by the
#: rule of Gauss and Legendre with these nodes.
PANELS = 1024
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)

#: How much, relative to the largest, what a motion says may differ a thousand cycles later, and
#: heights from what their derivative says.
ROUNDED, ROUGHLY = 1e-3, 0.02


def own_motion(p: Parameters) -> "NamedTuple | None":
    """Return the motion of a point, None where it is that of Talus."""
    option = getattr(p, MOTION.name, "")
    if not MOTION.is_own(option):
        return None
    motion = made(MOTION, option, add_motion, p)
    try:
        _require_sound(motion)
    except ValueError as error:
        raise fault(MOTION.name, named(option), error) from None
    return motion


def _require_sound(motion: NamedTuple) -> None:
    """Refuse a motion that is not finite, not of period 2π, or not as high as its derivative says.

    Raises ``ValueError``. As velocities may jump, derivatives bear out heights but roughly.
    """
    panel = 2.0 * pi / PANELS
    angles = (panel * np.arange(PANELS)[:, None] + 0.5 * panel * (1.0 + NODES)).ravel()
    cycles = [angles, *(angles + 2.0 * pi * turns for turns in (1, 1000))]
    first, *others = found = [states(motion, each) for each in cycles]
    for each, values in zip(cycles, found, strict=True):
        if not (known := np.isfinite(values).all(axis=0)).all():
            at, got = each[~known][0], values[:, ~known][:, 0].tolist()
            raise ValueError(f"what state returns at the angle {at:.4g} is not finite: {got}")
    most = np.abs(first).max(axis=1, keepdims=True)
    for each, values in zip(cycles[1:], others, strict=True):
        if not (same := (np.abs(values - first) <= ROUNDED * most).all(axis=0)).all():
            at, was = each[~same][0], angles[~same][0]
            raise ValueError(
                f"state has not the period 2π: at the angles {was:.4g} and {at:.4g} it returns "
                f"{first[:, ~same][:, 0].tolist()} and {values[:, ~same][:, 0].tolist()}"
            )
    climb = first[2].reshape(PANELS, NODES.size)
    climbed = np.cumsum(0.5 * panel * (climb * WEIGHTS).sum(axis=1))
    edges = states(motion, panel * np.arange(PANELS + 1))[0]
    raised = edges[1:] - edges[0]
    worst = int(np.argmax(np.abs(raised - climbed)))
    if not abs(raised[worst] - climbed[worst]) <= ROUGHLY * np.abs(first[[0, 2]]).max():
        raise ValueError(
            f"from 0 to the angle {panel * (worst + 1):.4g} the height that state returns changes "
            f"by {raised[worst]:.4g}, the integral of the derivative that it returns by "
            f"{climbed[worst]:.4g}"
        )


def shape_of(motion, angle):
    """Return what the function ``state`` of a plug-in does, see `sim.parameters.motions.motion`."""
    raise NotImplementedError


def given_by(motion, returned):
    """Return what ``state`` of a motion gives: three numbers."""
    raise NotImplementedError


def add_motion(kind, motion):
    """Make a type of parameters known as a motion, with the function of a plug-in for it."""
    if not adopt(kind):
        return
    own_state = inlined(motion.state)

    @implements(shape_of)
    def _shape(motion, angle):
        if motion.instance_class is not kind:
            return None
        return lambda motion, angle: given_by(motion, own_state(motion, angle))

    @implements(given_by)
    def _given(motion_, returned):
        if motion_.instance_class is not kind:
            return None
        require_numbers(motion.state, "what state returns", returned, 3)
        return lambda motion_, returned: returned


@kernel
def states(motion, angles):
    """Return what ``state`` gives at angles (K,): (3, K)."""
    found = np.empty((3, angles.size))
    for k in range(angles.size):
        height, along, upward = shape_of(motion, angles[k])
        found[0, k], found[1, k], found[2, k] = height, along, upward
    return found


@kernel
def heights(motion, angles):
    """Return how high a base is at angles (K,), in amplitudes."""
    found = np.empty(angles.size)
    for k in range(angles.size):
        found[k] = shape_of(motion, angles[k])[0]
    return found


@kernel
def ways(motion, angles):
    """Return how far a base has moved along x from angle 0 to others (K,), in amplitudes."""
    panel, way = 2.0 * pi / PANELS, np.zeros(PANELS + 1)
    for k in range(PANELS):
        way[k + 1] = way[k] + _way_within(motion, k * panel, panel)
    found = np.empty(angles.size)
    for i in range(angles.size):
        cycles = np.floor(angles[i] / (2.0 * pi))
        rest = angles[i] - cycles * 2.0 * pi
        k = min(int(rest / panel), PANELS - 1)
        part = _way_within(motion, k * panel, rest - k * panel)
        found[i] = cycles * way[PANELS] + way[k] + part
    return found


@inlined
def _way_within(motion, begin, length):
    """Return how far it moves along x in a short part of a cycle, in amplitudes."""
    way = 0.0
    for k in range(NODES.size):
        way += WEIGHTS[k] * shape_of(motion, begin + 0.5 * length * (1.0 + NODES[k]))[1]
    return 0.5 * length * way
