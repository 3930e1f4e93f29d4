"""Mean flow of the beads over squares at rest in the laboratory, and waves of their density."""

from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np

from sim.engine.compile import exact
from sim.engine.observe.totals import COMPLEX, product, square, total

#: Number of levels of squares, one mean diameter each, from below the belt's lowest position.
LEVELS = 60

#: Number of the longest density waves along the belt whose power is added.
WAVES = 5


class Field(NamedTuple):
    """Sums over samples in squares of the laboratory.

    ``samples`` (1,); ``count`` (X, Z) beads; ``moved`` (X, Z) sum of their velocities along x.
    """

    samples: np.ndarray
    # This field hides the method of tuples with the same name, which is never called.
    count: np.ndarray  # type: ignore[assignment]
    moved: np.ndarray


class Squares(NamedTuple):
    """The squares: ``columns`` of ``width`` (m) along the belt, levels of ``height`` (m).

    ``lowest`` (m) is the lower edge of the first level.
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

    def empty(self) -> Field:
        """Return sums of zero."""
        shape = (self.columns, LEVELS)
        return Field(np.zeros(1), np.zeros(shape), np.zeros(shape))

    def tables(self, field: Field) -> dict[str, np.ndarray]:
        """Return mean velocity along x (m/s), not-a-number without beads, and density (m⁻²)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            velocity = np.where(field.count > 0, field.moved / field.count, np.nan)
            density = field.count / (field.samples[0] * self.width * self.height)
        return {"field_velocity": velocity, "field_density": density}


def squares(width: float, diameter: float, amplitude: float) -> Squares:
    """Return squares of about a mean diameter (m) for a belt of a width (m).

    ``amplitude`` is the amplitude of the vertical vibration in mean diameters.
    """
    columns = max(1, round(width / diameter))
    return Squares(columns, width / columns, diameter, -ceil(amplitude) * diameter)


@exact
def count_beads(field, squares, taylor, time_step):
    """Add one state of the beads, see ``Disks``; beads outside the levels are omitted."""
    field.samples[0] += 1.0
    for i in range(taylor.shape[2]):
        level = int(np.floor((taylor[0, 1, i] - squares.lowest) / squares.height))
        if 0 <= level < LEVELS:
            column = int(np.floor(taylor[0, 0, i] / squares.width)) % squares.columns
            field.count[column, level] += 1.0
            field.moved[column, level] += taylor[1, 0, i] / time_step


@exact
def waves(x, width, sums):
    """Set ``sums`` (5, 2) to the real and imaginary parts of Σ exp(2πikx/L) over all beads.

    The wave number k goes from 1 to 5; L is the width of the belt (m).
    """
    parts = np.empty((WAVES, 2, x.size))
    for i in range(x.size):
        angle = 2.0 * pi / width * x[i]
        wave = cos(angle), sin(angle)
        second = product(wave, wave)
        fourth = product(second, second)
        powers = wave, square(wave), product(wave, second), fourth, product(wave, fourth)
        for k in range(WAVES):
            parts[k, 0, i], parts[k, 1, i] = powers[k]
    for k in range(WAVES):
        for part in range(2):
            sums[k, part] = total(parts[k, part], COMPLEX)


def wave_power(sums: np.ndarray, beads: int) -> np.ndarray:
    """Return the power of the longest density waves along the belt; 1 for random beads.

    ``sums`` (K, 5, 2) are those of ``waves`` in K states.
    """
    # The square of Python's numbers, which is not always the product.
    size = np.hypot(sums[..., 0], sums[..., 1]).tolist()
    power = [a**2 + b**2 + c**2 + d**2 + e**2 for a, b, c, d, e in size]
    return np.array(power) / (WAVES * beads)
