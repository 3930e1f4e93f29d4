"""What the replicates of one point say together: mean velocity, its interval, its regime."""

import numpy as np
import xarray as xr
from scipy.special import stdtrit

CONFIDENCE = 0.95

#: Block means behind the standard error of a run (fewer only in very short runs).
BLOCKS = 12

OUTCOME = ("velocity", "half_width", "interval", "completed", "regime", "reason")


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
        (replicates), ``regime`` (``mixed`` where replicates differ, ``failed`` where none
        completed) and ``reason`` (of failures).
    """
    completed = point.isel(replicate=np.flatnonzero(point["status"].values == "completed"))
    velocities = completed["velocity"].values
    half_width, interval = velocity_interval(velocities, completed["velocity_error"].values)
    regimes = list(dict.fromkeys(completed["regime"].values))
    reasons = dict.fromkeys(reason for reason in point["reason"].values if reason)
    return {
        "velocity": velocities.mean() if velocities.size else np.nan,
        "half_width": half_width,
        "interval": interval,
        "completed": velocities.size,
        "regime": "failed" if not regimes else regimes[0] if len(regimes) == 1 else "mixed",
        "reason": "; ".join(reasons),
    }


def velocity_interval(velocities: np.ndarray, errors: np.ndarray) -> tuple[float, str]:
    """Return the half width of the 95 % interval of a mean over replicates, and its kind.

    Two replicates or more give Student's interval over them. A single one gives Student's interval
    from the block means within its run, which does not know how much one initial state differs
    from another.

    >>> velocity_interval(np.array([1.0]), np.array([0.1]))[1]
    'within run'
    """
    if velocities.size >= 2:
        return student_half_width(velocities), "replicates"
    if velocities.size == 1 and np.isfinite(errors[0]):
        return float(stdtrit(BLOCKS - 1, (1 + CONFIDENCE) / 2) * errors[0]), "within run"
    return np.nan, "none"


def student_half_width(values: np.ndarray) -> float:
    """Return the half width of Student's 95 % interval of the mean of two or more values."""
    quantile = stdtrit(values.size - 1, (1 + CONFIDENCE) / 2)
    return float(quantile * values.std(ddof=1) / np.sqrt(values.size))
