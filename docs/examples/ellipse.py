"""A motion of belt or conveyor: an ellipse, gone round once in a cycle, as in feeders."""

from math import cos, radians, sin
from typing import NamedTuple

import talus


class Ellipse(NamedTuple):
    """Lag (rad) of the motion along the base behind that across it."""

    lag: float


def make(p):
    """Return the motion of a point."""
    return Ellipse(radians(p.belt_lag))


def state(motion, angle):
    """Compiled: the height in amplitudes, and how x and z change with the angle."""
    return sin(angle), cos(angle - motion.lag), cos(angle)


talus.motion(
    "ellipse",
    description="an ellipse, gone round once in a cycle",
    make=make,
    state=state,
    parameters={
        "belt_lag": talus.parameter(
            90, unit="degree", description="lag of the motion along the base", ge=-180, le=180
        )
    },
)
