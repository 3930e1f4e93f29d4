"""Run-length control: decides when a run of the converged protocol may end."""

import numpy as np

from sim.engine.observe.estimate import cycle_means, slope, transient_end
from sim.engine.observe.regime import Scales, Trend, analyse

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
