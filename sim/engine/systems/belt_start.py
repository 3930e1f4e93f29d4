"""The initial state of a belt: beads at random above it, and the stages until they are shaken."""

from math import pi, radians, tan
from typing import NamedTuple

import numpy as np

from sim.engine.boundary.belt import Belt, OwnBelt, belt_height
from sim.engine.boundary.own_motion import own_motion
from sim.engine.dynamics.cells import Box
from sim.engine.dynamics.gear import CORRECTORS, Gear, Verlet
from sim.engine.systems.packing import random_packing
from sim.parameters import BeltParameters

#: Area fraction of the random initial state; random sequential addition saturates near 0.55.
INITIAL_PACKING = 0.3

#: Stages before the first sample, and that of the samples.
FALLING, PRIOR_SHAKING, SHAKING = "falling", "shaken before", ""


class Bed(NamedTuple):
    """Beads at rest that fall: ``position`` (N, 2), ``radius``, ``mass`` (N,), SI.

    ``height`` (m) is that of the filled region.
    """

    position: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    height: float


def initial_bed(p: BeltParameters, box: Box, replicate: int) -> Bed:
    """Return beads of a replicate that overlap neither each other nor belt nor obstacle."""
    rng = np.random.default_rng([p.seed, replicate])
    spread = p.diameter_spread * p.diameter
    diameter = rng.uniform(p.diameter - spread, p.diameter + spread, p.beads)
    mass = p.mass * (diameter / p.diameter) ** 2
    layer = (pi / 4.0 * diameter**2).sum() / (INITIAL_PACKING * box.length[0])
    height = max(layer, p.diameter + spread)
    position = random_packing(box, height, 0.5 * diameter, rng)
    position[:, 1] += _lift(p)
    return Bed(position, 0.5 * diameter, mass, height)


def _lift(p: BeltParameters) -> float:
    """Return how far (m) to raise the beads so that none overlaps the belt or the obstacle."""
    belt = vibration(p, 0.0)
    lift = belt_height(belt, 0.0) + belt.surface
    if p.obstacle > 0.0:
        lift = max(lift, (p.amplitude + 0.5 * p.obstacle) * p.diameter)
    return lift


def vibration(p: BeltParameters, frequency: float) -> Belt | OwnBelt:
    """Return the belt vibrating at a frequency (Hz), or at rest in its initial phase."""
    amplitude = p.amplitude * p.diameter
    # Not tan(90°), which rounds to a finite number: a vertical vibration has A_x = 0.
    slope = tan(radians(p.vibration_angle)) if p.vibration_angle < 90.0 else np.inf
    surface = 0.5 * p.diameter if p.belt_ghost == "centred" else 0.0
    belt = Belt(
        amplitude / slope,
        amplitude,
        2.0 * pi * frequency,
        radians(p.phase),
        surface,
        inverse_mass=1.0 / p.mass if p.ghost_mass == "mean" else 0.0,
    )
    motion = own_motion(p)
    return belt if motion is None else OwnBelt(*belt, motion)


class Stage(NamedTuple):
    """How the bed moves in a stage: the ``belt``, the ``integrator``, the words for messages."""

    belt: Belt | OwnBelt
    integrator: Gear | Verlet
    words: str


def make_stages(
    p: BeltParameters, settling_step: float, time_step: float, cycle_steps: int
) -> dict[str, Stage]:
    """Return the stages of a point: steps (s) of settling and shaking, steps in a cycle."""
    stages = {
        FALLING: _stage(p, 0.0, settling_step, "while the bed settles"),
        SHAKING: _stage(p, p.frequency, time_step, "of the shaking"),
    }
    if frequency := p.prior_frequency:
        words, step = "of the shaking at the prior frequency", 1.0 / (frequency * cycle_steps)
        stages[PRIOR_SHAKING] = _stage(p, frequency, step, words)
    return stages


def _stage(p: BeltParameters, frequency: float, time_step: float, words: str) -> Stage:
    step = float(time_step)
    verlet = p.integrator == "verlet"
    integrator = Verlet(step) if verlet else Gear(step, CORRECTORS[p.corrector_order])
    return Stage(vibration(p, frequency), integrator, words)
