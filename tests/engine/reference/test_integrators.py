"""Order of the integrators on a damped harmonic oscillator, x'' = -x - 0.3 x'."""

from math import factorial

import numpy as np
import pytest

from .integrators import gear_start, gear_step, verlet_step

DAMPING, END = 0.3, 10.0
COUNTS = np.array([200, 400, 800])


def acceleration(x, v, t):
    return -x - DAMPING * v


def exact(time: float) -> float:
    rate, frequency = 0.5 * DAMPING, np.sqrt(1 - 0.25 * DAMPING**2)
    phase = frequency * time
    return float(np.exp(-rate * time) * (np.cos(phase) + rate / frequency * np.sin(phase)))


def gear_error(count: int, known_derivatives: bool) -> float:
    time_step = END / count
    scaled = gear_start(acceleration, np.array([1.0]), np.array([0.0]), 0.0, time_step)
    if known_derivatives:
        values = [1.0, 0.0]
        for order in range(2, 6):
            values.append(acceleration(values[order - 2], values[order - 1], 0.0))
        scaled = np.array([[x * time_step**k / factorial(k)] for k, x in enumerate(values)])
    for number in range(count):
        scaled = gear_step(acceleration, scaled, number * time_step, time_step)
    return abs(float(scaled[0, 0]) - exact(END))


def verlet_error(count: int) -> float:
    time_step = END / count
    state = (np.array([1.0]), np.array([0.0]), np.array([-1.0]))
    for number in range(count):
        state = verlet_step(acceleration, state, number * time_step, time_step)
    return abs(float(state[0][0]) - exact(END))


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_gear_is_of_fifth_order():
    found = orders([gear_error(count, True) for count in COUNTS])
    assert found == pytest.approx([5.0, 5.0], abs=0.05)


def test_gear_started_without_higher_derivatives_keeps_a_second_order_error():
    """The unknown third derivative costs one error of dt^3 in x and dt^2 in v, never forgotten."""
    found = orders([gear_error(count, False) for count in COUNTS])
    assert found == pytest.approx([2.0, 2.0], abs=0.05)


def test_verlet_is_of_second_order():
    found = orders([verlet_error(count) for count in COUNTS])
    assert found == pytest.approx([2.0, 2.0], abs=0.05)


def test_gear_corrects_each_row_by_its_share_of_the_error():
    def pushed(x, v, t):
        return np.array([2.0 / 0.1**2])

    found = gear_step(pushed, np.zeros((6, 1)), 0.0, 0.1)[:, 0]
    assert found == pytest.approx([3 / 16, 251 / 360, 1, 11 / 18, 1 / 6, 1 / 60], rel=1e-14)


def test_gear_follows_a_quintic_exactly():
    def jerky(x, v, t):
        return np.array([20.0 * t**3 - 6.0 * t])

    scaled = np.array([[0.0], [2.0], [0.0], [-1.0], [0.0], [1.0]])
    scaled *= 0.1 ** np.arange(6)[:, None]
    for number in range(30):
        scaled = gear_step(jerky, scaled, 0.1 * number, 0.1)
    assert scaled[0, 0] == pytest.approx(3.0**5 - 3.0**3 + 2 * 3.0, rel=1e-12)


def test_gear_start_scales_the_first_three_rows():
    scaled = gear_start(acceleration, np.array([1.0]), np.array([2.0]), 0.0, 0.1)
    assert scaled[:, 0] == pytest.approx([1.0, 0.2, 0.005 * -1.6, 0, 0, 0], rel=1e-14)
