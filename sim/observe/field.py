"""Mean flow of the beads over the plane of the belt, at rest in the laboratory."""

from typing import NamedTuple

import numpy as np


class Field(NamedTuple):
    """Sums over samples in squares of the laboratory.

    ``samples`` (1,); ``count`` (X, Z) beads; ``moved`` (X, Z) sum of their velocities along x.
    """

    samples: np.ndarray
    count: np.ndarray
    moved: np.ndarray

    def plus(self, other: "Field") -> "Field":
        """Return the sums of both."""
        return Field(*(mine + theirs for mine, theirs in zip(self, other, strict=True)))

    def zeros(self) -> "Field":
        """Return sums of the same shape without any sample."""
        return Field(*(np.zeros_like(mine) for mine in self))

    def velocity(self) -> np.ndarray:
        """Return the mean velocity along x (m/s), not-a-number where no bead has been."""
        with np.errstate(invalid="ignore"):
            return np.where(self.count > 0, self.moved / self.count, np.nan)


def sampled(column: np.ndarray, level: np.ndarray, velocity: np.ndarray, shape) -> Field:
    """Return the field of one state; beads (N,) outside the ``shape`` (X, Z) are left out."""
    inside = (level >= 0) & (level < shape[1])
    square = (column * shape[1] + level)[inside]
    size = shape[0] * shape[1]
    count = np.bincount(square, minlength=size)
    moved = np.bincount(square, weights=velocity[inside], minlength=size)
    return Field(np.ones(1), count.reshape(shape).astype(float), moved.reshape(shape))
