"""Statistics pooled over the replicates of a point: mean velocity, trend, regime, quality.

Pooling averages out the noise in the slopes of single replicates.
"""

from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sim.base.statistics import MANY, mean_interval, student, student_half_width
from sim.dataset.grids import mean_over
from sim.dataset.results import Results
from sim.engine.stored_run import NamedValues, Replicate, RunFile, open_run_file
from sim.measures.layers import missing_energy
from sim.parameters import Parameters
from sim.parameters.chute import negligible_acceleration
from sim.parameters.common import drift_bound
from sim.parameters.images import WIDE_CELL
from sim.parameters.laws import FUNCTION_NAME as FUNCTION
from sim.parameters.variables import OF_FAILURES, observables
from sim.study.plottable import Observable
from sim.study.surrogate import SLOWING

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

#: The parameters that set the negligible trend, and whether there is one.
PARAMETERS = ("system", "target", "gravity", "angle")

#: The statistics of `outcome`, as they are of calls of a function: no velocity, and no end.
OUTCOME: dict[str, Any] = {
    **{"velocity": nan, "half_width": nan, "interval": "none"},
    **{"acceleration": nan, "acceleration_half_width": nan, "completed": 0},
    **{"regime": "steady", "quality": "reliable", "stopped": "length", "reason": ""},
}

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

    ``point`` has its `SCALARS`, each over its replicates, and its `PARAMETERS`. The answer has
    ``velocity`` (m/s, mean over completed replicates), ``half_width`` (m/s, of its 95 % interval),
    ``interval`` (``replicates``, ``within run`` or ``none``), ``acceleration`` and
    ``acceleration_half_width`` (m/s², mean of the signed slopes of replicates), ``completed``
    (number of replicates), ``regime`` (``mixed`` where replicates contradict each other, ``failed``
    where none completed), ``quality`` of the mean, ``stopped`` (why they stopped) and ``reason``
    (of failures).
    """
    is_completed = np.asarray(point["status"]) == "completed"
    if str(point.get("system")) == FUNCTION:
        return OUTCOME | {"completed": int(is_completed.sum())}
    scalars = {name: np.asarray(point[name]) for name in SCALARS}
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


#: The run is unsound if its ledger lacks more than this share of the energy turned over.
UNSOUND_SHARE = 0.01

#: Largest share of the energy that a closed ledger may lack.
CLOSED_SHARE = 0.005

_LEAK_TEXT = (
    f"energy does not add up within {100 * UNSOUND_SHARE:g} % of what is turned over, so the run "
    "is numerically unsound or its model makes energy"
)

#: A run is longer than its point asks for if its length exceeds that by more than this factor.
_LENGTH_TOLERANCE = 1.001

_LENGTH_TEXT = (
    "runs longer than is asked for, as they were made when more was; their numbers are of all of "
    "them"
)

_SAME_TEXT = (
    "replicates are the same to the bit, as nothing that differs between them matters: they count "
    "as one, and tell nothing of scatter"
)

#: With bumps a flow counts as layered from this order on. In cells of 5 σ it is 0.75 to 0.79 where
#: layers glide on each other, in cells of 8 σ 0.16 to 0.28 (depth 12, 24°, bumps of 1 σ).
LAYERED = 0.5

_LAYERS_TEXT = (
    f"on bumps in a cell narrower than {WIDE_CELL} σ the flow has ordered in layers (layer_order "
    f"above {LAYERED:g}), which may glide on each other and be several times as fast as a flow in "
    "a wider cell"
)

#: The scalars that make up the energy ledger of a replicate.
LEDGER_SCALARS = ("energy_residual", "frictional_power", "normal_power", "velocity", "acceleration")


def caveats(own_caveat: str, scalars: Mapping[str, Any], parameters: Parameters) -> str:
    """Return all caveats of the run of a point as one text, empty for a sound run.

    The run file has its own; ``scalars`` are, by name and over the replicates, what is known of
    ``status``, ``steps``, ``time_step_used``, ``max_overlap`` and ``layer_order``, and
    ``missing_energy`` or `LEDGER_SCALARS`.
    """
    if not parameters.is_flow:
        return own_caveat
    missing = scalars.get("missing_energy")
    missing = _missing_shares(scalars, parameters) if missing is None else missing
    overlaps = np.asarray(scalars.get("max_overlap", ()), float)
    if overlaps.size:
        # A replicate that blew up is not a flow.
        overlaps = overlaps[np.asarray(scalars["status"]) == "completed"]
    are_same = overlaps.size > 1 and overlaps[0] > 0 and (overlaps == overlaps[0]).all()
    lengths = np.multiply(scalars.get("steps", ()), scalars.get("time_step_used", ()))
    is_longer = (lengths > _LENGTH_TOLERANCE * parameters.steps * parameters.time_step).any()
    has_layers = is_narrow(parameters) and np.any(
        np.greater(scalars.get("layer_order", ()), LAYERED)
    )
    texts = (
        own_caveat,
        _LEAK_TEXT if np.any(np.greater(missing, UNSOUND_SHARE)) else "",
        *(parameters.caveat_of(float(overlap)) for overlap in overlaps),
        _LENGTH_TEXT if is_longer else "",
        _SAME_TEXT if are_same else "",
        _LAYERS_TEXT if has_layers else "",
    )
    return "; ".join(filter(None, dict.fromkeys(texts)))


def is_narrow(parameters: Any) -> bool:
    """Return whether a flow on bumps has a cell so narrow that it may order in layers."""
    if not getattr(parameters, "bumps", 0):
        return False
    return min(parameters.cell, parameters.cell_across or parameters.cell) < WIDE_CELL


def layer_orders(path: Path, parameters: Parameters) -> list[float]:
    """Return the order of layers of the completed replicates of a run file where it may count."""
    if not (is_narrow(parameters) and parameters.system == "chute"):
        return []
    with open_run_file(path) as file:
        run = RunFile(file)
        completed = (run["status"] == "completed").nonzero()[0]
        if "layer_order" in run:
            # A reduced run file has the observables.
            return run["layer_order"][completed].tolist()
        measured = observables(parameters.system)["layer_order"].measure
        orders: Any = [measured(Replicate(run, int(k))) for k in completed]
        return [one.get("layer_order", nan) for one in orders]


def _missing_shares(scalars: Mapping[str, Any], parameters: Parameters) -> list[float]:
    """Return the missing share of the energy of each replicate, none where that is not known."""
    if "energy_residual" not in scalars:
        return []
    columns = {name: scalars[name] for name in LEDGER_SCALARS if name in scalars}
    shared = {"particles": parameters.particles, "mass": parameters.mass}
    return [
        missing_energy(shared | dict(zip(columns, values, strict=True)))
        for values in zip(*columns.values(), strict=True)
    ]


def replicate_values(
    results: Results, observable: Observable, points: Sequence[str]
) -> list[np.ndarray]:
    """Return one array per point: an observable of its replicates, in SI units.

    The mean of a profile is weighted by packing.

    Replicates that failed, or have no finite value, are left out: values of two observables are not
    of the same replicates.
    """
    if observable.is_mean:
        names = observable.source, "packing_profile"
        profiles = ([results.profile(point, name)[0] for name in names] for point in points)
        values = [mean_over(one, packing, lambda x: x.sum(axis=1)) for one, packing in profiles]
    elif observable.source in results.dataset:
        rows = results.dataset[[observable.source, "status"]].sel(point=list(points))
        is_shown = observable.source in OF_FAILURES or rows["status"] == "completed"
        values = list(rows[observable.source].where(is_shown).values)
    else:
        values = [np.zeros(0)] * len(points)
    return [row[np.isfinite(row)] for row in values]
