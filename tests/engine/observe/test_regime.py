"""Intervals and regimes of synthetic series, when their runs end, and how often both are wrong."""

import numpy as np
import pytest

from sim.engine.observe import regime
from sim.engine.observe.regime import (
    BATCHES,
    FEWEST_SAMPLES,
    RELIABLE_SAMPLES,
    TRIALS,
    Scales,
    analyse,
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


INTERVAL, DRIFT = 0.01, 0.1
CHUTE = Scales(arrested=1e-4, acceleration=0.03, drift=1.0, target=0.02)
BELT = Scales(arrested=1e-3, acceleration=np.inf, drift=DRIFT, target=0.02)


def series(mean=0.5, slope=0.0, noise=0.01, samples=1200, seed=0) -> np.ndarray:
    """A line with white noise over ``samples`` intervals, the mean at its centre."""
    time = INTERVAL * (np.arange(samples) - (samples - 1) / 2)
    return mean + slope * time + noise * np.random.default_rng(seed).normal(size=samples)


@pytest.mark.parametrize(
    ("values", "scales", "regime", "quality"),
    [
        ({}, CHUTE, "steady", "reliable"),
        ({"slope": 0.0002}, CHUTE, "steady", "reliable"),
        ({"slope": 2.0}, CHUTE, "accelerating", "drifting"),
        ({"slope": 0.06}, CHUTE, "accelerating", "drifting"),
        ({"slope": -0.5, "mean": 5.0}, CHUTE, "undetermined", "drifting"),
        ({"slope": 0.0, "noise": 3.0, "mean": 5.0}, CHUTE, "undetermined", "short"),
        ({"mean": 0.0, "noise": 1e-5}, CHUTE, "arrested", "reliable"),
        ({"mean": 0.0, "noise": 2e-4}, BELT, "arrested", "reliable"),
        ({"slope": 0.0003}, BELT, "steady", "reliable"),
        ({"slope": 0.002}, BELT, "steady", "drifting"),
        ({"slope": 0.02}, BELT, "accelerating", "drifting"),
        ({"slope": -0.02}, BELT, "undetermined", "drifting"),
        ({"slope": 1.0, "noise": 0.0}, CHUTE, "accelerating", "drifting"),
        ({"mean": 0.0, "noise": 1e-9}, CHUTE, "arrested", "jammed"),
        ({"mean": 0.0, "noise": 0.0}, CHUTE, "arrested", "jammed"),
        ({"noise": 0.0}, CHUTE, "steady", "jammed"),
    ],
)
def test_regime_of_a_series(values, scales, regime, quality):
    """Decisions far from the thresholds; a test that errs in 1 of 40 cases may err once in ten."""
    found = [analyse(series(**values, seed=seed), INTERVAL, scales) for seed in range(10)]
    assert sum(trend.regime == regime for trend in found) >= 9
    assert sum(trend.quality == quality for trend in found) >= 8


@pytest.mark.parametrize("slope", [2.0, 0.06, 0.0002, -0.06])
def test_a_flow_to_the_left_has_the_regime_of_its_mirror_image(slope):
    there = series(slope=slope)
    right, left = (analyse(values, INTERVAL, CHUTE) for values in (there, -there))
    assert (left.regime, left.quality) == (right.regime, right.quality)
    assert left.acceleration.value == pytest.approx(-right.acceleration.value)


@pytest.mark.parametrize(
    ("samples", "mean", "count"),
    [
        *[(200, 15.0, 60), (600, 40.0, 60), (2000, 150.0, 60)],
        *(
            pytest.param(samples, mean, 150, marks=pytest.mark.long)
            for samples in (200, 600, 2000)
            for mean in (15.0, 40.0, 150.0)
        ),
    ],
)
def test_a_drift_is_called_steady_in_less_than_five_per_cent_of_cases(samples, mean, count):
    """At the smallest change that counts as a drift, however long and noisy the series is."""
    rng = np.random.default_rng(11)
    steady = [
        analyse(with_drift(rng, samples, 5, mean, DRIFT * mean), 1.0, BELT).regime == "steady"
        for _ in range(count)
    ]
    assert np.mean(steady) < 0.05


@pytest.mark.parametrize("count", [60, pytest.param(200, marks=pytest.mark.long)])
def test_a_steady_flow_is_called_accelerating_in_less_than_five_per_cent_of_cases(count):
    rng = np.random.default_rng(12)
    found = [analyse(15.0 + correlated(rng, 300, 5), 1.0, BELT).regime for _ in range(count)]
    assert np.mean([regime == "accelerating" for regime in found]) < 0.05


def test_slow_correlations_are_short_of_independent_samples():
    noisy = 40.0 + correlated(np.random.default_rng(4), 400, 60)
    found = analyse(noisy, 1.0, Scales(1e-3, np.inf, 10.0, 0.02))
    assert found.independent < RELIABLE_SAMPLES
    assert (found.regime, found.quality) == ("steady", "short")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("samples", "period"), [(1, 1), (2, 1), (9, 1), (13, 20), (39, 20)])
