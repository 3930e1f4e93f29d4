"""Integrators of the disks: Gear's predictor-corrector of fifth order and velocity Verlet.

Both act on the Taylor terms of ``Disks`` and have the same two halves around the evaluation of the
forces. Coefficients: Allen and Tildesley, Computer Simulation of Liquids (1987), appendix E, for
equations of second order whose forces depend on the velocity.
"""

from typing import NamedTuple

import numpy as np

from sim.compile import implements, inlined
from sim.dynamics.disks import TERMS

#: Corrector coefficients of the Taylor terms 0 to 5.
CORRECTOR = (3.0 / 16.0, 251.0 / 360.0, 1.0, 11.0 / 18.0, 1.0 / 6.0, 1.0 / 60.0)


class Gear(NamedTuple):
    """Gear's predictor-corrector with six values."""

    time_step: float


class Verlet(NamedTuple):
    """Velocity Verlet; forces see the velocity predicted with the old acceleration."""

    time_step: float


def predict(integrator, taylor):
    """Advance the Taylor terms by one step without knowing the new forces."""
    raise NotImplementedError


def correct(integrator, taylor, i, d, acceleration):
    """Correct coordinate d of disk i for its new acceleration (m/s²)."""
    raise NotImplementedError


@inlined
def _predict_gear(taylor):
    q0, q1, q2, q3, q4, q5 = taylor[0], taylor[1], taylor[2], taylor[3], taylor[4], taylor[5]
    for i in range(taylor.shape[1]):
        for d in range(2):
            c, e, f, g = q2[i, d], q3[i, d], q4[i, d], q5[i, d]
            q0[i, d] += q1[i, d] + c + e + f + g
            q1[i, d] += 2.0 * c + 3.0 * e + 4.0 * f + 5.0 * g
            q2[i, d] = c + 3.0 * e + 6.0 * f + 10.0 * g
            q3[i, d] = e + 4.0 * f + 10.0 * g
            q4[i, d] = f + 5.0 * g


@inlined
def _predict_verlet(taylor):
    for i in range(taylor.shape[1]):
        for d in range(2):
            taylor[0, i, d] += taylor[1, i, d] + taylor[2, i, d]
            taylor[1, i, d] += 2.0 * taylor[2, i, d]


@implements(predict)
def _predict(integrator, taylor):
    if integrator.instance_class is Gear:
        return lambda integrator, taylor: _predict_gear(taylor)
    return lambda integrator, taylor: _predict_verlet(taylor)


@inlined
def _correct_gear(integrator, taylor, i, d, acceleration):
    error = 0.5 * acceleration * integrator.time_step**2 - taylor[2, i, d]
    taylor[0, i, d] += CORRECTOR[0] * error
    taylor[1, i, d] += CORRECTOR[1] * error
    taylor[2, i, d] += error
    taylor[3, i, d] += CORRECTOR[3] * error
    taylor[4, i, d] += CORRECTOR[4] * error
    taylor[5, i, d] += CORRECTOR[5] * error


@inlined
def _correct_verlet(integrator, taylor, i, d, acceleration):
    half = 0.5 * acceleration * integrator.time_step**2
    taylor[1, i, d] += half - taylor[2, i, d]
    taylor[2, i, d] = half


@implements(correct)
def _correct(integrator, taylor, i, d, acceleration):
    if integrator.instance_class is Gear:
        return lambda integrator, taylor, i, d, acceleration: _correct_gear(
            integrator, taylor, i, d, acceleration
        )
    return lambda integrator, taylor, i, d, acceleration: _correct_verlet(
        integrator, taylor, i, d, acceleration
    )


@inlined
def flush(taylor):
    """Set vanishing higher terms to zero.

    In free flight Gear's higher terms decay geometrically into the subnormal numbers, which
    processors handle many times slower.
    """
    for k in range(2, TERMS):
        for i in range(taylor.shape[1]):
            for d in range(2):
                if abs(taylor[k, i, d]) < 1e-200:
                    taylor[k, i, d] = 0.0


def restarted(taylor: np.ndarray, old_step: float, new_step: float) -> None:
    """Rescale the Taylor terms in place for another time step."""
    for k in range(len(taylor)):
        taylor[k] *= (new_step / old_step) ** k
