"""Processes hold what they promise on known functions, and regimes are as likely as said."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from sklearn.base import clone

from sim.surrogates.fit import Regimes, _objective, fit_lengths, fit_process
from sim.surrogates.process import Process
from tests.made.surrogates import design, kinked, smooth


def noisy(function, count, dimensions, seed, noise):
    """Return points, values and the scale of the noise, relative to the mean value."""
    rng = np.random.default_rng(seed)
    x = design(count, dimensions, seed)
    exact = function(x)
    size = noise * np.abs(exact).mean()
    return x, exact + rng.normal(0, size, count), size, rng


def test_a_smooth_function_is_known_from_few_points():
    x = design(32, 3)
    process = fit_process(x, smooth(x), np.zeros(32), has_scatter=False)
    fresh = np.random.default_rng(2).random((300, 3))
    mean, error = process.predict(fresh)
    apart = np.abs(mean - smooth(fresh))
    assert np.sqrt((apart**2).mean()) < 0.01 * smooth(fresh).mean()
    at_points, _ = process.predict(x)
    assert at_points == pytest.approx(smooth(x), rel=1e-4)
    assert (error > 0).all()


def test_leaving_out_is_what_a_process_without_the_point_says():
    """The closed form, against processes of the same lengths through all other points."""
    x, y, size, _ = noisy(kinked, 16, 2, 3, 0.05)
    for is_log in (False, True):
        process, _ = fit_lengths(Process(x, y, np.full(16, size**2), is_log, has_scatter=True))
        left_out = process.left_out
        for index in range(16):
            others = np.arange(16) != index
            again = clone(process._regressor).set_params(alpha=process.noise[others])
            again.fit(process.places[others], process.values[others])
            mean, spread = again.predict(x[index : index + 1], return_std=True)
            error = np.sqrt(spread**2 - process._scatter)
            middle, unit = process._in_unit(mean, error, np.ones(1))
            assert left_out.mean[index] == pytest.approx(middle[0], rel=1e-6)
            assert left_out.error[index] == pytest.approx(unit[0], rel=1e-4)


@pytest.mark.parametrize("has_scatter", [True, False])
def test_the_gradient_of_the_evidence_is_its_slope(has_scatter):
    x, y, size, rng = noisy(kinked, 16, 2, 3, 0.05)
    evidence = _objective(Process(x, y, np.full(16, size**2), False, has_scatter))
    theta = rng.normal(-1.0, 0.3, 3 + has_scatter)
    slopes = approx_fprime(theta, lambda place: evidence(place)[0], 1e-6)
    assert evidence(theta)[1] == pytest.approx(slopes, rel=1e-3, abs=1e-4)


def test_of_several_maxima_the_one_that_tells_left_out_points_is_taken():
    def wave(x):
        return np.sin(12 * x[:, 0]) + x[:, 1]

    x, fresh = design(14, 2, 1), np.random.default_rng(2).random((300, 2))
    process, _ = fit_lengths(Process(x, wave(x), np.zeros(14), False, has_scatter=True))
    assert np.abs(process.predict(fresh)[0] - wave(fresh)).mean() < 0.1


@pytest.mark.parametrize("has_scatter", [True, False])
def test_correlations_with_errors_are_the_covariance_of_the_process(has_scatter):
    x, y, size, rng = noisy(smooth, 16, 2, 3, 0.1)
    process, _ = fit_lengths(Process(x, y, np.full(16, size**2), False, has_scatter))
    groups, others = rng.random((3, 5, 2)), rng.random((3, 4, 2))
    found = process.correlation(groups, others)
    assert found.shape == (3, 5, 4)
    for one, other, correlation in zip(groups, others, found, strict=True):
        _, exact = process._regressor.predict(np.vstack([one, other]), return_cov=True)
        errors, others_errors = process.predict(one)[1], process.predict(other)[1]
        covariance = correlation * np.outer(errors, others_errors)
        assert covariance == pytest.approx(process._scale**2 * exact[:5, 5:], rel=1e-4, abs=1e-9)
    same = process.correlation(groups, groups)
    assert np.diagonal(same, axis1=1, axis2=2) == pytest.approx(1)


@pytest.mark.parametrize(("function", "is_known"), [(smooth, True), (kinked, False)])
def test_intervals_hold_the_truth_and_fresh_runs(function, is_known):
    """95 % are promised: over 6 made-up studies, 90 to 98 % must hold of 300 fresh runs each.

    Those of the truth may be wider: for smooth functions, means are better known than they say.
    """
    held, fresh_held = [], []
    for seed in range(6):
        x, y, size, rng = noisy(function, 32, 3, seed, 0.05)
        variance = np.full(32, size**2 if is_known else 0.0)
        process = fit_process(x, y, variance, has_scatter=not is_known)
        fresh = rng.random((300, 3))
        mean, error = process.predict(fresh)
        apart = np.abs(mean - function(fresh))
        held.append((apart < 1.96 * error).mean())
        run = function(fresh) + rng.normal(0, size, 300)
        fresh_held.append((np.abs(mean - run) < 1.96 * np.hypot(error, size)).mean())
    assert np.mean(held) > 0.9
    assert 0.9 < np.mean(fresh_held) < 0.98


def test_the_logarithm_is_taken_where_it_predicts_better():
    x = design(24, 2)
    steep = np.exp(6 * x[:, 0] + x[:, 1])
    assert fit_process(x, steep, np.zeros(24), has_scatter=False).is_log
    around_zero = smooth(x) - smooth(x).mean()
    assert not fit_process(x, around_zero, np.zeros(24), has_scatter=False).is_log


def test_noise_that_is_not_known_is_estimated():
    x, y, size, _ = noisy(smooth, 64, 2, 4, 0.1)
    noise = fit_process(x, y, np.zeros(64), has_scatter=True).left_out.noise
    assert 0.7 < noise.mean() / size < 1.4


def test_equal_points_and_equal_values_are_no_obstacle():
    x = np.vstack([design(8, 2), design(8, 2)])
    process = fit_process(x, np.r_[smooth(x[:8]), smooth(x[8:]) + 0.01], np.full(16, 1e-4), False)
    assert np.isfinite(process.predict(x)[0]).all()
    flat = fit_process(design(8, 2), np.full(8, 2.0), np.zeros(8), False)
    assert flat.predict(np.full((1, 2), 0.3))[0] == pytest.approx(2)


def test_errors_are_wider_the_fewer_points_lengths_are_fitted_to():
    few, many = (
        fit_process(x, smooth(x), np.full(len(x), 1e-4), False)
        for x in (design(8, 2), design(64, 2))
    )
    assert few.widening > 1.2 * many.widening and many.widening >= 1


def three(x):
    """Return the regimes of three parts of the unit cube."""
    words = np.where(x[:, 0] + 0.3 * x[:, 1] < 0.4, "arrested", "steady").astype(object)
    return np.where(x[:, 0] > 0.7, "accelerating", words)


def test_probabilities_are_right_as_often_as_they_say():
    """Over 6 made-up studies; a probability that is too sure or too vague would differ by more."""
    said, right = [], []
    for seed in range(6):
        x = design(32, 2, seed)
        regimes = Regimes.fit(x, three(x))
        fresh = np.random.default_rng(seed).random((300, 2))
        chances = regimes.predict(fresh)
        assert chances.sum(axis=0) == pytest.approx(1)
        likeliest = np.array(regimes.names)[chances.argmax(axis=0)]
        said.append(chances.max(axis=0).mean())
        right.append((likeliest == three(fresh)).mean())
    assert np.mean(right) > 0.9
    assert abs(np.mean(said) - np.mean(right)) < 0.05


def test_a_regime_that_depends_on_chance_has_no_sharp_boundary():
    rng = np.random.default_rng(1)
    x = design(64, 2)
    words = np.where(rng.random(64) < 0.5, "steady", "arrested").astype(object)
    chances = Regimes.fit(x, words).predict(rng.random((100, 2)))
    assert np.abs(chances - 0.5).mean() < 0.25


def test_one_regime_is_certain_and_unknown_ones_count_for_nothing():
    x = design(8, 2)
    words = np.array(["steady"] * 6 + ["undetermined", "failed"], object)
    regimes = Regimes.fit(x, words)
    assert regimes.names == ("steady",)
    assert (regimes.predict(x) == 1).all()
    nothing = Regimes.fit(x, np.full(8, "undetermined", object))
    assert nothing.predict(x).shape == (0, 8)


def test_what_the_mean_counts_is_a_regime_of_its_own():
    x = np.linspace(0, 1, 12)[:, None]
    words = np.array(["undetermined"] * 9 + ["accelerating"] * 3, object)
    assert Regimes.fit(x, words).names == ("accelerating",)
    regimes = Regimes.fit(x, words, ("steady", "undetermined"))
    assert regimes.names == ("accelerating", "undetermined")
    left, right = regimes.predict(np.array([[0.1], [0.95]])).T
    assert left[1] > 0.9 and right[0] > 0.5 and left.sum() == pytest.approx(1)
