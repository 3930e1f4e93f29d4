"""Integrators of the disks: Gear's predictor-corrector and velocity Verlet.

Both act on the Taylor terms of ``Disks``: they predict before the forces are evaluated and correct
after it. Gear's can correct again, with forces at the corrected positions and velocities.
Coefficients: Allen and Tildesley, Computer Simulation of Liquids (1987), appendix E, for equations
of second order whose forces depend on the velocity.
"""

from typing import NamedTuple

import numpy as np

from sim.engine.compile import implements, inlined
from sim.engine.dynamics.disks import TERMS

#: Corrector coefficients of the Taylor terms 0 to 5 by order. Terms above the order stay zero.
CORRECTORS = {
    3: (1.0 / 6.0, 5.0 / 6.0, 1.0, 1.0 / 3.0, 0.0, 0.0),
    4: (19.0 / 90.0, 3.0 / 4.0, 1.0, 1.0 / 2.0, 1.0 / 12.0, 0.0),
    5: (3.0 / 16.0, 251.0 / 360.0, 1.0, 11.0 / 18.0, 1.0 / 6.0, 1.0 / 60.0),
}

#: Taylor terms (m) below this are set to zero every few steps.
VANISHING = 1e-200


class Gear(NamedTuple):
    """Gear's predictor-corrector; ``coefficients`` of its corrector are one of `CORRECTORS`."""

    time_step: float
    coefficients: tuple[float, ...] = CORRECTORS[5]


class Verlet(NamedTuple):
    """Velocity Verlet; forces see the velocity predicted with the old acceleration."""

    time_step: float


def predict(integrator, taylor):
    """Advance the Taylor terms by one step without knowing the new forces."""
    raise NotImplementedError


def correct(integrator, taylor, d, i, acceleration):
    """Correct coordinate d of disk i for its new acceleration (m/s²)."""
    raise NotImplementedError


@inlined
def _predict_gear(taylor):
    terms = taylor.reshape(TERMS, taylor[0].size)
    q0, q1, q2, q3, q4, q5 = terms[0], terms[1], terms[2], terms[3], terms[4], terms[5]
    for i in range(q0.size):
        b, c, e, f, g = q1[i], q2[i], q3[i], q4[i], q5[i]
        q0[i] += b + c + e + f + g
        q1[i] = b + 2.0 * c + 3.0 * e + 4.0 * f + 5.0 * g
        q2[i] = c + 3.0 * e + 6.0 * f + 10.0 * g
        q3[i] = e + 4.0 * f + 10.0 * g
        q4[i] = f + 5.0 * g


@inlined
def _predict_verlet(taylor):
    terms = taylor.reshape(TERMS, taylor[0].size)
    q0, q1, q2 = terms[0], terms[1], terms[2]
    for i in range(q0.size):
        q0[i] += q1[i] + q2[i]
        q1[i] += 2.0 * q2[i]


@implements(predict)
def _predict(integrator, taylor):
    if integrator.instance_class is Gear:
        return lambda integrator, taylor: _predict_gear(taylor)
    return lambda integrator, taylor: _predict_verlet(taylor)


@inlined
def _correct_gear(integrator, taylor, d, i, acceleration):
    error = 0.5 * acceleration * integrator.time_step**2 - taylor[2, d, i]
    c = integrator.coefficients
    taylor[0, d, i] += c[0] * error
    taylor[1, d, i] += c[1] * error
    taylor[2, d, i] += error
    taylor[3, d, i] += c[3] * error
    taylor[4, d, i] += c[4] * error
    taylor[5, d, i] += c[5] * error


@inlined
def _correct_verlet(integrator, taylor, d, i, acceleration):
    half = 0.5 * acceleration * integrator.time_step**2
    taylor[1, d, i] += half - taylor[2, d, i]
    taylor[2, d, i] = half


@implements(correct)
def _correct(integrator, taylor, d, i, acceleration):
    if integrator.instance_class is Gear:
        return lambda integrator, taylor, d, i, acceleration: _correct_gear(
            integrator, taylor, d, i, acceleration
        )
    return lambda integrator, taylor, d, i, acceleration: _correct_verlet(
        integrator, taylor, d, i, acceleration
    )


@inlined
def flush(taylor):
    """Set vanishing higher terms to zero.

    In free flight Gear's higher terms decay geometrically into the subnormal numbers, which
    processors handle many times slower.
    """
    terms = taylor.reshape(TERMS, taylor[0].size)
    for k in range(2, TERMS):
        for i in range(terms.shape[1]):
            terms[k, i] = terms[k, i] if abs(terms[k, i]) >= VANISHING else 0.0


def rescale_terms(taylor: np.ndarray, old_step: float, new_step: float) -> None:
    """Rescale the Taylor terms in place for another time step."""
    for k in range(len(taylor)):
        taylor[k] *= (new_step / old_step) ** k
