"""Motions: the harmonic one as a plug-in has it, and a sawtooth.

That goes to and fro in shares q and 1 - q of a cycle along x, up and down in equal ones, each way
half a wave of a cosine; its base may also go along at a constant velocity.
"""

from math import cos, pi, sin
from typing import NamedTuple

import sim


class Sine(NamedTuple):
    """Nothing to know."""


class Saw(NamedTuple):
    """Share of the way forth, and the constant velocity."""

    share: float
    running: float


def sine(motion, angle):
    """Return height and velocities of the harmonic motion."""
    return sin(angle), cos(angle), cos(angle)


def half_wave(angle, whole):
    """Return the velocity at an angle of a way that takes the ``whole``."""
    return pi / whole * sin(pi * angle / whole)


def saw(motion, angle):
    """Return height and velocities of the sawtooth."""
    way, whole = angle % (2 * pi), 2 * pi * motion.share
    along = half_wave(way, whole) if way < whole else -half_wave(way - whole, 2 * pi - whole)
    return -cos(way), along + motion.running, sin(way)


sim.motion("sine", make=lambda p: Sine(), state=sine)
sim.motion(
    "saw",
    make=lambda p: Saw(p.share, p.running),
    state=saw,
    parameters={
        "share": sim.parameter(0.7, unit="1", description="share of the way forth", gt=0, lt=1),
        "running": sim.parameter(0, unit="1", description="constant velocity"),
    },
)
