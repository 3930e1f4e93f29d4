"""The two integrators of the belt for x'' = a(x, v, t), one step at a time.

Gear predictor-corrector: Allen and Tildesley, Computer Simulation of Liquids (1987), six values,
coefficients for second-order equations whose acceleration depends on the velocity.
"""

from collections.abc import Callable
from math import comb, factorial

import numpy as np

Acceleration = Callable[[np.ndarray, np.ndarray, float], np.ndarray]

GEAR_COEFFICIENTS = (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60)


def gear_start(
    acceleration: Acceleration,
    position: np.ndarray,
    velocity: np.ndarray,
    time: float,
    time_step: float,
) -> np.ndarray:
    """Scaled derivatives (6, ...): row k is x^(k) dt^k/k!; those above the second are zero."""
    derivatives = [position, velocity, acceleration(position, velocity, time)]
    scaled = np.zeros((6, *np.shape(position)))
    for order, derivative in enumerate(derivatives):
        scaled[order] = derivative * time_step**order / factorial(order)
    return scaled


def gear_step(
    acceleration: Acceleration, scaled: np.ndarray, time: float, time_step: float
) -> np.ndarray:
    """Scaled derivatives at time + time_step from those at time: predict, evaluate, correct."""
    predicted = np.zeros_like(scaled)
    for order in range(6):
        for higher in range(order, 6):
            predicted[order] += comb(higher, order) * scaled[higher]
    found = acceleration(predicted[0], predicted[1] / time_step, time + time_step)
    error = 0.5 * time_step**2 * found - predicted[2]
    return np.array([row + c * error for row, c in zip(predicted, GEAR_COEFFICIENTS, strict=True)])


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
