"""The regime of a flow, and when a run of the converged protocol may end.

The regime follows from tests with known error rates on the trend of the mean velocity.

Each decision uses the 95 % interval of the slope. A flow is accelerating where the whole interval
is above the negligible slope, and steady where the whole interval is within it. Either verdict is
wrong in less than 5 % of cases. All other flows, and runs that are too short, are undetermined.
"""

from dataclasses import dataclass

import numpy as np

from sim.engine.observe.estimate import (
    FEWEST_SAMPLES,
    Interval,
    cycle_means,
    detrend,
    mean,
    slope,
    transient_end,
)

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

#: Reasons to end a run. The last one is for the published protocol.
TARGET, ARRESTED, ACCELERATING, LIMIT, LENGTH = (
    "target",
    "arrested",
    "accelerating",
    "limit",
    "length",
)


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

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval (m/s), without the transient.
    interval : float
        Time between samples (s).
    scales : Scales
        Thresholds of the tests.
    period : int
        Samples after which the driving repeats; the series is averaged over whole periods first.

    Returns
    -------
    Trend
        Errors are not-a-number, and the regime undetermined, with fewer than 10 means over periods.
    """
    cycles = cycle_means(velocity, period)
    average, trend = mean(cycles), slope(cycles, interval * period)
    if len(cycles) < FEWEST_SAMPLES:
        return Trend(average, trend, "undetermined", "short", float(len(cycles)))
    independent = _independent_samples(cycles, scales)
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


def _independent_samples(cycles: np.ndarray, scales: Scales) -> float:
    """Return the number of independent samples of a series about its trend; 0 for a constant."""
    if cycles.std() <= ROUNDING_SPREAD * scales.arrested and np.abs(cycles).max() < scales.arrested:
        return 0.0
    if np.ptp(cycles) == 0.0:
        return 0.0
    residuals = detrend(cycles)
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

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval since the start (m/s).
    interval, scales, period
        As for `sim.engine.observe.regime.analyse`.
    least : int
        Smallest number of samples of the transient.
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
