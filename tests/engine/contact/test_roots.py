"""The vectorisable roots against the library's."""

import numpy as np
import pytest

from sim.engine.contact.friction import SMALLEST
from tests.engine_motion.helpers import cube_roots, inverse_square_roots

LARGE = 1e290
BOUNDS = [(SMALLEST, 1e-200), (1e-200, 1.0), (1e-16, 1.0), (1e-3, 1.0), (1.0, 8.0), (1.0, LARGE)]


def samples(low: float, high: float) -> np.ndarray:
    """Numbers from low to high, evenly and at random over their logarithm."""
    even = np.geomspace(low, high, 100_001)
    random = np.random.default_rng(1).uniform(np.log(low), np.log(high), 100_000)
    return np.concatenate([even[1:], np.exp(random[random > np.log(SMALLEST) + 1e-9])])


@pytest.mark.parametrize(("low", "high"), BOUNDS)
def test_roots_are_right_to_two_and_one_units_in_the_fifteenth_digit(low, high):
    x = samples(low, high)
    assert np.abs(cube_roots(x) / np.cbrt(x) - 1.0).max() < 2e-15
    assert np.abs(inverse_square_roots(x) * np.sqrt(x) - 1.0).max() < 1e-15


def test_cube_roots_of_zero_and_one_are_those_of_sliding_and_of_a_fresh_contact():
    roots = cube_roots(np.array([0.0, 1e-310, 0.99 * SMALLEST, 1.0]))
    assert np.array_equal(roots[:3], np.zeros(3))
    assert roots[3] == pytest.approx(1.0, abs=1e-15)
    assert np.isnan(inverse_square_roots(np.array([np.nan]))).all()
