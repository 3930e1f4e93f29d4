"""Mean and slope of a correlated series with honest 95 % intervals, and where its transient ends.

End of the transient and statistical inefficiency come from pymbar (Chodera, J. Chem. Theory Comput.
12 (2016) 1799). Two things are added, because intervals from the inefficiency alone are too short
for series of a few dozen independent samples: as much again is discarded as the detection says, and
the widest of three intervals is taken, one from the inefficiency and two from means over batches.
"""

import functools
import importlib
import logging
import sys
from dataclasses import dataclass
from importlib.machinery import PathFinder
from types import ModuleType

import numpy as np

#: Share of cases in which an interval holds the true value.
CONFIDENCE = 0.95

#: Numbers of batches whose means give an interval each.
BATCHES = (6, 10)

#: Starts that are tried in the search for the end of the transient.
TRIALS = 50

#: Shortest series that is analysed at all: one sample per batch.
FEWEST = max(BATCHES)


@dataclass(frozen=True)
class Interval:
    """An estimate, its standard error and the half width of its 95 % interval."""

    value: float
    error: float
    half_width: float


def student(freedom: float, number: int = 1) -> np.float64:
    """Return the half width of a 95 % interval in standard errors, by Student's distribution.

    Of several intervals, so that all of a ``number`` hold together at 95 % (Bonferroni).
    """
    # A run needs it only at its end, and the import takes a quarter of a second.
    from scipy.special import stdtrit

    # As numpy's number it makes single precision double, which a float of Python's would not.
    return stdtrit(freedom, 1 - (1 - CONFIDENCE) / (2 * number))


@functools.cache
def _timeseries() -> ModuleType:
    """Return pymbar's module of time series, without the rest of the package.

    The package as a whole imports scipy.stats, which takes half a second, a third of a belt's run.
    """
    package = ModuleType("pymbar")
    found = PathFinder.find_spec("pymbar")
    if found is None:
        raise ModuleNotFoundError("No module named 'pymbar'")
    package.__path__ = found.submodule_search_locations
    loggers = [logging.getLogger(name) for name in ("pymbar", "numexpr")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.ERROR)
    sys.modules["pymbar"] = package
    try:
        return importlib.import_module("pymbar.timeseries")
    finally:
        del sys.modules["pymbar"]
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def inefficiency(series: np.ndarray) -> float:
    """Return how many successive samples are worth one independent one, at least 1."""
    if len(series) < 3 or np.ptp(series) == 0.0:
        return 1.0
    timeseries = _timeseries()
    try:
        return float(timeseries.statistical_inefficiency(series))
    except timeseries.ParameterError:
        # The variance of numbers this small is zero.
        return 1.0


def transient_end(series: np.ndarray) -> int:
    """Return how many samples of a series to discard as its transient, half of them at most.

    pymbar's start is the one that leaves the largest number of independent samples, which keeps a
    part of the transient as long as that pays; twice that keeps a bias well below the error.
    """
    if len(series) < 2 * FEWEST or np.ptp(series) == 0.0:
        return 0
    step = max(1, len(series) // TRIALS)
    start, _, _ = _timeseries().detect_equilibration(series, fast=True, nskip=step)
    return min(2 * int(start), len(series) // 2)


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
