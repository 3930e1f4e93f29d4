"""Settled beds as linear systems: contact network, damping rates, and growth under a time step.

Rates are those of the equations of motion about the settled state, M x" = -K x - C x', with the
contacts that it has: a bed that rests or moves with the belt as a block. That contacts also push
sideways is left out: it lets a bead perched on another fall off, which is no corrector's fault.
"""

from math import exp, log, sqrt
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from benchmarks.stability.amplification import Corrector
from sim.engine.systems import build
from sim.parameters import BeltParameters

#: Steps of a random motion that tell its growth, and the factor per step that means none.
STEPS = 1000
STILL = 1.003


class Rates(NamedTuple):
    """A bed about its rest: ``stiff``, M⁻¹K (1/s²), and ``damped``, M⁻¹C (1/s), (2N, 2N).

    The coordinates are x and z of each bead in turn.
    """

    stiff: csr_matrix
    damped: csr_matrix


class Contacts(NamedTuple):
    """Contacts, one row each; that with the belt has ``second`` equal to ``first``.

    ``normal`` (C, 2) from the first to its partner; ``share`` (C, 2) of its own mass by which each
    partner's damping counts.
    """

    first: np.ndarray
    second: np.ndarray
    normal: np.ndarray
    share: np.ndarray


class Bed(NamedTuple):
    """A settled bed: ``position`` (N, 2) and ``radius`` (N,) in m, ``mass`` (N,) in kg."""

    position: np.ndarray
    radius: np.ndarray
    mass: np.ndarray


def settled(parameters: BeltParameters, replicate: int = 0) -> Bed:
    """Return the bed of a replicate at rest, before the shaking starts."""
    system = build(parameters, replicate)
    system.settle()
    state = system.snapshot()
    mass = parameters.mass * (2.0 * state["radius"] / parameters.diameter) ** 2
    return Bed(state["position"], state["radius"], mass)


def contacts(parameters: BeltParameters, bed: Bed) -> Contacts:
    """Return all contacts of a bed, those between beads before those with the belt."""
    p, width = parameters, parameters.width * parameters.diameter
    first, second = np.triu_indices(len(bed.radius), 1)
    apart = bed.position[second] - bed.position[first]
    apart[:, 0] -= width * np.round(apart[:, 0] / width)
    distance = np.hypot(*apart.T)
    near = distance < bed.radius[first] + bed.radius[second]
    first, second = first[near], second[near]
    normal = apart[near] / distance[near, None]
    surface = 0.5 * p.diameter if p.belt_ghost == "centred" else 0.0
    (resting,) = np.nonzero(bed.position[:, 1] < bed.radius + surface)
    down = np.tile([0.0, -1.0], (resting.size, 1))
    return Contacts(
        np.concatenate([first, resting]),
        np.concatenate([second, resting]),
        np.concatenate([normal, down]),
        np.concatenate([_shares(p, bed.mass[first], bed.mass[second]), _at_belt(p, bed, resting)]),
    )


def _shares(p: BeltParameters, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    if p.damping_mass == "own":
        return np.ones((len(one), 2))
    return np.stack([other, one], axis=1) / (one + other)[:, None]


def _at_belt(p: BeltParameters, bed: Bed, resting: np.ndarray) -> np.ndarray:
    share = np.ones((resting.size, 2))
    if p.ghost_mass == "mean":
        share /= (1.0 + bed.mass[resting] / p.mass)[:, None]
    return share


def rates(parameters: BeltParameters, bed: Bed) -> Rates:
    """Return stiffness and damping of a bed by the laws of a point."""
    p, found = parameters, contacts(parameters, bed)
    along = np.einsum("ca,cb->cab", found.normal, found.normal)
    across = np.eye(2) - along
    spring = p.stiffness * p.gravity * p.mass / p.diameter
    stiff, damped = spring * along, p.normal_damping * along
    damped = damped + p.shear_damping * p.gravity * across
    mass = bed.mass
    inverse = np.stack([1.0 / mass[found.first], 1.0 / mass[found.second]], axis=1)
    size = len(mass)
    return Rates(
        _assembled(found, stiff, inverse, size), _assembled(found, damped, found.share, size)
    )


def _assembled(found: Contacts, blocks: np.ndarray, weight: np.ndarray, beads: int) -> csr_matrix:
    """Return the matrix (2N, 2N) of what contacts, a block (2, 2) each, do to both partners."""
    pair = found.first != found.second
    rows, columns, values = [], [], []
    for one, other, share, there in (
        (found.first, found.second, weight[:, 0], slice(None)),
        (found.second, found.first, weight[:, 1], pair),
    ):
        i, j, push = one[there], other[there], (share[:, None, None] * blocks)[there]
        for a in range(2):
            for b in range(2):
                rows += [2 * i + a, (2 * i + a)[pair[there]]]
                columns += [2 * i + b, (2 * j + b)[pair[there]]]
                values += [push[:, a, b], -push[pair[there], a, b]]
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_matrix(entries, shape=(2 * beads, 2 * beads))


def largest(matrix: csr_matrix) -> float:
    """Return the largest eigenvalue of M⁻¹K or M⁻¹C, which are real."""
    return float(np.linalg.eigvals(matrix.toarray()).real.max())


def growth(corrector: Corrector, bed_rates: Rates, time_step: float) -> float:
    """Return the factor by which a step (s) enlarges the fastest growing motion of a bed.

    From the second half of `STEPS` steps of a random motion. Motions without resistance grow as a
    power of time, so 1.003 and less mean no growth.
    """
    spring, drag = bed_rates.stiff * time_step**2, bed_rates.damped * time_step

    def acceleration(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return -(spring @ x) - drag @ v

    shape = corrector.terms, bed_rates.stiff.shape[0]
    taylor, grown = np.random.default_rng(1).normal(size=shape), 0.0
    for step in range(STEPS):
        taylor = corrector.step(taylor, acceleration)
        size = float(np.linalg.norm(taylor))
        grown += log(size) if 2 * step >= STEPS else 0.0
        taylor /= size
    return exp(grown / (STEPS - STEPS // 2))


def lowest_frequency(corrector: Corrector, bed_rates: Rates, steps_per_cycle: int = 2000) -> float:
    """Return the frequency (Hz) above which the step 1/(2000 f) lets nothing in a bed grow."""
    low, high = 2.0, 500.0
    while high / low > 1.02:
        middle = sqrt(low * high)
        if growth(corrector, bed_rates, 1.0 / (steps_per_cycle * middle)) > STILL:
            low = middle
        else:
            high = middle
    return sqrt(low * high)
