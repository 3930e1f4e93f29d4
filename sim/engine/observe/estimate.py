"""Mean and slope of a correlated series with honest 95 % intervals, and the end of its transient.

End of the transient and statistical inefficiency follow Chodera (J. Chem. Theory Comput. 12 (2016)
1799) and agree to the bit with his pymbar, which takes half a second to import. Intervals from the
inefficiency alone are too short for series of a few dozen independent samples. So twice the
detected transient is discarded, and the widest of three intervals is used: one from the
inefficiency and two from means over batches.
"""

from dataclasses import dataclass

import numpy as np

from sim.base.statistics import student

#: Numbers of batches; each number gives one interval.
BATCHES = (6, 10)

#: Number of starts in the search for the end of the transient.
TRIALS = 50

#: Largest lag up to which the autocorrelation counts whatever its sign.
LEAST_LAG = 3

#: Length of the shortest series that is analysed: one sample per batch.
FEWEST_SAMPLES = max(BATCHES)


@dataclass(frozen=True)
class Interval:
    """An estimate, its standard error and the half width of its 95 % interval."""

    value: float
    error: float
    half_width: float


def inefficiency(series: np.ndarray) -> float:
    """Return the number of successive samples that equal one independent sample, at least 1."""
    if len(series) < 3 or np.ptp(series) == 0.0:
        return 1.0
    value = _inefficiency(series, growth=0)
    return 1.0 if np.isnan(value) else value


def _inefficiency(series: np.ndarray, growth: int) -> float:
    """Return 1 + 2 τ, τ the integral of the autocorrelation to where it first falls to zero.

    The distance between the lags of the sum increases by ``growth`` each time. Not-a-number where
    the variance is zero, as it is for very small numbers.
    """
    fluctuation = series - series.mean()
    variance = (fluctuation * fluctuation).mean()
    if variance == 0.0:
        return np.nan
    size, total, lag, step = len(series), 1.0, 1, 1
    while lag < size - 1:
        products = fluctuation[:-lag] * fluctuation[lag:]
        correlation = products.sum() / ((size - lag) * variance)
        if correlation <= 0.0 and lag > LEAST_LAG:
            break
        total += 2.0 * correlation * (1.0 - lag / size) * step
        lag += step
        step += growth
    return float(max(total, 1.0))


def transient_end(series: np.ndarray) -> int:
    """Return the number of samples to discard as transient, at most half of the series.

    The start that leaves the largest number of independent samples may still include a part of the
    transient. Twice that start keeps the bias well below the error.
    """
    if len(series) < 2 * FEWEST_SAMPLES or np.ptp(series) == 0.0 or series.std() == 0.0:
        return 0
    starts = range(0, len(series) - 1, max(1, len(series) // TRIALS))
    start = starts[int(np.argmax([_independent_samples(series[start:]) for start in starts]))]
    return min(2 * start, len(series) // 2)


def _independent_samples(series: np.ndarray) -> np.float32:
    """Return the number of independent samples, in single precision as in pymbar."""
    value, samples = _inefficiency(series, growth=1), len(series) + 1
    return samples / np.float32(samples if np.isnan(value) else value)


def mean(series: np.ndarray) -> Interval:
    """Return the mean of a stationary series; its errors are not-a-number below 10 samples."""
    value = float(series.mean()) if len(series) else np.nan
    if len(series) < FEWEST_SAMPLES:
        return Interval(value, np.nan, np.nan)
    independent = max(2.0, len(series) / inefficiency(series))
    errors = [(series.std(ddof=1) / np.sqrt(independent), independent - 1.0)]
    for batches in BATCHES:
        means = batch_means(series, batches)
        errors.append((means.std(ddof=1) / np.sqrt(batches), batches - 1.0))
    return _widest_interval(value, errors)


def slope(series: np.ndarray, interval: float) -> Interval:
    """Return the slope (per second) of a series with one sample per ``interval`` (s)."""
    if len(series) < FEWEST_SAMPLES:
        return Interval(np.nan, np.nan, np.nan)
    value, spread, residuals = _fit_line(series)
    independent = max(3.0, len(series) / inefficiency(residuals))
    errors = [(spread * np.sqrt(len(series) / independent), independent - 2.0)]
    for batches in BATCHES:
        _, spread, _ = _fit_line(batch_means(series, batches))
        errors.append((spread * batches / len(series), batches - 2.0))
    step = _widest_interval(value, errors)
    return Interval(step.value / interval, step.error / interval, step.half_width / interval)


def detrend(series: np.ndarray) -> np.ndarray:
    """Return a series minus its mean and its linear trend."""
    _, _, residuals = _fit_line(series)
    return residuals


def batch_means(series: np.ndarray, batches: int) -> np.ndarray:
    """Return means over equal batches; surplus samples are omitted at the start."""
    length = len(series) // batches
    return series[len(series) - batches * length :].reshape(batches, length).mean(axis=1)


def cycle_means(series: np.ndarray, period: int) -> np.ndarray:
    """Return means over whole periods (samples); an incomplete period is omitted at the start.

    A series shorter than a period gives one mean over all of it.
    """
    cycles = len(series) // period
    if cycles == 0:
        return series.mean(keepdims=True) if len(series) else series
    return batch_means(series[len(series) - cycles * period :], cycles)


def _fit_line(series: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Return slope per sample, its error for independent samples, and the residuals."""
    number = np.arange(len(series)) - (len(series) - 1) / 2
    scale = (number**2).sum()
    steepness = float(number @ series / scale)
    residuals = series - series.mean() - steepness * number
    return steepness, float(np.sqrt((residuals**2).sum() / (len(series) - 2) / scale)), residuals


def _widest_interval(value: float, errors: list[tuple[float, float]]) -> Interval:
    """Return the widest Student interval of a value from errors with their degrees of freedom."""
    widths = [error * student(freedom) for error, freedom in errors]
    widest = int(np.argmax(widths))
    return Interval(value, float(errors[widest][0]), float(widths[widest]))