def test_too_few_samples_leave_the_regime_open(samples, period):
    found = analyse(series(samples=samples), INTERVAL, CHUTE, period)
    assert np.isfinite(found.velocity.value)
    assert np.isnan([found.velocity.error, found.acceleration.value]).all()
    assert (found.regime, found.quality) == ("undetermined", "short")


@pytest.mark.parametrize("extra", [0, 7, 19])
def test_periodic_driving_counts_for_nothing(extra):
    """A belt's oscillation, a hundred times the mean, over cycles that do not fill the window."""
    time = np.arange(45 * 20 + extra)
    shaken = 0.05 + 5.0 * np.sin(2 * np.pi * time / 20)
    found = analyse(shaken, INTERVAL, BELT, period=20)
    assert found.velocity.value == pytest.approx(0.05, abs=1e-12)
    assert abs(found.acceleration.value) < 1e-9
    assert found.regime == "steady"


def run_to_the_end(velocity, shortest):
    """Look at a series as a run would; return length, window start, trend and reason."""
    before = ""
    for length in regime.look_lengths(shortest, len(velocity)):
        start, trend, reason = regime.verdict(velocity[:length], 1.0, BELT, 1, 0)
        if reason and reason in (before, regime.ARRESTED):
            return length, start, trend, reason
        before = reason
    return length, start, trend, ""


@pytest.mark.parametrize("count", [10, pytest.param(30, marks=pytest.mark.long)])
def test_a_run_stops_when_its_mean_is_known_well_enough(count):
    """Noisy runs all stop at the target, before the limit, and nineteen in twenty cover."""
    rng = np.random.default_rng(5)
    covered, lengths = [], []
    for _ in range(count):
        velocity = 5.0 + with_transient(rng, 40_000, 10, 5.0, 0.004)
        length, _, trend, reason = run_to_the_end(velocity, 400)
        assert reason == regime.TARGET
        assert trend.velocity.half_width <= 0.02 * trend.velocity.value
        lengths.append(length)
        covered.append(abs(trend.velocity.value - 5.0) < trend.velocity.half_width)
    assert np.mean(covered) > 0.88
    assert max(lengths) < 40_000


@pytest.mark.parametrize("relaxation", [300, pytest.param(600, marks=pytest.mark.long)])
def test_a_slow_relaxation_is_waited_for(relaxation):
    """A flow that still relaxes when it is first looked at ends with the steady mean.

    Of 40 runs those that stop at the target are off by less than the target on average, and 17 in
    20 of their intervals hold; the others go on to the limit.
    """
    rng = np.random.default_rng(14)
    time = np.arange(12_000)
    off, held = [], []
    for _ in range(40):
        velocity = 1.0 - 0.3 * np.exp(-time / relaxation) + 0.02 * correlated(rng, time.size, 20)
        _, _, trend, reason = run_to_the_end(velocity, 2000)
        assert reason == regime.TARGET
        off.append(trend.velocity.value - 1.0)
        held.append(abs(off[-1]) < trend.velocity.half_width)
    assert abs(np.mean(off)) < 0.01
    assert np.mean(held) > 0.8


def test_a_flow_at_rest_or_in_lasting_acceleration_is_not_waited_for():
    velocity = np.concatenate([np.linspace(5.0, 0.0, 100), np.zeros(3000)])
    length, _, trend, reason = run_to_the_end(velocity, 400)
    assert (length, trend.regime, reason) == (400, "arrested", regime.ARRESTED)
    velocity = 0.01 * np.arange(5000) + 0.1 * correlated(np.random.default_rng(8), 5000, 5)
    length, _, trend, reason = run_to_the_end(velocity, 400)
    assert (trend.regime, reason) == ("accelerating", regime.ACCELERATING)
    assert length < 1000
    velocity = 1.0 + correlated(np.random.default_rng(7), 2000, 50)
    assert run_to_the_end(velocity, 400)[::3] == (2000, "")


def test_the_rise_of_a_transient_is_not_taken_for_a_lasting_acceleration():
    rng = np.random.default_rng(9)
    for _ in range(10):
        time = np.arange(6000)
        velocity = 20.0 * (1 - np.exp(-time / 500)) + 0.3 * correlated(rng, 6000, 10)
        _, start, trend, reason = run_to_the_end(velocity, 500)
        assert reason == regime.TARGET
        assert trend.velocity.value == pytest.approx(20.0, rel=0.03)
        assert start > 500


def test_the_window_of_a_driven_series_starts_with_a_cycle():
    wave = np.sin(2 * np.pi * np.arange(1010) / 20)
    start = regime.window_start(wave + np.exp(-np.arange(1010) / 50), 20)
    assert (1010 - start) % 20 == 0 and start > 0
    for least in (0, 7, 100, 333):
        start = regime.window_start(correlated(np.random.default_rng(10), 1000, 3), 20, least)
        assert start >= least and (1000 - start) % 20 == 0
