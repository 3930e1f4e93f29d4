"""What the replicates of one point say together: mean velocity, trend, regime, quality.

All of it comes from the replicates pooled: what is noise in the slope of one averages out over
many.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from sim.base.named import Named
from sim.base.statistics import MANY, mean_interval, student, student_half_width
from sim.parameters.chute import negligible_acceleration
from sim.parameters.common import drift_beyond

#: What a mean is worth, from the best.
QUALITIES = ("reliable", "jammed", "short", "drifting", "failed")

#: The scalars of a run that it is taken from.
SCALARS = (
    "status",
    "velocity",
    "velocity_half_width",
    "acceleration",
    "acceleration_half_width",
    "independent_samples",
    "average_start",
    "steps",
    "time_step_used",
    "regime",
    "quality",
    "stopped",
    "reason",
)

#: The parameters that say which trend is none.
PARAMETERS = ("target", "gravity", "angle")

OUTCOME = (
    "velocity",
    "half_width",
    "interval",
    "acceleration",
    "acceleration_half_width",
    "completed",
    "regime",
    "quality",
    "stopped",
    "reason",
)

#: Independent samples, of all replicates together, that a mean needs for its interval to hold, and
#: without which a trend cannot be told from a fluctuation, unless the flow gains this share of its
#: velocity within the window or the slope exceeds its half width by this factor
#: (`sim.engine.observe.regime` asks the same of a single run).
INDEPENDENT, TOO_FEW, GAIN, EVIDENT = 15.0, 8.0, 0.5, 5.0


def outcomes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return mean velocity, trend, regime and quality of each point of a dataset, see `outcome`."""
    known = (name for name in (*SCALARS, *PARAMETERS) if name in dataset.variables)
    held = {name: dataset.variables[name].values for name in known}
    return [
        outcome({name: values[number] for name, values in held.items()})
        for number in range(dataset.sizes["point"])
    ]


def outcome(point: Mapping[str, Any]) -> dict[str, Any]:
    """Return mean velocity, trend, regime and quality of a point over its replicates.

    Parameters
    ----------
    point : mapping
        `SCALARS` of the point, each over its replicates, and its `PARAMETERS`.

    Returns
    -------
    dict
        ``velocity`` (m/s, mean over completed replicates), ``half_width`` (m/s, of its 95 %
        interval), ``interval`` (``replicates``, ``within run`` or ``none``), ``acceleration`` and
        ``acceleration_half_width`` (m/s², mean of their signed slopes), ``completed``
        (replicates), ``regime`` (``mixed`` where replicates contradict each other, ``failed``
        where none completed), ``quality`` of the mean, why they ``stopped`` and ``reason`` (of
        failures).
    """
    scalars = {name: np.asarray(point[name]) for name in SCALARS}
    done = scalars["status"] == "completed"
    completed = {name: values[done] for name, values in scalars.items()}
    velocities = completed["velocity"]
    half_width, interval = mean_interval(velocities, completed["velocity_half_width"])
    known = np.isfinite(completed["acceleration_half_width"])
    slopes, own = (completed[name][known] for name in ("acceleration", "acceleration_half_width"))
    slope = slopes.mean() if slopes.size else np.nan
    gained = slope_interval(slopes, own)
    negligible, window = _negligible(point, completed)
    regime = _regime(completed, slope, gained, negligible, window)
    reasons = dict.fromkeys(reason for reason in scalars["reason"] if reason)
    return {
        "velocity": velocities.mean() if velocities.size else np.nan,
        "half_width": half_width,
        "interval": interval,
        "acceleration": slope,
        "acceleration_half_width": gained,
        "completed": velocities.size,
        "regime": regime,
        "quality": _quality(completed, regime, slope, gained, window * float(point["target"])),
        "stopped": ", ".join(dict.fromkeys(completed["stopped"])) or "failure",
        "reason": "; ".join(reasons),
    }


