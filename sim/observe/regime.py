"""Mean, trend and regime of a velocity series within the averaging window."""

from dataclasses import dataclass

import numpy as np

#: Blocks that the averaging window is cut into; their means are treated as independent.
BLOCKS = 12

#: A trend counts as real when it exceeds this many standard errors.
SIGNIFICANT = 5.0

#: A significant trend is no trend only below this fraction of the negligible one.
TINY = 0.4


@dataclass(frozen=True)
class Scales:
    """What counts as small, from the parameters of a point.

    ``arrested`` (m/s): a velocity below it is no flow. A trend is none when it is below
    ``acceleration`` (m/s²), or changes the velocity by less than the fraction ``drift`` of its mean
    over the whole window.
    """

    arrested: float
    acceleration: float
    drift: float


@dataclass(frozen=True)
class Trend:
    """``velocity`` ± ``velocity_error`` (m/s), ``acceleration`` ± its error (m/s²), ``regime``."""

    velocity: float
    velocity_error: float
    acceleration: float
    acceleration_error: float
    regime: str


def block_means(values: np.ndarray, blocks: int = BLOCKS, period: int = 1) -> np.ndarray:
    """Return means over equal blocks of whole periods; what does not fill a block is left out.

    The remainder is dropped at the start, where the memory of the transient is strongest. Less than
    a period is one block.
    """
    period = min(period, len(values))
    periods = len(values) // period
    blocks = max(1, min(blocks, periods))
    length = periods // blocks * period
    used = values[len(values) - blocks * length :]
    return used.reshape(blocks, length).mean(axis=1)


def analyse(velocity: np.ndarray, interval: float, scales: Scales, period: int = 1) -> Trend:
    """Fit a line to block means of the velocity and name the regime.

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval (m/s).
    interval : float
        Time between samples (s).
    scales : Scales
        What counts as small.
    period : int
        Samples after which the driving repeats; blocks hold whole periods.

    Returns
    -------
    Trend
        The mean is over the last whole periods. Errors are standard errors from the scatter of the
        block means, not-a-number with fewer than three blocks; the regime is then undetermined.
    """
    means = block_means(velocity, period=period)
    mean = float(block_means(velocity, 1, period)[0])
    if len(means) < 3:
        return Trend(mean, np.nan, np.nan, np.nan, "undetermined")
    spacing = interval * (len(velocity) // period // len(means)) * period
    time = (np.arange(len(means)) - (len(means) - 1) / 2) * spacing
    (slope, _), covariance = np.polyfit(time, means, 1, cov=True)
    error = float(np.sqrt(covariance[0, 0]))
    mean_error = float(means.std(ddof=1) / np.sqrt(len(means)))
    window = spacing * len(means)
    negligible = max(scales.acceleration, scales.drift * abs(mean) / window)
    if np.abs(means[len(means) // 2 :]).max() < scales.arrested:
        regime = "arrested"
    else:
        regime = _moving_regime(float(slope), error, negligible)
    return Trend(mean, mean_error, float(slope), error, regime)


def _moving_regime(slope: float, error: float, negligible: float) -> str:
    """Name the regime of a flow; one that slows, or is too noisy to tell, is undetermined."""
    significant = abs(slope) > SIGNIFICANT * error
    if slope > negligible and significant:
        return "accelerating"
    if abs(slope) + 2.0 * error < negligible and not (
        significant and abs(slope) > TINY * negligible
    ):
        return "steady"
    return "undetermined"
