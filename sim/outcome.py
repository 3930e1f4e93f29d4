"""What the replicates of one point say together: mean velocity, its interval, its regime."""

import numpy as np
import xarray as xr
from scipy.special import stdtrit

CONFIDENCE = 0.95

OUTCOME = ("velocity", "half_width", "interval", "completed", "regime", "quality", "reason")


def outcome(point: xr.Dataset) -> dict[str, object]:
    """Return what the replicates of one point say together.

    Parameters
    ----------
    point : xarray.Dataset
        One point of a study's dataset, over ``replicate`` alone.

    Returns
    -------
    dict
        ``velocity`` (m/s, mean over completed replicates), ``half_width`` (m/s, of its 95 %
        interval), ``interval`` (``replicates``, ``within run`` or ``none``), ``completed``
        (replicates), ``regime`` and ``quality`` of the means (``mixed`` where replicates differ,
        ``failed`` where none completed) and ``reason`` (of failures).
    """
    completed = point.isel(replicate=np.flatnonzero(point["status"].values == "completed"))
    velocities = completed["velocity"].values
    half_width, interval = velocity_interval(velocities, completed["velocity_half_width"].values)
    reasons = dict.fromkeys(reason for reason in point["reason"].values if reason)
    return {
        "velocity": velocities.mean() if velocities.size else np.nan,
        "half_width": half_width,
        "interval": interval,
        "completed": velocities.size,
        "regime": _shared(completed["regime"].values),
        "quality": _shared(completed["quality"].values),
        "reason": "; ".join(reasons),
    }


def _shared(words: np.ndarray) -> str:
    """Return what all completed replicates say of themselves."""
    distinct = set(words)
    return "mixed" if len(distinct) > 1 else distinct.pop() if distinct else "failed"


def velocity_interval(velocities: np.ndarray, half_widths: np.ndarray) -> tuple[float, str]:
    """Return the half width of the 95 % interval of a mean over replicates, and its kind.

    Two replicates or more give Student's interval over them, which knows how much one initial state
    differs from another; where few agree by accident, what each knows of itself still counts:
    the interval is not smaller than that of the mean of their own. A single one has only its own.

    >>> velocity_interval(np.array([1.0]), np.array([0.1]))[1]
    'within run'
    """
    own = float(np.sqrt((half_widths**2).sum())) / max(1, velocities.size)
    if velocities.size >= 2:
        return float(np.nanmax([student_half_width(velocities), own])), "replicates"
    if velocities.size == 1 and np.isfinite(own):
        return own, "within run"
    return np.nan, "none"


def student_half_width(values: np.ndarray) -> float:
    """Return the half width of Student's 95 % interval of the mean of two or more values."""
    quantile = stdtrit(values.size - 1, (1 + CONFIDENCE) / 2)
    return float(quantile * values.std(ddof=1) / np.sqrt(values.size))
