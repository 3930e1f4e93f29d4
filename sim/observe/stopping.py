"""Run-length control: when a run of the converged protocol has shown enough."""

import numpy as np

from sim.observe.estimate import cycle_means, slope, transient_end
from sim.observe.regime import Scales, Trend, analyse

#: A run is looked at when it is this many times as long as the last time. Looks are few, since each
#: is a chance to stop on an interval that is small by accident.
GROWTH = 1.5

#: An acceleration that has not fallen below this share of what it was in the first half of the
#: window is not the last part of a transient.
LASTING = 0.8

#: Reasons to stop. The last is that of the published protocol.
TARGET, ARRESTED, ACCELERATING, LIMIT, LENGTH = (
    "target",
    "arrested",
    "accelerating",
    "limit",
    "length",
)


def looks(shortest: int, longest: int) -> list[int]:
    """Return the lengths (samples) at which a run is looked at; the last one is the longest."""
    lengths, length = [], float(shortest)
    while length < longest:
        lengths.append(int(length))
        length *= GROWTH
    return [*lengths, longest]


def window_start(velocity: np.ndarray, period: int) -> int:
    """Return how many samples of a velocity series to leave out as its transient."""
    cycles = cycle_means(velocity, period)
    return len(velocity) - (len(cycles) - transient_end(cycles)) * period


def verdict(
    velocity: np.ndarray, interval: float, scales: Scales, period: int, target: float
) -> tuple[int, Trend, str]:
    """Return where the window of a run starts (samples), its trend and why to stop, or ``""``.

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval since the start (m/s).
    interval, scales, period
        As for `sim.observe.regime.analyse`.
    target : float
        Half width of the 95 % interval of the mean velocity, relative to the mean, that is enough.
    """
    start = window_start(velocity, period)
    window = velocity[start:]
    trend = analyse(window, interval, scales, period)
    reason = ""
    if trend.regime == "arrested":
        reason = ARRESTED
    elif trend.regime == "accelerating" and _lasts(window, interval, period):
        reason = ACCELERATING
    elif trend.regime == "steady" and trend.quality == "reliable":
        reason = TARGET if trend.velocity.half_width <= target * abs(trend.velocity.value) else ""
    return start, trend, reason


def _lasts(window: np.ndarray, interval: float, period: int) -> bool:
    """Return whether the second half of a window accelerates as much as the first."""
    cycles = cycle_means(window, period)
    early, late = np.array_split(cycles, 2)
    before, after = (slope(part, interval * period) for part in (early, late))
    return after.value - after.half_width > LASTING * before.value
