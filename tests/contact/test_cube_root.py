"""The vectorisable cube root against the library's."""

import numpy as np
import pytest

from tests.engine_helpers import cube_roots


@pytest.mark.parametrize("low", [1e-200, 1e-16, 1e-3])
def test_cube_root_is_right_to_fourteen_digits(low):
    x = np.geomspace(low, 1.0, 100_001)
    assert np.abs(cube_roots(x) / np.cbrt(x) - 1.0).max() < 2e-14


def test_cube_roots_of_zero_and_one_are_those_of_sliding_and_of_a_fresh_contact():
    roots = cube_roots(np.array([0.0, 1e-310, 1.0]))
    assert roots == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)
