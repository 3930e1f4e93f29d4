"""Run-length control: when a run of the converged protocol has shown enough."""

import numpy as np

from sim.engine.observe.estimate import cycle_means, slope, transient_end
from sim.engine.observe.regime import Scales, Trend, analyse

#: A run is looked at when it is this many times as long as the last time, and ends when two looks
#: in a row give the same reason. Looks are few, since each is a chance to stop by accident.
GROWTH = 1.35

#: An acceleration that has not fallen below this share of what it was in the first half of the
#: window is not the last part of a transient.
LASTING = 0.85

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


def window_start(velocity: np.ndarray, period: int, least: int = 0) -> int:
    """Return how many samples of a velocity series to leave out as its transient.

    At least ``least``, which the user knows or the paper says; whole periods remain.
    """
    cycles = cycle_means(velocity, period)
    kept = (len(cycles) - transient_end(cycles)) * period
    start = max(least, len(velocity) - kept, 0)
    return start + (len(velocity) - start) % period if len(velocity) - start >= period else start


def verdict(
    velocity: np.ndarray, interval: float, scales: Scales, period: int, least: int
) -> tuple[int, Trend, str]:
    """Return where the window of a run starts (samples), its trend and why to stop, or ``""``.

    Parameters
    ----------
    velocity : (T,) array
        Mean velocity per sample interval since the start (m/s).
    interval, scales, period
        As for `sim.engine.observe.regime.analyse`.
    least : int
        Samples that are transient in any case.
    """
    start = window_start(velocity, period, least)
    window = velocity[start:]
    trend = analyse(window, interval, scales, period)
    reason = ""
    if trend.regime == "arrested":
        reason = ARRESTED
    elif trend.regime == "accelerating" and _lasts(window, interval, period):
        reason = ACCELERATING
    elif trend.regime == "steady" and trend.quality == "reliable":
        enough = trend.velocity.half_width <= scales.target * abs(trend.velocity.value)
        reason = TARGET if enough else ""
    return start, trend, reason


def _lasts(window: np.ndarray, interval: float, period: int) -> bool:
    """Return whether the second half of a window accelerates as much as the first."""
    cycles = cycle_means(window, period)
    early, late = np.array_split(cycles, 2)
    before, after = (slope(part, interval * period) for part in (early, late))
    uncertain = np.hypot(after.half_width, LASTING * before.half_width)
    lasting = after.value - LASTING * before.value > uncertain
    return bool(lasting and before.value > before.half_width)
