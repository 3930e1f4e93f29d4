"""Ratios of measured numbers, whose divisor may be hardly known."""

import numpy as np
import pytest

from sim.claims.place import quotient, with_interval
from sim.claims.verdict import SIGMAS


def half_width(numerator, denominator) -> float:
    return SIGMAS * quotient(numerator, denominator).std_dev


def test_a_well_known_divisor_gives_the_propagated_error():
    ratio = quotient(with_interval(3.0, 0.3), with_interval(2.0, 0.02))
    assert ratio.nominal_value == 1.5
    assert SIGMAS * ratio.std_dev == pytest.approx(1.5 * np.hypot(0.1, 0.01), rel=5e-3)


def test_the_interval_holds_a_threshold_where_the_difference_is_not_sure():
    """At its farther end ``over - t · under`` is just as far from zero as its own interval."""
    numerator, denominator = with_interval(1.0, 0.2), with_interval(2.0, 1.0)
    end = 0.5 + half_width(numerator, denominator)
    assert abs(1.0 - end * 2.0) == pytest.approx(np.hypot(0.2, end * 1.0))


def test_a_divisor_that_may_be_zero_leaves_the_ratio_open():
    assert half_width(with_interval(1.16, 0.1), with_interval(3.98, 4.5)) == np.inf
    assert half_width(with_interval(1.16, 0.1), with_interval(3.98, np.inf)) == np.inf
