"""Intervals of correlated series: how often they hold, and what is left of transients."""

import numpy as np
import pytest

from sim.engine.observe.regime import (
    BATCHES,
    FEWEST_SAMPLES,
    TRIALS,
    batch_means,
    cycle_means,
    inefficiency,
    mean,
    slope,
    transient_end,
)
from tests.engine_motion.points import correlated, with_drift, with_transient

#: Samples, statistical inefficiency, size of the transient (in standard deviations), its share.
KINDS = [
    (400, 8, 0.0, 0.0),
    (400, 8, 4.0, 0.03),
    (600, 8, 4.0, 0.08),
    (600, 12, 2.0, 0.05),
    (1500, 20, 6.0, 0.05),
]


def counting_error(count: int) -> float:
    """Standard deviation of a share of 95 % that is counted in so many cases."""
    return float(np.sqrt(0.05 * 0.95 / count))


@pytest.fixture(scope="module", params=[40, pytest.param(200, marks=pytest.mark.long)])
def studied(request):
    """What is known of the means of some series of each kind after truncation."""
    rng = np.random.default_rng(7)
    return {
        kind: [
            mean(series[transient_end(series) :])
            for series in (with_transient(rng, *kind) for _ in range(request.param))
        ]
        for kind in KINDS
    }


def test_intervals_cover_the_mean_as_often_as_they_say(studied):
    """95 % intervals cover in 95 % of all series and of each kind, within counting errors."""
    covered = [[abs(found.value) < found.half_width for found in kind] for kind in studied.values()]
    assert np.mean(covered) == pytest.approx(0.95, abs=4 * counting_error(np.size(covered)))
    each = len(covered[0])
    assert min(np.mean(kind) for kind in covered) > 0.95 - 4 * counting_error(each)


def test_what_is_left_of_the_transient_is_below_one_standard_error(studied):
    for kind, found in studied.items():
        values = np.array([one.value for one in found])
        assert abs(values.mean()) < 0.5 * values.std(), kind


def test_intervals_are_not_needlessly_wide(studied):
    """Within 30 % of what the known inefficiency of an untruncated series would give."""
    for (samples, known, size, _), found in studied.items():
        if size == 0.0:
            ideal = 1.96 * np.sqrt(known / samples)
            assert np.median([one.half_width for one in found]) < 1.5 * ideal


@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.long)])
def test_slopes_are_covered_too(count):
    rng = np.random.default_rng(8)
    hits = []
    for _ in range(count):
        found = slope(with_drift(rng, 500, 10, 3.0, 2.0), 0.1)
        hits.append(abs(found.value - 2.0 / (499 * 0.1)) < found.half_width)
    assert np.mean(hits) > 0.95 - 3 * counting_error(count)


def test_both_numbers_are_those_of_pymbar_to_the_bit():
    """Also of series that are at rest in the end, tiny, or constant but for rounding."""
    from pymbar import timeseries

    rng = np.random.default_rng(3)
    for samples in (20, 21, 50, 99, 400, 1501):
        noise, number = correlated(rng, samples, 8.0), np.arange(samples)
        for series in (
            rng.normal(size=samples),
            noise,
            noise * (-1) ** number,
            noise + 20 * np.exp(-number / (0.1 * samples)),
            noise + np.linspace(0, 10, samples),
            np.where(number < 0.4 * samples, noise, 0.0),
            1e-160 * noise,
            np.where(rng.random(samples) < 0.5, 0.1, np.nextafter(0.1, 1)),
        ):
            step = max(1, samples // TRIALS)
            start, _, _ = timeseries.detect_equilibration(series, fast=True, nskip=step)
            assert transient_end(series) == min(2 * start, samples // 2)
            for part in filter(np.ptp, (series, series[:3], series[samples // 3 :])):
                try:
                    expected = timeseries.statistical_inefficiency(part)
                except timeseries.ParameterError:
                    expected = 1.0
                assert inefficiency(part) == expected


@pytest.mark.filterwarnings("error")
def test_short_and_constant_series_have_a_mean_and_lines_a_slope_without_error():
    for samples in (0, 1, 2, FEWEST_SAMPLES - 1, FEWEST_SAMPLES, 37):
        series = np.full(samples, 3.0)
        found, trend = mean(series), slope(series, 1.0)
        error = 0.0 if samples >= FEWEST_SAMPLES else np.nan
        assert found.value == 3.0 or samples == 0
        assert (found.error, found.half_width) == pytest.approx((error, error), nan_ok=True)
        assert trend.value == pytest.approx(error, abs=1e-15, nan_ok=True)
        assert transient_end(series) == 0
    line = slope(0.5 * np.arange(100.0), 0.1)
    assert (line.value, line.half_width) == pytest.approx((5.0, 0.0), rel=1e-12, abs=1e-9)


def test_the_widest_interval_counts():
    """A series whose batches agree while its samples do not, and one the other way round."""
    rng = np.random.default_rng(3)
    noise = rng.normal(size=600)
    calm = np.tile(np.concatenate([noise[:30], -noise[:30]]), 10)
    assert mean(calm).half_width > 0.0
    steps = np.repeat(rng.normal(size=BATCHES[0]), 100) + 1e-6 * rng.normal(size=600)
    assert mean(steps).half_width > 0.5 * batch_means(steps, BATCHES[0]).std() / np.sqrt(6)


@pytest.mark.parametrize("length", [200, 203, 219])
def test_cycles_hold_whole_periods(length):
    """A pure oscillation has the same mean in each cycle, whatever the length of the series."""
    wave = np.sin(2 * np.pi * np.arange(length) / 20)
    assert len(cycle_means(wave, 20)) == length // 20
    assert np.abs(cycle_means(wave, 20)).max() < 1e-12
    assert np.array_equal(cycle_means(wave, 1), wave)
    assert np.array_equal(cycle_means(np.arange(5.0), 20), [2.0])
