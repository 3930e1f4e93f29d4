"""Orientations of the spheres as unit quaternions (w, x, y, z); the motion needs none."""

from math import sqrt

import numpy as np

from sim.compile import kernel


def unrotated(particles: int) -> np.ndarray:
    """Return the orientations (N, 4) of spheres that have not turned yet."""
    orientation = np.zeros((particles, 4))
    orientation[:, 0] = 1.0
    return orientation


@kernel
def rotate(orientation, spin, time_step):
    """Turn the spheres by their spin (1/s, laboratory axes) during one step.

    dq/dt = ω q / 2 (Evans 1977 in laboratory axes), then scaled back to unit length, which makes
    the angle exact to third order in the step.
    """
    half = 0.5 * time_step
    for i in range(orientation.shape[0]):
        w, x, y, z = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        a, b, c = half * spin[i, 0], half * spin[i, 1], half * spin[i, 2]
        nw = w - a * x - b * y - c * z
        nx = x + a * w + b * z - c * y
        ny = y - a * z + b * w + c * x
        nz = z + a * y - b * x + c * w
        scale = 1.0 / sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
        orientation[i, 0] = nw * scale
        orientation[i, 1] = nx * scale
        orientation[i, 2] = ny * scale
        orientation[i, 3] = nz * scale
