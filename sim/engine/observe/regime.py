"""The regime of a flow, by tests with stated error rates on the trend of its mean velocity.

Each decision rests on a 95 % interval of the slope, which must lie beyond, or within, what is
negligible as a whole: a flow is called accelerating or steady though it is not in less than 5 % of
cases. What the interval leaves open is undetermined, and so is a flow seen for too short a time.
"""

from dataclasses import dataclass

import numpy as np

from sim.engine.observe.estimate import FEWEST, Interval, cycle_means, detrended, mean, slope

#: Independent samples that a mean needs for its interval to hold; with fewer it is `short`.
INDEPENDENT = 15.0

#: With fewer independent samples a slow fluctuation looks like a trend and a trend like a
#: fluctuation: the regime is open then, unless an acceleration is evident. It changes the velocity
#: by this share of its mean within the window, or exceeds its half width by this factor.
TOO_FEW, GAIN, EVIDENT = 8.0, 0.5, 5.0

#: A spread below this share of the velocity that counts as rest is that of rounding.
STILL = 1e-3


@dataclass(frozen=True)
class Scales:
    """What counts as small, from the parameters of a point.

    ``arrested`` (m/s): a velocity below it is no flow. A trend is none when it is below
    ``acceleration`` (m/s²) and changes the velocity by less than the fraction ``drift`` of its mean
    over the whole window; ``target`` is the precision wanted of the mean, relative to it.
    """

    arrested: float
    acceleration: float
    drift: float
    target: float


@dataclass(frozen=True)
class Trend:
    """Mean and slope of the velocity (m/s, m/s²), the regime, and what the mean is worth.

    ``quality``: `reliable`; `short`: too few independent samples for an interval that holds, or to
    rule out a drift; `drifting`: the velocity changes, so its mean is that of the window alone;
    `jammed`: the velocity is constant, so there is no scatter to tell an error from; `failed`.
    ``independent`` is the number of independent samples about the trend.
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
    independent = _independent(cycles, scales)
    # What goes to the left gains speed where its velocity falls.
    gain = -trend.value if average.value < 0.0 else trend.value
    window = interval * period * len(cycles)
    change = gain * window / abs(average.value or np.inf)
    negligible = min(scales.acceleration, scales.drift * abs(average.value) / window)
    regime = _regime(cycles, gain, trend.half_width, negligible, scales.arrested)
    evident = regime == "accelerating" and (change > GAIN or gain > EVIDENT * trend.half_width)
    if regime != "arrested" and 0.0 < independent < TOO_FEW and not evident:
        regime = "undetermined"
    significant = abs(gain) > trend.half_width
    if independent == 0.0:
        quality = "jammed"
    elif (
        regime != "arrested" and significant and (abs(change) > scales.target or regime != "steady")
    ):
        quality = "drifting"
    else:
        few = regime == "undetermined" or independent < INDEPENDENT
        quality = "short" if few else "reliable"
    return Trend(average, trend, regime, quality, independent)


def _independent(cycles: np.ndarray, scales: Scales) -> float:
    """Return the number of independent samples of a series about its trend, 0 for a constant."""
    if cycles.std() <= STILL * scales.arrested and np.abs(cycles).max() < scales.arrested:
        return 0.0
    if np.ptp(cycles) == 0.0:
        return 0.0
    about = detrended(cycles)
    error = mean(about).error
    return float((about.std(ddof=1) / error) ** 2) if error > 0.0 else float(len(cycles))


def _regime(
    cycles: np.ndarray, gain: float, half_width: float, negligible: float, arrested: float
) -> str:
    """Name the regime of a series of means over periods whose speed has a slope ``gain``."""
    if np.abs(cycles[len(cycles) // 2 :]).max() < arrested:
        return "arrested"
    if gain - half_width > negligible:
        return "accelerating"
    if abs(gain) + half_width < negligible:
        return "steady"
    return "undetermined"
