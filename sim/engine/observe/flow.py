"""Energy and height of the spheres of a chute flow at one moment."""

import numpy as np

from sim.engine.compile import exact
from sim.engine.observe.rounding import REAL, total


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
