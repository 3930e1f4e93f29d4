"""Statistics pooled over the replicates of a point: mean velocity, trend, regime, quality.

Pooling averages out the noise in the slopes of single replicates.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from sim.base.statistics import MANY, mean_interval, student, student_half_width
from sim.dataset.run_file import NamedValues
from sim.parameters.chute import negligible_acceleration
from sim.parameters.common import drift_bound
from sim.study.surrogate import SLOWING

#: Qualities of a mean, from the best.
QUALITIES = ("reliable", "jammed", "short", "drifting", "failed")

#: The scalars of a run that these statistics use.
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

#: The parameters that set the negligible trend.
PARAMETERS = ("target", "gravity", "angle")

#: Names of the statistics, see `outcome`.
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

#: Independent samples of all replicates that a mean needs for its interval to hold.
#: With fewer than `FEW_SAMPLES` a trend cannot be told from a fluctuation, unless the flow gains
#: more than `EVIDENT_GAIN` of its velocity within the window, or the slope exceeds `EVIDENT_RATIO`
#: half widths. `sim.engine.observe.regime` has the same limits for a single run.
ENOUGH_SAMPLES, FEW_SAMPLES, EVIDENT_GAIN, EVIDENT_RATIO = 15.0, 8.0, 0.5, 5.0


def outcomes(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return mean velocity, trend, regime and quality of each point of a dataset, see `outcome`."""
    names = (name for name in (*SCALARS, *PARAMETERS) if name in dataset.variables)
    columns = {name: dataset.variables[name].values for name in names}
    return [
        outcome({name: values[row] for name, values in columns.items()})
        for row in range(dataset.sizes["point"])
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
        ``acceleration_half_width`` (m/s², mean of the signed slopes of replicates), ``completed``
        (number of replicates), ``regime`` (``mixed`` where replicates contradict each other,
        ``failed`` where none completed), ``quality`` of the mean, ``stopped`` (why they stopped)
        and ``reason`` (of failures).
    """
    scalars = {name: np.asarray(point[name]) for name in SCALARS}
    is_completed = scalars["status"] == "completed"
    completed = {name: values[is_completed] for name, values in scalars.items()}
    velocities = completed["velocity"]
    half_width, interval = mean_interval(velocities, completed["velocity_half_width"])
    has_slope = np.isfinite(completed["acceleration_half_width"])
    names = ("acceleration", "acceleration_half_width")
    slopes, half_widths = (completed[name][has_slope] for name in names)
    slope = slopes.mean() if slopes.size else np.nan
    slope_half_width = pooled_half_width(slopes, half_widths)
    negligible, window = _negligible_slope(point, completed)
    regime = _pooled_regime(completed, slope, slope_half_width, negligible, window)
    reasons = dict.fromkeys(reason for reason in scalars["reason"] if reason)
    return {
        "velocity": velocities.mean() if velocities.size else np.nan,
        "half_width": half_width,
        "interval": interval,
        "acceleration": slope,
        "acceleration_half_width": slope_half_width,
        "completed": velocities.size,
        "regime": regime,
        "quality": _mean_quality(
            completed, regime, slope, slope_half_width, window * float(point["target"])
        ),
        "stopped": ", ".join(dict.fromkeys(completed["stopped"])) or "failure",
        "reason": "; ".join(reasons),
    }


def answering_regime(one: Mapping[str, Any]) -> str:
    """Return the regime of an `outcome` as answers count it: `SLOWING` apart from undetermined.

    The mean of a run that is too short to tell is worth its interval; that of a flow whose velocity
    falls with 95 % certainty depends on when one looks.
    """
    gain = np.sign(one["velocity"]) * one["acceleration"]
    falls = gain + one["acceleration_half_width"] < 0
    return SLOWING if one["regime"] == "undetermined" and falls else str(one["regime"])


def _negligible_slope(point: Mapping[str, Any], completed: NamedValues) -> tuple[float, float]:
    """Return the largest negligible slope (m/s²), and |V| over the mean window (m/s²)."""
    if not completed["velocity"].size:
        return np.nan, np.nan
    end = completed["steps"] * completed["time_step_used"]
    window = np.mean(end - completed["average_start"])
    over_window = abs(float(completed["velocity"].mean())) / window if window > 0 else np.inf
    negligible = drift_bound(float(point["target"])) * over_window
    # On a level plane no flow accelerates for ever.
    if (angle := float(point.get("angle", 0))) > 0:
        slope = negligible_acceleration(float(point["gravity"]), angle)
        negligible = min(negligible, slope)
    return negligible, over_window


def _pooled_regime(
    completed: NamedValues, slope: float, half_width: float, negligible: float, over_window: float
) -> str:
    """Return the regime of a point from the mean ``slope`` of its replicates (all in m/s²).

    Replicates contradict each other if some came to rest and others did not. They also do if some
    surely accelerate and others surely do not, by intervals corrected for their number (multiple
    tests). A flow to the left accelerates if its velocity falls.
    """
    rests = completed["regime"] == "arrested"
    if not rests.size:
        return "failed"
    if rests.any():
        return "arrested" if rests.all() else "mixed"
    sign = -1.0 if completed["velocity"].mean() < 0.0 else 1.0
    gain, gains = sign * slope, sign * completed["acceleration"]
    wider = student(MANY, rests.size) / student(MANY)
    margins = wider * completed["acceleration_half_width"]
    if (gains - margins > negligible).any() and (gains + margins < negligible).any():
        return "mixed"
    accelerates = gain - half_width > negligible
    is_evident = accelerates and (
        gain > EVIDENT_GAIN * over_window or gain > EVIDENT_RATIO * half_width
    )
    has_few_samples = np.nansum(completed["independent_samples"]) < FEW_SAMPLES
    if has_few_samples and not is_evident:
        return "undetermined"
    if accelerates:
        return "accelerating"
    return "steady" if abs(slope) + half_width < negligible else "undetermined"


def _mean_quality(
    completed: NamedValues, regime: str, slope: float, half_width: float, target: float
) -> str:
    """Return the quality of the mean; ``target`` is the slope (m/s²) that the mean's target allows.

    A jammed mean has a velocity that is constant up to rounding: no scatter gives its error.
    """
    jammed = completed["quality"] == "jammed"
    if not jammed.size:
        return "failed"
    if jammed.all() or (regime == "arrested" and jammed.any()):
        return "jammed"
    gain = abs(slope)
    if regime != "arrested" and gain > half_width and (gain > target or regime != "steady"):
        return "drifting"
    has_few_samples = np.nansum(completed["independent_samples"]) < ENOUGH_SAMPLES
    return "short" if has_few_samples or regime in ("undetermined", "mixed") else "reliable"


#: The slopes of replicates are taken to differ if Cochran's Q has a p below this.
HETEROGENEITY_P = 0.3


def pooled_half_width(slopes: np.ndarray, half_widths: np.ndarray) -> float:
    """Return the half width of the 95 % interval of the mean slope of replicates.

    The slopes of stationary flows scatter by the error that each run finds for itself. The interval
    then follows from these errors and falls as one over the root of their number. Replicates in
    different states differ by more; then the interval is Student's. The replicates are taken to
    differ if Cochran's Q has p < 30 %. The interval of three replicates that scatter by their own
    errors then holds in 93 % of cases; with 5 % it would hold in 87 %.
    """
    if not slopes.size:
        return np.nan
    combined = float(np.sqrt((half_widths**2).sum())) / slopes.size
    errors = half_widths / student(MANY)
    if slopes.size < 2 or not (errors > 0).all():
        return combined
    weights = errors**-2
    cochran_q = (weights * (slopes - np.average(slopes, weights=weights)) ** 2).sum()
    # Imported here to save time, as in `sim.base.statistics`.
    from scipy.special import chdtrc

    is_homogeneous = chdtrc(slopes.size - 1, cochran_q) > HETEROGENEITY_P
    return combined if is_homogeneous else max(combined, float(student_half_width(slopes)))
