"""The regime of a flow, and when a run of the converged protocol may end.

The regime follows from tests with known error rates on the trend of the mean velocity.

Each decision uses the 95 % interval of the slope. A flow is accelerating where the whole interval
is above the negligible slope, and steady where the whole interval is within it. Either verdict is
wrong in less than 5 % of cases. All other flows, and runs that are too short, are undetermined.
"""

from dataclasses import dataclass

import numpy as np

from sim.base.statistics import student

# Mean and slope of a correlated series with honest 95 % intervals, and the end of its transient.
#
# End of the transient and statistical inefficiency follow Chodera (J. Chem. Theory Comput. 12
# (2016) 1799) and agree to the bit with his pymbar, which takes half a second to import. Intervals
# from the inefficiency alone are too short for series of a few dozen independent samples. So twice
# the detected transient is discarded, and the widest of three intervals is used: one from the
# inefficiency and two from means over batches.

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


#: Smallest number of independent samples for a valid interval of the mean; below it is `short`.
RELIABLE_SAMPLES = 15.0

#: With fewer independent samples than this, a slow fluctuation and a trend cannot be distinguished,
#: and the regime is undetermined unless an acceleration is evident. An evident acceleration changes
#: the velocity by this share of its mean within the window, or exceeds its half width by this
#: factor.
OPEN_SAMPLES, EVIDENT_GAIN, EVIDENT_RATIO = 8.0, 0.5, 5.0

#: A spread below this share of ``Scales.arrested`` is due to rounding.
ROUNDING_SPREAD = 1e-3

UNKNOWN_INTERVAL = Interval(np.nan, np.nan, np.nan)

#: Ratio of the lengths of a run at successive looks, at which it is analysed. It ends when two
#: looks in a row give the same reason. Looks are few, because each is a chance to stop by accident.
GROWTH = 1.35

#: An acceleration is not the end of a transient if it stays above this share of its value in the
#: first half of the window.
LASTING_SHARE = 0.85

#: Reasons to end a run. The last two are for the published protocol and for its full length.
TARGET, ARRESTED, ACCELERATING = "target", "arrested", "accelerating"
LENGTH, LIMIT = "length", "limit"


@dataclass(frozen=True)
class Scales:
    """Thresholds of the regime tests, from the parameters of a point.

    A flow with a velocity below ``arrested`` (m/s) is at rest. A trend is negligible when it is
    below ``acceleration`` (m/s²) and changes the velocity by less than the fraction ``drift`` of
    its mean over the whole window. ``target`` is the required relative precision of the mean.
    """

    arrested: float
    acceleration: float
    drift: float
    target: float


@dataclass(frozen=True)
class Trend:
    """Mean and slope of the velocity (m/s, m/s²), the regime, and the quality of the mean.

    ``quality``: `reliable`; `short`: too few independent samples for a valid interval or to exclude
    a drift; `drifting`: the velocity changes, so its mean holds for the window alone; `jammed`: the
    velocity is constant, so there is no scatter to estimate an error; `failed`. ``independent`` is
    the number of independent samples about the trend.
    """

    velocity: Interval
    acceleration: Interval
    regime: str
    quality: str
    independent: float


#: The trend of a run that blew up: no mean and no regime.
FAILED_TREND = Trend(UNKNOWN_INTERVAL, UNKNOWN_INTERVAL, "undetermined", "failed", np.nan)


