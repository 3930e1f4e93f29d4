"""Mean, trend and regime of synthetic velocity series."""

import numpy as np
import pytest

from sim.observe.regime import BLOCKS, Scales, analyse, block_means

INTERVAL = 0.01
CHUTE = Scales(arrested=1e-4, acceleration=0.03, drift=0.0)
BELT = Scales(arrested=1e-3, acceleration=0.0, drift=0.1)


def series(mean=0.5, slope=0.0, noise=0.01, samples=1200, seed=0) -> np.ndarray:
    """A line with white noise over ``samples`` intervals, the mean at its centre."""
    time = INTERVAL * (np.arange(samples) - (samples - 1) / 2)
    return mean + slope * time + noise * np.random.default_rng(seed).normal(size=samples)


def test_block_means_are_those_of_the_last_whole_blocks():
    values = np.arange(27.0)
    assert np.array_equal(block_means(values, 5), values[2:].reshape(5, 5).mean(axis=1))
    assert len(block_means(values)) == BLOCKS
    assert np.array_equal(block_means(values[:3]), [0.0, 1.0, 2.0])


@pytest.mark.parametrize("length", [200, 203, 219])
def test_blocks_hold_whole_periods(length):
    """A pure oscillation has the same mean in each block, whatever the window's length."""
    wave = np.sin(2 * np.pi * np.arange(length) / 20)
    assert np.abs(block_means(wave, period=20)).max() < 1e-12
    assert np.abs(block_means(wave)).max() > 0.1


@pytest.mark.parametrize("slope", [-0.2, 0.0, 0.05, 2.0])
def test_mean_and_slope_are_found_within_their_errors(slope):
    """Over 200 series the errors are as large as they say: their ratio has unit variance."""
    pulls = []
    for seed in range(200):
        trend = analyse(series(slope=slope, seed=seed), INTERVAL, CHUTE)
        pulls.append((trend.acceleration - slope) / trend.acceleration_error)
        assert trend.velocity == pytest.approx(0.5, abs=5 * 0.01 / np.sqrt(1200))
    assert abs(np.mean(pulls)) < 0.3
    assert np.std(pulls) == pytest.approx(np.sqrt(10 / 8), rel=0.2)


def test_velocity_error_is_the_standard_error_of_the_mean():
    errors = [analyse(series(seed=seed), INTERVAL, CHUTE).velocity_error for seed in range(200)]
    assert np.mean(errors) == pytest.approx(0.01 / np.sqrt(1200), rel=0.1)


@pytest.mark.parametrize(
    ("values", "scales", "regime"),
    [
        ({}, CHUTE, "steady"),
        ({"slope": 0.01}, CHUTE, "steady"),
        ({"slope": 2.0}, CHUTE, "accelerating"),
        ({"slope": 0.06}, CHUTE, "accelerating"),
        ({"slope": -0.5, "mean": 5.0}, CHUTE, "undetermined"),
        ({"slope": 0.05, "noise": 3.0}, CHUTE, "undetermined"),
        ({"mean": 0.0, "noise": 1e-5}, CHUTE, "arrested"),
        ({"mean": 0.0, "noise": 1e-3}, BELT, "arrested"),
        ({"slope": 0.001}, BELT, "steady"),
        ({"slope": 0.003}, BELT, "undetermined"),
        ({"slope": 0.02}, BELT, "accelerating"),
    ],
)
def test_regime_of_a_series(values, scales, regime):
    for seed in range(10):
        assert analyse(series(**values, seed=seed), INTERVAL, scales).regime == regime


def test_a_flow_that_stops_within_the_window_is_arrested():
    slowing = np.concatenate([np.linspace(0.5, 0.0, 300), np.zeros(900)])
    assert analyse(slowing, INTERVAL, CHUTE).regime == "arrested"


@pytest.mark.parametrize("mean", [0.0, 0.5])
def test_constant_series_is_steady_or_arrested_without_error(mean):
    trend = analyse(np.full(600, mean), INTERVAL, CHUTE)
    assert (trend.velocity, trend.velocity_error) == (mean, 0.0)
    assert trend.acceleration == pytest.approx(0.0, abs=1e-12)
    assert trend.acceleration_error == pytest.approx(0.0, abs=1e-12)
    assert trend.regime == ("steady" if mean else "arrested")


def test_a_perfect_line_is_an_acceleration():
    trend = analyse(series(slope=1.0, noise=0.0), INTERVAL, CHUTE)
    assert trend.acceleration == pytest.approx(1.0, rel=1e-9)
    assert trend.regime == "accelerating"


@pytest.mark.parametrize("samples", [1, 2])
def test_too_few_samples_leave_the_regime_open(samples):
    trend = analyse(series(samples=samples), INTERVAL, CHUTE)
    assert np.isfinite(trend.velocity)
    assert np.isnan([trend.velocity_error, trend.acceleration, trend.acceleration_error]).all()
    assert trend.regime == "undetermined"


@pytest.mark.parametrize("samples", [3, 4, 11, 12, 13, 25])
def test_few_samples_give_a_finite_trend(samples):
    trend = analyse(series(samples=samples, slope=3.0, noise=1e-6), INTERVAL, CHUTE)
    assert trend.acceleration == pytest.approx(3.0, rel=0.02)
    assert np.isfinite(trend.acceleration_error)


@pytest.mark.parametrize("extra", [0, 7, 19])
def test_periodic_driving_counts_for_nothing(extra):
    """A belt's oscillation, a hundred times the mean, over cycles that do not fill the window."""
    time = np.arange(45 * 20 + extra)
    shaken = 0.05 + 5.0 * np.sin(2 * np.pi * time / 20)
    trend = analyse(shaken, INTERVAL, BELT, period=20)
    assert trend.regime == "steady"
    assert trend.velocity == pytest.approx(0.05, abs=1e-12)
    assert abs(trend.acceleration) < 1e-9


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("samples", [1, 13, 20, 39])
def test_less_than_three_periods_leave_the_regime_open_and_have_a_mean(samples):
    trend = analyse(series(samples=samples, noise=0.0), INTERVAL, BELT, period=20)
    assert trend.velocity == pytest.approx(0.5)
    assert trend.regime == "undetermined" and np.isnan(trend.velocity_error)
