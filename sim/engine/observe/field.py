"""Mean flow of the beads over squares at rest in the laboratory, and waves of their density."""

from math import ceil, pi
from typing import NamedTuple

import numpy as np

#: Levels of the squares, one mean diameter each, from below the belt's lowest position.
LEVELS = 60

#: Longest waves of the density along the belt whose power is added up.
WAVES = 5


class Field(NamedTuple):
    """Sums over samples in squares of the laboratory.

    ``samples`` (1,); ``count`` (X, Z) beads; ``moved`` (X, Z) sum of their velocities along x.
    """

    samples: np.ndarray
    # A field of this name hides the method of tuples, which nobody calls.
    count: np.ndarray  # type: ignore[assignment]
    moved: np.ndarray


class Squares(NamedTuple):
    """The squares: ``columns`` of ``width`` (m) along the belt, levels of ``height`` (m).

    ``lowest`` (m) is where the first level begins.
    """

    columns: int
    width: float
    height: float
    lowest: float

    def coordinates(self) -> dict[str, tuple[str, str, np.ndarray]]:
        """Return the centres of columns and levels: name -> (unit, long name, values)."""
        column = (np.arange(self.columns) + 0.5) * self.width
        level = self.lowest + (np.arange(LEVELS) + 0.5) * self.height
        return {
            "column": ("m", "centre of the column along the belt", column),
            "level": ("m", "height of the level above the mean belt position", level),
        }

    def sample(self, x: np.ndarray, z: np.ndarray, velocity: np.ndarray) -> Field:
        """Return the field of one state, beads (N,) outside the levels left out."""
        column = np.floor(x / self.width).astype(int) % self.columns
        level = np.floor((z - self.lowest) / self.height).astype(int)
        inside = (level >= 0) & (level < LEVELS)
        square = (column * LEVELS + level)[inside]
        shape = (self.columns, LEVELS)
        count = np.bincount(square, minlength=self.columns * LEVELS)
        moved = np.bincount(square, weights=velocity[inside], minlength=self.columns * LEVELS)
        return Field(np.ones(1), count.reshape(shape).astype(float), moved.reshape(shape))

    def tables(self, field: Field) -> dict[str, np.ndarray]:
        """Return mean velocity along x (m/s), not-a-number where no bead was, and density (m⁻²)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            velocity = np.where(field.count > 0, field.moved / field.count, np.nan)
            density = field.count / (field.samples[0] * self.width * self.height)
        return {"field_velocity": velocity, "field_density": density}


def squares(width: float, diameter: float, amplitude: float) -> Squares:
    """Return squares of about a mean diameter (m) for a belt of a width (m).

    ``amplitude`` is that of the vertical vibration in mean diameters.
    """
    columns = max(1, round(width / diameter))
    return Squares(columns, width / columns, diameter, -ceil(amplitude) * diameter)


def wave_power(x: np.ndarray, width: float) -> float:
    """Return the power of the longest waves of the density along the belt; 1 for random beads."""
    wave = np.exp(2j * pi / width * x)
    return sum(abs((wave**k).sum()) ** 2 for k in range(1, WAVES + 1)) / (WAVES * len(x))
