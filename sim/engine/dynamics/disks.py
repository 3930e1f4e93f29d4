"""Disks in two dimensions (x, z), without rotation: their forces and integrators.

Gear's predictor-corrector and velocity Verlet act on the Taylor terms of ``Disks``: they predict
before the forces are evaluated and correct after it. Gear's can correct again, with forces at the
corrected positions and velocities. Coefficients: Allen and Tildesley, Computer Simulation of
Liquids (1987), appendix E, for equations of second order whose forces depend on the velocity.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.compile import assume_no_alias, by_type, inlined, kernel
from sim.engine.contact.damping import disk_force, dissipated_powers, elastic_energy
from sim.engine.dynamics.cells import nearest_image
from sim.engine.dynamics.neighbors import find_touching

#: Taylor terms per coordinate: position and five derivatives.
TERMS = 6


class Disks(NamedTuple):
    """The beads, one column each, in SI units.

    ``taylor`` (6, 2, N): term k is the k-th time derivative of the position (x, z) times Δt^k/k!,
    so term 0 is the position and term 1 the velocity times Δt; ``force`` (2, N), ``radius`` (N,),
    ``mass`` (N,). ``label`` (1, N) is the bead's number in the initial state: the neighbor list
    keeps the beads sorted by position.
    """

    taylor: np.ndarray
    force: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    label: np.ndarray


def make_disks(position, velocity, radius, mass, time_step: float) -> Disks:
    """Return disks at these positions and velocities, (N, 2), with all higher derivatives zero."""
    number = len(position)
    taylor = np.zeros((TERMS, 2, number))
    taylor[0] = np.transpose(position)
    taylor[1] = np.transpose(velocity) * time_step
    return Disks(
        taylor,
        np.zeros((2, number)),
        np.broadcast_to(np.asarray(radius, float), number).copy(),
        np.broadcast_to(np.asarray(mass, float), number).copy(),
        np.arange(number).reshape(1, number),
    )


@inlined
def disk_forces(law, disks, pairs, search, time_step):
    """Add the forces of all touching pairs, each disk's evaluated for itself.

    Returns the number of touching pairs, the largest overlap relative to the sum of the radii, and
    the powers (W) that normal and shear damping take.
    """
    assume_no_alias()
    x, force, mass = disks.taylor, disks.force, disks.mass
    largest, normal_loss, shear_loss = 0.0, 0.0, 0.0
    per_step = 1.0 / time_step
    touching = find_touching(x[0], pairs, 0, pairs.start[-1], 0, search.gap)
    for k in range(touching):
        p = np.uint64(pairs.touching[k])
        i, j = np.uint64(pairs.first[p]), np.uint64(pairs.second[p])
        dx = nearest_image(x[0, 0, j] - x[0, 0, i], pairs.box, 0)
        dz = x[0, 1, j] - x[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        reach = pairs.reach[p]
        overlap = reach - distance
        nx, nz = dx / distance, dz / distance
        velocity_i = (x[1, 0, i] * per_step, x[1, 1, i] * per_step)
        velocity_j = (x[1, 0, j] * per_step, x[1, 1, j] * per_step)
        vx, vz = velocity_i[0] - velocity_j[0], velocity_i[1] - velocity_j[1]
        fx, fz = disk_force(law, overlap, (nx, nz), (vx, vz), mass[i], 1.0 / mass[j])
        force[0, i] += fx
        force[1, i] += fz
        normal_power_i, shear_power_i = dissipated_powers(
            law, overlap, (nx, nz), velocity_i, (fx, fz)
        )
        fx, fz = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), mass[j], 1.0 / mass[i])
        force[0, j] += fx
        force[1, j] += fz
        normal_power_j, shear_power_j = dissipated_powers(
            law, overlap, (-nx, -nz), velocity_j, (fx, fz)
        )
        normal_loss += normal_power_i + normal_power_j
        shear_loss += shear_power_i + shear_power_j
        largest = max(largest, overlap / reach)
    return touching, largest, normal_loss, shear_loss


@kernel
def stored_in_disks(law, disks, pairs):
    """Return the energy (J) in the springs of all touching pairs."""
    x, energy = disks.taylor[0], 0.0
    for p in range(pairs.start[-1]):
        i, j = pairs.first[p], pairs.second[p]
        dx, dz = nearest_image(x[0, j] - x[0, i], pairs.box, 0), x[1, j] - x[1, i]
        overlap = pairs.reach[p] - sqrt(dx * dx + dz * dz)
        energy += elastic_energy(law, overlap) if overlap > 0.0 else 0.0
    return energy


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


def _predict_gear(integrator, taylor):
    terms = taylor.reshape(TERMS, taylor[0].size)
    q0, q1, q2, q3, q4, q5 = terms[0], terms[1], terms[2], terms[3], terms[4], terms[5]
    for i in range(q0.size):
        b, c, e, f, g = q1[i], q2[i], q3[i], q4[i], q5[i]
        q0[i] += b + c + e + f + g
        q1[i] = b + 2.0 * c + 3.0 * e + 4.0 * f + 5.0 * g
        q2[i] = c + 3.0 * e + 6.0 * f + 10.0 * g
        q3[i] = e + 4.0 * f + 10.0 * g
        q4[i] = f + 5.0 * g


def _predict_verlet(integrator, taylor):
    terms = taylor.reshape(TERMS, taylor[0].size)
    q0, q1, q2 = terms[0], terms[1], terms[2]
    for i in range(q0.size):
        q0[i] += q1[i] + q2[i]
        q1[i] += 2.0 * q2[i]


@by_type
def predict(integrator, taylor):
    """Advance the Taylor terms by one step without knowing the new forces."""
    return _predict_gear if integrator.instance_class is Gear else _predict_verlet


def _correct_gear(integrator, taylor, d, i, acceleration):
    error = 0.5 * acceleration * integrator.time_step**2 - taylor[2, d, i]
    c = integrator.coefficients
    taylor[0, d, i] += c[0] * error
    taylor[1, d, i] += c[1] * error
    taylor[2, d, i] += error
    taylor[3, d, i] += c[3] * error
    taylor[4, d, i] += c[4] * error
    taylor[5, d, i] += c[5] * error


def _correct_verlet(integrator, taylor, d, i, acceleration):
    half = 0.5 * acceleration * integrator.time_step**2
    taylor[1, d, i] += half - taylor[2, d, i]
    taylor[2, d, i] = half


@by_type
def correct(integrator, taylor, d, i, acceleration):
    """Correct coordinate d of disk i for its new acceleration (m/s²)."""
    return _correct_gear if integrator.instance_class is Gear else _correct_verlet


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
