"""Energies and heights of all particles at one moment."""

import numpy as np

from sim.engine.compile import exact
from sim.engine.observe.rounding import REAL, total


@exact
def bed_energies(taylor, mass, time_step, amplitude):
    """Return kinetic energy, height and share near the belt of all beads at one moment.

    Parameters
    ----------
    taylor : (6, 2, N) array
        Taylor terms of the positions, see ``Disks``.
    mass : (N,) array
        Masses of the beads (kg).
    time_step : float
        Time step of the Taylor terms (s).
    amplitude : float
        Vertical amplitude of the belt (m).

    Returns
    -------
    tuple of 3 floats
        Kinetic energy (J), height of the centre of mass (m), share of beads whose centres are
        within an amplitude of the mean belt position.
    """
    near, terms, sums = 0, np.empty((3, mass.size)), np.empty(3)
    for i in range(mass.size):
        vx, vz, z = taylor[1, 0, i] / time_step, taylor[1, 1, i] / time_step, taylor[0, 1, i]
        terms[0, i], terms[1, i] = mass[i] * (vx * vx + vz * vz), z * mass[i]
        terms[2, i] = mass[i]
        near += abs(z) < amplitude
    for k in range(3):
        sums[k] = total(terms[k], REAL)
    return 0.5 * sums[0], sums[1] / sums[2], near / mass.size


@exact
def flow_energies(position, velocity, rim, mass):
    """Return kinetic energies and height of all spheres at one moment.

    Parameters
    ----------
    position, velocity, rim : (3, N) arrays
        See ``Spheres`` (m, m/s).
    mass : (N,) array
        Masses of the spheres (kg).

    Returns
    -------
    tuple of 3 floats
        Twice the kinetic energy of translation (J), the sum of mass times the square of ``rim``
        (J), height of the centre of mass (m).
    """
    terms, sums = np.empty((4, mass.size)), np.empty(4)
    for i in range(mass.size):
        vx, vy, vz = velocity[0, i], velocity[1, i], velocity[2, i]
        wx, wy, wz = rim[0, i], rim[1, i], rim[2, i]
        terms[0, i] = mass[i] * (vx * vx + vy * vy + vz * vz)
        terms[1, i] = mass[i] * (wx * wx + wy * wy + wz * wz)
        terms[2, i], terms[3, i] = position[2, i] * mass[i], mass[i]
    for k in range(4):
        sums[k] = total(terms[k], REAL)
    return sums[0], sums[1], sums[2] / sums[3]
