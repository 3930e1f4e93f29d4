"""Orientations of the spheres as unit quaternions (w, x, y, z); the motion needs none."""

import numpy as np

from sim.engine.compile import assume_no_alias, inlined
from sim.engine.contact.roots import inverse_square_root


def unrotated_orientations(particles: int) -> np.ndarray:
    """Return the orientations (4, N) of spheres that have not turned yet."""
    orientation = np.zeros((4, particles))
    orientation[0] = 1.0
    return orientation


@inlined
def rotate(orientation, rim, radius, time_step, begin, end):
    """Turn the spheres ``begin``..``end`` by their spin ``rim / radius`` during one step.

    dq/dt = ω q / 2 (Evans 1977 in laboratory axes), then scaled back to unit length, which makes
    the angle exact to third order in the step. Orientations may be empty.
    """
    assume_no_alias()
    for k in range(begin, min(end, orientation.shape[1])):
        i = np.uint64(k)
        half = 0.5 * time_step / radius[i]
        w, x, y, z = orientation[0, i], orientation[1, i], orientation[2, i], orientation[3, i]
        a, b, c = half * rim[0, i], half * rim[1, i], half * rim[2, i]
        nw = w - a * x - b * y - c * z
        nx = x + a * w + b * z - c * y
        ny = y - a * z + b * w + c * x
        nz = z + a * y - b * x + c * w
        scale = inverse_square_root(nw * nw + nx * nx + ny * ny + nz * nz)
        orientation[0, i] = nw * scale
        orientation[1, i] = nx * scale
        orientation[2, i] = ny * scale
        orientation[3, i] = nz * scale
