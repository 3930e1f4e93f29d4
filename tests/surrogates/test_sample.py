"""What runs say of a point: mean, error, regime, and the scatter between replicates."""

import numpy as np
import pytest

from sim.study.design import Axis
from sim.study.surrogate import SurrogateSpec
from sim.surrogates.sample import standard_errors
from tests.made.surrogates import design

SPEC = SurrogateSpec("speed", "flows", "velocity", "chute", (Axis("friction", 0.3, 0.6),))


def test_errors_of_replicates_that_agree_by_accident_are_moderated():
    """Variances of 3 replicates scatter by a factor; the errors must do so by less, about truth."""
    rng = np.random.default_rng(1)
    values = list(rng.normal(1, 0.3, (200, 3)))
    errors, is_unknown = standard_errors(values, np.zeros(200), design(200, 2))
    raw = np.array([row.std(ddof=1) for row in values]) / np.sqrt(3)
    assert not is_unknown
    assert errors.min() > 2 * raw.min() and errors.std() < 0.3 * raw.std()
    assert np.sqrt((errors**2).mean()) == pytest.approx(0.3 / np.sqrt(3), rel=0.1)


def test_errors_that_differ_in_truth_stay_different():
    rng = np.random.default_rng(1)
    values = [rng.normal(1, 0.01 if number % 2 else 1.0, 6) for number in range(100)]
    errors, _ = standard_errors(values, np.zeros(100), design(100, 2))
    assert np.median(errors[::2]) > 30 * np.median(errors[1::2])


def test_a_single_replicate_has_the_common_scatter():
    rng = np.random.default_rng(1)
    values = [*rng.normal(1, 0.3, (30, 3)), np.array([1.2])]
    errors, is_unknown = standard_errors(values, np.full(31, 0.01), design(31, 2))
    assert not is_unknown and errors[-1] == pytest.approx(0.3, rel=0.2)


def test_without_replicates_the_scatter_is_unknown():
    errors, is_unknown = standard_errors([np.array([1.0])] * 5, np.full(5, 0.02), design(5, 2))
    assert is_unknown and errors == pytest.approx(0.02)
    alike, is_unknown = standard_errors([np.ones(3)] * 5, np.full(5, 0.02), design(5, 2))
    assert not is_unknown and alike == pytest.approx(0.02)


def test_errors_follow_a_noise_that_rises_along_a_parameter():
    """Few replicates: each error must be about the noise there, not that of all points."""
    rng, x = np.random.default_rng(1), design(64, 2)
    size = 0.01 * 30 ** x[:, 0]
    errors, _ = standard_errors(list(rng.normal(1, size[:, None], (64, 3))), np.zeros(64), x)
    ratios = errors * np.sqrt(3) / size
    for third in (x[:, 0] < 1 / 3, x[:, 0] > 2 / 3):
        assert 0.7 < np.sqrt(np.mean(ratios[third] ** 2)) < 1.4