def _negligible(point: Mapping[str, Any], completed: Named) -> tuple[float, float]:
    """Return the slope (m/s²) that is none, and |V| over the mean window (m/s²)."""
    if not completed["velocity"].size:
        return np.nan, np.nan
    end = completed["steps"] * completed["time_step_used"]
    window = np.mean(end - completed["average_start"])
    over_window = abs(float(completed["velocity"].mean())) / window if window > 0 else np.inf
    negligible = drift_beyond(float(point["target"])) * over_window
    # On a level plane nothing accelerates for ever.
    if (angle := float(point.get("angle", 0))) > 0:
        slope = negligible_acceleration(float(point["gravity"]), angle)
        negligible = min(negligible, slope)
    return negligible, over_window


def _regime(
    completed: Named, slope: float, half_width: float, negligible: float, over_window: float
) -> str:
    """Return the regime of a point from the mean ``slope`` of its replicates (all in m/s²).

    Those that came to rest and those that did not contradict each other, and so do replicates that
    surely accelerate and others that surely do not, each as one of so many. What goes to the left
    accelerates where its velocity falls.
    """
    rests = completed["regime"] == "arrested"
    if not rests.size:
        return "failed"
    if rests.any():
        return "arrested" if rests.all() else "mixed"
    sign = -1.0 if completed["velocity"].mean() < 0.0 else 1.0
    gain, gains = sign * slope, sign * completed["acceleration"]
    wider = student(MANY, rests.size) / student(MANY)
    own = wider * completed["acceleration_half_width"]
    if (gains - own > negligible).any() and (gains + own < negligible).any():
        return "mixed"
    accelerates = gain - half_width > negligible
    evident = accelerates and (gain > GAIN * over_window or gain > EVIDENT * half_width)
    few = np.nansum(completed["independent_samples"]) < TOO_FEW
    if few and not evident:
        return "undetermined"
    if accelerates:
        return "accelerating"
    return "steady" if abs(slope) + half_width < negligible else "undetermined"


def _quality(completed: Named, regime: str, slope: float, half_width: float, target: float) -> str:
    """Return the quality of the mean; ``target`` is the slope (m/s²) that the mean's target allows.

    A velocity that is constant but for rounding has no scatter to tell an error.
    """
    jammed = completed["quality"] == "jammed"
    if not jammed.size:
        return "failed"
    if jammed.all() or (regime == "arrested" and jammed.any()):
        return "jammed"
    gain = abs(slope)
    if regime != "arrested" and gain > half_width and (gain > target or regime != "steady"):
        return "drifting"
    few = np.nansum(completed["independent_samples"]) < INDEPENDENT
    return "short" if few or regime in ("undetermined", "mixed") else "reliable"


#: p of Cochran's Q below which slopes of replicates are taken to differ.
DIFFERENT = 0.3


def slope_interval(slopes: np.ndarray, half_widths: np.ndarray) -> float:
    """Return the half width of the 95 % interval of the mean slope of replicates.

    Slopes of stationary flows scatter by what each run knows of itself, so the interval is that of
    the mean of their own and falls as one over the root of their number. Where replicates differ by
    more than that, because they are in different states, it is Student's. They are taken to differ
    where Cochran's Q says so at 30 %: the interval of three replicates that differ by as much as
    each knows of itself then holds in 93 %; at 5 % it would in 87.
    """
    if not slopes.size:
        return np.nan
    own = float(np.sqrt((half_widths**2).sum())) / slopes.size
    errors = half_widths / student(MANY)
    if slopes.size < 2 or not (errors > 0).all():
        return own
    weights = errors**-2
    apart = (weights * (slopes - np.average(slopes, weights=weights)) ** 2).sum()
    # As in `sim.base.statistics`, the import is put off.
    from scipy.special import chdtrc

    alike = chdtrc(slopes.size - 1, apart) > DIFFERENT
    return own if alike else max(own, float(student_half_width(slopes)))
