"""What one step of Gear's predictor-corrector does to a linear system: its amplification matrix.

A step is stable when no eigenvalue of that matrix is outside the unit circle. Everything is scaled
by the time step: Taylor terms as in the engine, the damping rate λΔt, the frequency ωΔt.
"""

from collections.abc import Callable
from math import comb, nan
from typing import NamedTuple

import numpy as np

from sim.engine.dynamics.disks import CORRECTORS

#: Second derivative (..., columns) of positions and velocities, scaled by the squared time step.
Acceleration = Callable[[np.ndarray, np.ndarray], np.ndarray]


#: Growth per step that counts as none.
STILL = 1.0 + 1e-6


class Corrector(NamedTuple):
    """Gear's corrector of an ``order``, applied ``corrections`` times in a step."""

    order: int
    corrections: int

    @property
    def terms(self) -> int:
        """Taylor terms that it keeps."""
        return self.order + 1

    def step(self, taylor: np.ndarray, acceleration: Acceleration) -> np.ndarray:
        """Return the Taylor terms (terms, ...) one step later."""
        terms = range(self.terms)
        predictor = np.array([[comb(higher, row) for higher in terms] for row in terms], float)
        coefficients = np.array(CORRECTORS[self.order][: self.terms])
        taylor = np.tensordot(predictor, taylor, 1)
        for _ in range(self.corrections):
            error = 0.5 * acceleration(taylor[0], taylor[1]) - taylor[2]
            taylor = taylor + np.multiply.outer(coefficients, error)
        return taylor


#: All that can be chosen, the paper's default last.
SCHEMES = tuple(Corrector(order, times) for times in (2, 1) for order in sorted(CORRECTORS))


def matrix(corrector: Corrector, damping: float, frequency: float) -> np.ndarray:
    """Return the amplification matrix of x" = -ω²x - λx' for λΔt and ωΔt."""

    def acceleration(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return -(frequency**2) * x - damping * v

    return corrector.step(np.eye(corrector.terms), acceleration)


def growth(corrector: Corrector, damping: float, frequency: float) -> float:
    """Return the largest factor by which a step enlarges any motion of an oscillator."""
    return float(np.abs(np.linalg.eigvals(matrix(corrector, damping, frequency))).max())


def limit(corrector: Corrector, frequency: float = 0.0) -> float:
    """Return the largest λΔt up to which an oscillator of ωΔt is damped, to 10⁻⁴.

    Weakly damped ones of high frequency, which some correctors let grow slowly, are left out; NaN
    where all grow.
    """
    coarse = np.arange(0.0, 3.0, 0.02)
    stable = np.array([growth(corrector, each, frequency) <= STILL for each in coarse])
    if not stable.any():
        return nan
    first = int(stable.argmax())
    low, high = coarse[first], coarse[first + int((~stable[first:]).argmax())]
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        is_stable = growth(corrector, middle, frequency) <= STILL
        low, high = (middle, high) if is_stable else (low, middle)
    return float(low)
