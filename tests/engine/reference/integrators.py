"""The two integrators of the belt for x'' = a(x, v, t), one step at a time.

Gear predictor-corrector: Allen and Tildesley, Computer Simulation of Liquids (1987), four to six
values, coefficients for second-order equations whose acceleration depends on the velocity.
"""

from collections.abc import Callable
from math import comb, factorial

import numpy as np

Acceleration = Callable[[np.ndarray, np.ndarray, float], np.ndarray]

#: By the order, one less than the number of values.
GEAR_COEFFICIENTS = {
    3: (1 / 6, 5 / 6, 1.0, 1 / 3),
    4: (19 / 90, 3 / 4, 1.0, 1 / 2, 1 / 12),
    5: (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60),
}


def gear_start(
    acceleration: Acceleration,
    position: np.ndarray,
    velocity: np.ndarray,
    time: float,
    time_step: float,
    gear_order: int = 5,
) -> np.ndarray:
    """Scaled derivatives (order + 1, ...): row k is x^(k) dt^k/k!, zero above the second."""
    derivatives = [position, velocity, acceleration(position, velocity, time)]
    scaled = np.zeros((gear_order + 1, *np.shape(position)))
    for order, derivative in enumerate(derivatives):
        scaled[order] = derivative * time_step**order / factorial(order)
    return scaled


def gear_step(
    acceleration: Acceleration,
    scaled: np.ndarray,
    time: float,
    time_step: float,
    corrections: int = 1,
) -> np.ndarray:
    """Scaled derivatives at time + time_step: predict, then evaluate and correct, maybe again."""
    values = np.zeros_like(scaled)
    for order in range(len(scaled)):
        for higher in range(order, len(scaled)):
            values[order] += comb(higher, order) * scaled[higher]
    coefficients = GEAR_COEFFICIENTS[len(scaled) - 1]
    for _ in range(corrections):
        found = acceleration(values[0], values[1] / time_step, time + time_step)
        error = 0.5 * time_step**2 * found - values[2]
        values = np.array([row + c * error for row, c in zip(values, coefficients, strict=True)])
    return values


def verlet_step(
    acceleration: Acceleration,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
    time: float,
    time_step: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration at time + time_step from those at time.

    The acceleration is evaluated once, at the new position and a velocity predicted by v + a dt.
    """
    position, velocity, old = state
    position = position + velocity * time_step + 0.5 * old * time_step**2
    new = acceleration(position, velocity + old * time_step, time + time_step)
    return position, velocity + 0.5 * time_step * (old + new), new
