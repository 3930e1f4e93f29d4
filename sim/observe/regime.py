"""The regime of a flow, by tests with stated error rates on the trend of its mean velocity.

Each decision rests on a 95 % interval of the slope: a flow is called accelerating or steady though
it is not in at most 2.5 % of cases, for the interval must lie beyond, or within, what is negligible
as a whole. What the interval leaves open is undetermined.
"""

from dataclasses import dataclass

import numpy as np

from sim.observe.estimate import FEWEST, Interval, cycle_means, mean, slope

#: Independent samples that a mean needs for its interval to hold; with fewer it is `short`.
INDEPENDENT = 15.0


@dataclass(frozen=True)
class Scales:
    """What counts as small, from the parameters of a point.

    ``arrested`` (m/s): a velocity below it is no flow. A trend is none when it is below
    ``acceleration`` (m/s²) and changes the velocity by less than the fraction ``drift`` of its mean
    over the whole window.
    """

    arrested: float
    acceleration: float
    drift: float


@dataclass(frozen=True)
class Trend:
    """Mean and slope of the velocity (m/s, m/s²), the regime, and what the mean is worth.

    ``quality``: `reliable`; `short`: too few independent samples for an interval that holds, or to
    rule out a drift; `drifting`: the velocity changes, so its mean is that of the window alone;
    `jammed`: the velocity is constant, so there is no scatter to tell an error from; `failed`.
    ``independent`` is the number of independent samples.
    """

    velocity: Interval
    acceleration: Interval
    regime: str
    quality: str
    independent: float


UNKNOWN = Interval(np.nan, np.nan, np.nan)

#: Of a run that blew up: no mean and no regime.
FAILED = Trend(UNKNOWN, UNKNOWN, "undetermined", "failed", np.nan)


def analyse(velocity: np.ndarray, interval: float, scales: Scales, period: int = 1) -> Trend:
    """Find mean, slope and regime of a velocity series.

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval (m/s), the transient left out.
    interval : float
        Time between samples (s).
    scales : Scales
        What counts as small.
    period : int
        Samples after which the driving repeats; the series is averaged over whole periods first.

    Returns
    -------
    Trend
        Errors are not-a-number, and the regime undetermined, with fewer than 10 means over periods.
    """
    cycles = cycle_means(velocity, period)
    average, trend = mean(cycles), slope(cycles, interval * period)
    if len(cycles) < FEWEST:
        return Trend(average, trend, "undetermined", "short", float(len(cycles)))
    independent = (cycles.std(ddof=1) / average.error) ** 2 if np.ptp(cycles) else 0.0
    regime = _regime(cycles, average, trend, scales, interval * period * len(cycles))
    return Trend(average, trend, regime, _quality(trend, regime, independent), float(independent))


def _regime(
    cycles: np.ndarray, average: Interval, trend: Interval, scales: Scales, window: float
) -> str:
    """Name the regime of a series of means over periods that spans a ``window`` (s)."""
    if np.abs(cycles[len(cycles) // 2 :]).max() < scales.arrested:
        return "arrested"
    negligible = min(scales.acceleration, scales.drift * abs(average.value) / window)
    if trend.value - trend.half_width > negligible:
        return "accelerating"
    if abs(trend.value) + trend.half_width < negligible:
        return "steady"
    return "undetermined"


def _quality(trend: Interval, regime: str, independent: float) -> str:
    if independent == 0.0:
        return "jammed"
    if regime not in ("steady", "arrested") and abs(trend.value) > trend.half_width:
        return "drifting"
    return "short" if regime == "undetermined" or independent < INDEPENDENT else "reliable"
