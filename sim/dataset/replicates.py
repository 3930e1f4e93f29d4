"""What the replicates of one point say together: mean velocity, its interval, its regime."""

from typing import Any

import numpy as np
import xarray as xr

from sim.base.named import Named
from sim.base.statistics import student_half_width

#: What a mean is worth, from the best; of several replicates the worst counts.
QUALITIES = ("reliable", "jammed", "short", "drifting", "failed")

#: The scalars of a run that it is taken from.
SCALARS = ("status", "velocity", "velocity_half_width", "regime", "quality", "stopped", "reason")

OUTCOME = (
    "velocity",
    "half_width",
    "interval",
    "completed",
    "regime",
    "quality",
    "stopped",
    "reason",
)


def outcomes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return what the replicates of each point of a dataset say together, see `outcome`."""
    held = {name: dataset.variables[name].values for name in SCALARS}
    return [
        outcome({name: values[number] for name, values in held.items()})
        for number in range(dataset.sizes["point"])
    ]


def outcome(point: Named) -> dict[str, Any]:
    """Return what the replicates of one point say together.

    Parameters
    ----------
    point : mapping
        `SCALARS` of the point, each over its replicates.

    Returns
    -------
    dict
        ``velocity`` (m/s, mean over completed replicates), ``half_width`` (m/s, of its 95 %
        interval), ``interval`` (``replicates``, ``within run`` or ``none``), ``completed``
        (replicates), ``regime`` (``mixed`` where replicates contradict each other, ``failed``
        where none completed), the worst ``quality`` of their means, why they ``stopped`` and
        ``reason`` (of failures).
    """
    scalars = {name: np.asarray(point[name]) for name in SCALARS}
    done = scalars["status"] == "completed"
    completed = {name: values[done] for name, values in scalars.items()}
    velocities = completed["velocity"]
    half_width, interval = velocity_interval(velocities, completed["velocity_half_width"])
    reasons = dict.fromkeys(reason for reason in scalars["reason"] if reason)
    return {
        "velocity": velocities.mean() if velocities.size else np.nan,
        "half_width": half_width,
        "interval": interval,
        "completed": velocities.size,
        "regime": _regime(completed["regime"]),
        "quality": max(completed["quality"], key=QUALITIES.index, default="failed"),
        "stopped": ", ".join(dict.fromkeys(completed["stopped"])) or "failure",
        "reason": "; ".join(reasons),
    }


def _regime(regimes: np.ndarray) -> str:
    """Return the regime of a point: that of half of its replicates where no other contradicts.

    An undetermined replicate contradicts nothing.
    """
    if not len(regimes):
        return "failed"
    decided = regimes[regimes != "undetermined"]
    if len(set(decided)) > 1:
        return "mixed"
    return decided[0] if 2 * len(decided) >= len(regimes) else "undetermined"


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
        known = filter(np.isfinite, (float(student_half_width(velocities)), own))
        return max(known, default=np.nan), "replicates"
    if velocities.size == 1 and np.isfinite(own):
        return own, "within run"
    return np.nan, "none"
