"""Statements about many quantities at once."""

import numpy as np
import pytest

from sim.claims.inference import mean_of_others, smallest_mean
from tests.made.results import spread


def interval(rows) -> tuple[float, float]:
    value = smallest_mean(np.asarray(rows, float))
    half_width = 1.96 * value.std_dev
    return value.nominal_value - half_width, value.nominal_value + half_width


def rows_of(means, errors, replicates=8) -> np.ndarray:
    return np.asarray(means) + np.outer(spread(replicates), errors)


def test_least_of_many_is_positive_only_if_all_are():
    assert interval(rows_of([1, 2, 0.5], [0.01, 0.01, 0.01]))[0] > 0
    low, high = interval(rows_of([1, 2, 0.5], [0.01, 5, 0.01]))
    assert low < 0 < high


def test_least_of_many_is_negative_if_one_clearly_is():
    assert interval(rows_of([1, -0.1, -2.0], [0.01, 0.01, 50]))[1] < 0


def test_chance_alone_makes_none_of_many_negative():
    """Each of 2000 sets of 20 positive means that noise hides: 2.5 % of them may fail."""
    rng = np.random.default_rng(1)
    negative = [interval(rng.normal(0, 1, (8, 20)))[1] < 0 for _ in range(2000)]
    assert np.mean(negative) == pytest.approx(0.025, abs=0.01)


def test_one_replicate_says_nothing():
    assert interval([[1.0, 2.0]]) == (-np.inf, np.inf)


def test_the_mean_of_others_knows_nothing_of_the_replicate_itself():
    rows = np.array([[3.0, 0.0], [0.0, 6.0], [0.0, 0.0]])
    assert np.array_equal(mean_of_others(rows), [[0, 3], [1.5, 0], [1.5, 3]])
    assert np.array_equal(mean_of_others(rows.T, axis=1), mean_of_others(rows).T)
    assert np.array_equal(mean_of_others(rows[:1]), rows[:1])
