"""Mean and slope of a correlated series with honest 95 % intervals, and where its transient ends.

End of the transient and statistical inefficiency are those of Chodera (J. Chem. Theory Comput. 12
(2016) 1799), to the bits of his pymbar, which takes half a second to import. Two things are added,
because intervals from the inefficiency alone are too short for series of a few dozen independent
samples: as much again is discarded as the detection says, and the widest of three intervals is
taken, one from the inefficiency and two from means over batches.
"""

from dataclasses import dataclass

import numpy as np

from sim.base.statistics import student

#: Numbers of batches whose means give an interval each.
BATCHES = (6, 10)

#: Starts that are tried in the search for the end of the transient.
TRIALS = 50

#: Largest lag up to which the autocorrelation counts whatever its sign.
LEAST_LAG = 3

#: Shortest series that is analysed at all: one sample per batch.
FEWEST = max(BATCHES)


@dataclass(frozen=True)
class Interval:
    """An estimate, its standard error and the half width of its 95 % interval."""

    value: float
    error: float
    half_width: float


def inefficiency(series: np.ndarray) -> float:
    """Return how many successive samples are worth one independent one, at least 1."""
    if len(series) < 3 or np.ptp(series) == 0.0:
        return 1.0
    found = _inefficiency(series, growth=0)
    return 1.0 if np.isnan(found) else found


def _inefficiency(series: np.ndarray, growth: int) -> float:
    """Return 1 + 2 τ, τ the integral of the autocorrelation to where it first falls to zero.

    The lags at which it is taken are ``growth`` farther apart each time. Not-a-number where the
    variance is zero, as that of very small numbers is.
    """
    fluctuation = series - series.mean()
    variance = (fluctuation * fluctuation).mean()
    if variance == 0.0:
        return np.nan
    size, found, lag, step = len(series), 1.0, 1, 1
    while lag < size - 1:
        products = fluctuation[:-lag] * fluctuation[lag:]
        correlation = products.sum() / ((size - lag) * variance)
        if correlation <= 0.0 and lag > LEAST_LAG:
            break
        found += 2.0 * correlation * (1.0 - lag / size) * step
        lag += step
        step += growth
    return float(max(found, 1.0))


def transient_end(series: np.ndarray) -> int:
    """Return how many samples of a series to discard as its transient, half of them at most.

    The start that leaves the largest number of independent samples keeps a part of the transient as
    long as that pays; twice that keeps a bias well below the error.
    """
    if len(series) < 2 * FEWEST or np.ptp(series) == 0.0 or series.std() == 0.0:
        return 0
    starts = range(0, len(series) - 1, max(1, len(series) // TRIALS))
    start = starts[int(np.argmax([_independent(series[start:]) for start in starts]))]
    return min(2 * start, len(series) // 2)


def _independent(series: np.ndarray) -> np.float32:
    """Return the number of independent samples, in single precision as pymbar compares them."""
    found, samples = _inefficiency(series, growth=1), len(series) + 1
    return samples / np.float32(samples if np.isnan(found) else found)


def mean(series: np.ndarray) -> Interval:
    """Return the mean of a stationary series; not-a-number for errors of fewer than 10 samples."""
    value = float(series.mean()) if len(series) else np.nan
    if len(series) < FEWEST:
        return Interval(value, np.nan, np.nan)
    independent = max(2.0, len(series) / inefficiency(series))
    errors = [(series.std(ddof=1) / np.sqrt(independent), independent - 1.0)]
    for batches in BATCHES:
        means = batch_means(series, batches)
        errors.append((means.std(ddof=1) / np.sqrt(batches), batches - 1.0))
    return _widest(value, errors)


def slope(series: np.ndarray, interval: float) -> Interval:
    """Return the slope (per second) of a series with one sample per ``interval`` (s)."""
    if len(series) < FEWEST:
        return Interval(np.nan, np.nan, np.nan)
    value, spread, residuals = _line(series)
    independent = max(3.0, len(series) / inefficiency(residuals))
    errors = [(spread * np.sqrt(len(series) / independent), independent - 2.0)]
    for batches in BATCHES:
        _, spread, _ = _line(batch_means(series, batches))
        errors.append((spread * batches / len(series), batches - 2.0))
    found = _widest(value, errors)
    return Interval(found.value / interval, found.error / interval, found.half_width / interval)


def detrended(series: np.ndarray) -> np.ndarray:
    """Return what is left of a series without its mean and its slope."""
    _, _, residuals = _line(series)
    return residuals


def batch_means(series: np.ndarray, batches: int) -> np.ndarray:
    """Return means over equal batches; what does not fill them is left out at the start."""
    length = len(series) // batches
    return series[len(series) - batches * length :].reshape(batches, length).mean(axis=1)


def cycle_means(series: np.ndarray, period: int) -> np.ndarray:
    """Return means over whole periods (samples); a part of one is left out at the start.

    Less than a period gives one mean over all there is.
    """
    cycles = len(series) // period
    if cycles == 0:
        return series.mean(keepdims=True) if len(series) else series
    return batch_means(series[len(series) - cycles * period :], cycles)


def _line(series: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Return slope per sample, its error for independent samples, and the residuals."""
    number = np.arange(len(series)) - (len(series) - 1) / 2
    scale = (number**2).sum()
    steepness = float(number @ series / scale)
    residuals = series - series.mean() - steepness * number
    return steepness, float(np.sqrt((residuals**2).sum() / (len(series) - 2) / scale)), residuals


def _widest(value: float, errors: list[tuple[float, float]]) -> Interval:
    """Choose the error (with its degrees of freedom) that gives the widest Student interval."""
    widths = [error * student(freedom) for error, freedom in errors]
    widest = int(np.argmax(widths))
    return Interval(value, float(errors[widest][0]), float(widths[widest]))