def analyse(velocity: np.ndarray, interval: float, scales: Scales, period: int = 1) -> Trend:
    """Return mean, slope, regime and quality of a velocity series.

    ``velocity`` (T,) has the mean velocity per sample interval (m/s), without the transient;
    samples are ``interval`` (s) apart, and ``scales`` the thresholds of the tests. The driving
    repeats after ``period`` samples; the series is averaged over whole periods first. Errors are
    not-a-number, and the regime undetermined, with fewer than 10 means over periods.
    """
    cycles = cycle_means(velocity, period)
    average, trend = mean(cycles), slope(cycles, interval * period)
    if len(cycles) < FEWEST_SAMPLES:
        return Trend(average, trend, "undetermined", "short", float(len(cycles)))
    independent = _independent(cycles, scales)
    # A flow to the left gains speed where its velocity decreases.
    gain = -trend.value if average.value < 0.0 else trend.value
    window = interval * period * len(cycles)
    change = gain * window / abs(average.value or np.inf)
    negligible = min(scales.acceleration, scales.drift * abs(average.value) / window)
    regime = _regime(cycles, gain, trend.half_width, negligible, scales.arrested)
    evident = regime == "accelerating" and (
        change > EVIDENT_GAIN or gain > EVIDENT_RATIO * trend.half_width
    )
    if regime != "arrested" and 0.0 < independent < OPEN_SAMPLES and not evident:
        regime = "undetermined"
    significant = abs(gain) > trend.half_width
    if independent == 0.0:
        quality = "jammed"
    elif (
        regime != "arrested" and significant and (abs(change) > scales.target or regime != "steady")
    ):
        quality = "drifting"
    else:
        few = regime == "undetermined" or independent < RELIABLE_SAMPLES
        quality = "short" if few else "reliable"
    return Trend(average, trend, regime, quality, independent)


def _independent(cycles: np.ndarray, scales: Scales) -> float:
    """Return the number of independent samples of a series about its trend; 0 for a constant."""
    if cycles.std() <= ROUNDING_SPREAD * scales.arrested and np.abs(cycles).max() < scales.arrested:
        return 0.0
    if np.ptp(cycles) == 0.0:
        return 0.0
    _, _, residuals = _fit_line(cycles)
    error = mean(residuals).error
    return float((residuals.std(ddof=1) / error) ** 2) if error > 0.0 else float(len(cycles))


def _regime(
    cycles: np.ndarray, gain: float, half_width: float, negligible: float, arrested: float
) -> str:
    """Return the regime of a series of means over periods whose speed has the slope ``gain``."""
    if np.abs(cycles[len(cycles) // 2 :]).max() < arrested:
        return "arrested"
    if gain - half_width > negligible:
        return "accelerating"
    if abs(gain) + half_width < negligible:
        return "steady"
    return "undetermined"


def look_lengths(shortest: int, longest: int) -> list[int]:
    """Return the lengths (samples) at which a run is analysed; the last one is its full length."""
    lengths, length = [], float(shortest)
    while length < longest:
        lengths.append(int(length))
        length *= GROWTH
    return [*lengths, longest]


def window_start(velocity: np.ndarray, period: int, least: int = 0) -> int:
    """Return the number of samples of a velocity series to omit as transient.

    It is at least ``least``, which comes from the user or the paper; whole periods remain.
    """
    cycles = cycle_means(velocity, period)
    length = (len(cycles) - transient_end(cycles)) * period
    start = max(least, len(velocity) - length, 0)
    return start + (len(velocity) - start) % period if len(velocity) - start >= period else start


def verdict(
    velocity: np.ndarray, interval: float, scales: Scales, period: int, least: int
) -> tuple[int, Trend, str]:
    """Return start of the window (samples), its trend, and the reason to end the run or ``""``.

    ``velocity`` (T,) is the mean velocity per sample interval since the start (m/s), ``least`` the
    smallest number of samples of the transient; the rest as for `analyse`.
    """
    start = window_start(velocity, period, least)
    window = velocity[start:]
    trend = analyse(window, interval, scales, period)
    reason = ""
    if trend.regime == "arrested":
        reason = ARRESTED
    elif trend.regime == "accelerating" and _is_lasting(window, interval, period):
        reason = ACCELERATING
    elif trend.regime == "steady" and trend.quality == "reliable":
        is_precise = trend.velocity.half_width <= scales.target * abs(trend.velocity.value)
        reason = TARGET if is_precise else ""
    return start, trend, reason


def _is_lasting(window: np.ndarray, interval: float, period: int) -> bool:
    """True where the acceleration in the second half of a window is about that in the first."""
    cycles = cycle_means(window, period)
    early, late = np.array_split(cycles, 2)
    before, after = (slope(part, interval * period) for part in (early, late))
    half_width = np.hypot(after.half_width, LASTING_SHARE * before.half_width)
    is_lasting = after.value - LASTING_SHARE * before.value > half_width
    return bool(is_lasting and before.value > before.half_width)
