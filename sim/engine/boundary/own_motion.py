"""Motions of plug-ins: how belt or plane move, which the type of a motion's numbers tells."""

from math import pi
from typing import NamedTuple

import numpy as np

from sim.engine.compile import implements, inlined, kernel
from sim.engine.plugged import adopt, made
from sim.parameters import Parameters
from sim.parameters.motions import MOTION

#: Parts of a cycle in which the velocity along x of a plug-in's motion is integrated, each by the
#: rule of Gauss and Legendre with these nodes.
PANELS = 1024
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def own_motion(p: Parameters) -> "NamedTuple | None":
    """Return the motion of a point, None where it is that of Talus."""
    motion = getattr(p, MOTION.name, "")
    return made(MOTION, motion, add_motion, p) if MOTION.is_own(motion) else None


def shape_of(motion, angle):
    """Return what the function ``state`` of a plug-in does, see `sim.parameters.motions.motion`."""
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
        return lambda motion, angle: own_state(motion, angle)


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
