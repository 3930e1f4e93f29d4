"""What a surrogate learns from: mean, error and regime of each point, and where it lies.

Points lie in the unit cube of the ranges of their parameters, or in groups of these (`Frame`).
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from sim.base.additions import plugin_options
from sim.base.errors import InputError
from sim.dataset.replicates import SCALARS, answering_regime, outcomes, replicate_values
from sim.dataset.results import Results
from sim.parameters import NUMERICAL, SYSTEMS
from sim.parameters.laws import FUNCTION_NAME
from sim.parameters.observables import Form
from sim.study.design import Axis
from sim.study.plottable import numbers
from sim.study.surrogate import SurrogateFile
from sim.surrogates.answers import Refusal

#: Deviation, before any run, of how much the logarithm of a variance changes over a range.
_SLOPE = 3.0

#: Fewest degrees of freedom, over all points, from which the scatter between replicates is known.
_ENOUGH_FREEDOM = 3

#: Most places of which a surrogate is asked at a time.
_MOST_PLACES = 10_000_000

#: Largest and smallest size of values whose squares, and those of their errors, are numbers.
_SIZES = (1e-100, 1e100)


def sample_points(results: Results, spec: SurrogateFile) -> xr.Dataset:
    """Return what the runs of a surrogate's series say, over ``point``.

    Variables are one for each axis; ``mean`` of the observable (SI; NaN without a value),
    ``standard_error`` of the mean, ``replicates`` that completed, ``regime``, ``lost`` ones,
    ``caveat`` of the runs, and ``core_hours``. Attribute ``scatter`` is 1 where the scatter between
    initial states is not known, as too few points have two replicates. The standard errors then
    leave it out. Attribute ``fixed`` maps the parameters that are the same at all points to their
    values. Raises `InputError` when the series has no point in the results, and `Refusal` when
    values are too large or too small to be squared.
    """
    dataset = results.dataset
    is_member = [spec.series in str(names).split() for names in dataset["series"].values]
    rows = dataset.isel(point=np.flatnonzero(is_member & (dataset["system"].values == spec.system)))
    points = [str(point) for point in rows["point"].values]
    if not points:
        raise InputError(f"{spec.name}: no point of the series {spec.series} in the results")
    summaries = outcomes(rows[[name for name in SCALARS if name in rows]])
    values = replicate_values(results, numbers(spec.system)[spec.observable], points)
    largest = max((float(np.abs(row).max()) for row in values if row.size), default=0.0)
    if largest and not _SIZES[0] <= largest <= _SIZES[1]:
        raise Refusal(
            f"no mean, as {spec.observable} is {largest:.3g} at most; "
            f"allowed: between {_SIZES[0]:g} and {_SIZES[1]:g}, in the unit of its declaration"
        )
    own = np.zeros(len(points))
    if spec.observable == "velocity":
        within = rows["velocity_error"].where(rows["status"] == "completed").values
        counts = np.maximum(1, np.isfinite(within).sum(axis=1))
        own = np.sqrt(np.nansum(within**2, axis=1)) / counts
    errors, is_unknown = standard_errors(values, own, unit_cube(spec.axes, rows))
    is_unknown = is_unknown and not is_exact(rows)
    columns = {axis.name: rows[axis.name].values for axis in spec.axes} | {
        "mean": np.array([row.mean() if row.size else np.nan for row in values]),
        "standard_error": errors,
        "replicates": np.array([row.size for row in values]),
        "regime": np.array([answering_regime(one) for one in summaries], dtype=object),
        "caveat": rows["caveat"].values.astype(object),
        "lost": (~np.isin(rows["status"].values.astype(str), ("completed", ""))).sum(axis=1),
        "core_hours": np.nansum(_core_seconds(rows), axis=1) / 3600,
    }
    variables = {name: ("point", column) for name, column in columns.items()}
    attributes = {"scatter": int(is_unknown), "fixed": _fixed(rows, spec)}
    return xr.Dataset(variables, {"point": points}, attributes)


def is_exact(rows: xr.Dataset) -> bool:
    """Return whether all rows are calls of functions that do not depend on chance."""
    exact = {name for name, one in plugin_options(FUNCTION_NAME).items() if not one.is_random}
    return FUNCTION_NAME in rows and exact.issuperset(rows[FUNCTION_NAME].values)


def _core_seconds(rows: xr.Dataset) -> np.ndarray:
    """Return the processor time (s) of each replicate in its loop over time steps, (n, R).

    How busy the machine was does not change it. Where a run does not tell it, the wall time of all
    threads stands for it.
    """
    threads = np.nan_to_num(rows["threads"].values.astype(float), nan=1.0)
    walls = rows["wall_time"].values * threads[:, None]
    loops = rows["loop_time"].values if "loop_time" in rows else np.full_like(walls, np.nan)
    return np.where(np.isfinite(loops), loops, walls)


def _fixed(rows: xr.Dataset, spec: SurrogateFile) -> dict[str, Any]:
    """Return the parameters that flows depend on and that are the same at all points."""
    varied = {axis.name for axis in spec.axes}
    names = [name for name in SYSTEMS[spec.system].model_fields if name not in NUMERICAL | varied]
    values = {name: list(dict.fromkeys(rows[name].values.tolist())) for name in names}
    return {name: every[0] for name, every in values.items() if len(every) == 1}


def points_of_mean(sample: xr.Dataset, regimes: tuple[str, ...]) -> np.ndarray:
    """Return which points have a mean and one of some ``regimes``, (n,)."""
    is_used = np.isin(sample["regime"].values.astype(str), regimes)
    return is_used & np.isfinite(sample["mean"].values)


def omissions(sample: xr.Dataset, regimes: tuple[str, ...]) -> str:
    """Return how many points a mean of some ``regimes`` leaves out, by regime or without value."""
    is_known = (sample["regime"] == "failed") | np.isfinite(sample["mean"])
    names = np.where(is_known, sample["regime"].values.astype(str), "without a value")
    counts = Counter(names[~points_of_mean(sample, regimes)].tolist())
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))


def standard_errors(
    values: Sequence[np.ndarray], own: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, bool]:
    """Return the standard error of each point's mean, and whether it leaves out the scatter.

    Few replicates may agree by accident, so the variance of each point is moderated by that of all
    (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3, 3): the more alike points are, the more. What all
    have in common may rise or fall along each parameter. A point with one replicate has what all
    have in common there. If too few points have two, the scatter between initial states is not
    known, and the errors within the runs are all there is.

    ``values`` are those of the replicates of each point, (R,); ``own`` is the standard error of
    each mean as known from within the runs, (n,), 0 where it is not known; ``places`` are the
    points in the unit cube, (n, d).
    """
    counts = np.array([row.size for row in values])
    variances = np.array([row.var(ddof=1) if row.size > 1 else np.nan for row in values])
    freedom = np.maximum(counts - 1, 0)
    scattered = np.nan_to_num(variances)
    if freedom[variances > 0].sum() >= _ENOUGH_FREEDOM:
        scattered = _moderate(variances, freedom, places)
    errors = np.maximum(own, np.sqrt(scattered / np.maximum(counts, 1)))
    return errors, bool(freedom.sum() < _ENOUGH_FREEDOM)


def _moderate(variances: np.ndarray, freedom: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the variances (n,) moderated by their common distribution, for all points."""
    # Imported here: reading a surrogate's file needs none of it.
    from scipy.optimize import brentq
    from scipy.special import digamma, polygamma

    scattered = variances > 0
    half = freedom[scattered] / 2
    logs = np.log(variances[scattered]) - digamma(half) + np.log(half)
    trend = _trend(places, scattered, logs, polygamma(1, half))
    excess = float(np.mean((logs - trend[scattered]) ** 2)) - polygamma(1, half).mean()
    if excess <= polygamma(1, 1e4):
        return np.exp(trend)
    prior = brentq(lambda x: float(polygamma(1, x)) - excess, 1e-3, 1e4)
    common = np.exp(trend + digamma(prior) - np.log(prior))
    own = np.nan_to_num(variances) * freedom
    return (2 * prior * common + own) / (2 * prior + freedom)


def _trend(
    places: np.ndarray, scattered: np.ndarray, logs: np.ndarray, noise: np.ndarray
) -> np.ndarray:
    """Return what the logarithms of variances are at all places (n, d), linear in each parameter.

    Slopes are 0 ± `_SLOPE` before any run; ``logs`` at the ``scattered`` places have a known noise.
    """
    basis = np.column_stack([np.ones(len(places)), places - places[scattered].mean(axis=0)])
    weighted = basis[scattered].T / noise
    before = np.diag([0.0, *np.full(places.shape[1], _SLOPE**-2)])
    return basis @ np.linalg.solve(weighted @ basis[scattered] + before, weighted @ logs)


def unit_cube(axes: tuple[Axis, ...], columns: Mapping[Any, Any]) -> np.ndarray:
    """Return values (n,) of parameters, by name, in the unit cube, (n, d).

    Words and switches have a dimension for each value, or one where there are two.
    """
    parts = []
    for axis in axes:
        values = columns[axis.name]
        if not axis.is_number:
            shown = axis.choices[1:] if len(axis.choices) == 2 else axis.choices
            parts += [np.asarray(values == choice, dtype=float) for choice in shown]
            continue
        low, high, numbers = axis.low, axis.high, np.asarray(values, dtype=float)
        if axis.scale == "log":
            low, high, numbers = np.log(low), np.log(high), np.log(numbers)
        parts.append((numbers - low) / (high - low))
    return np.column_stack(parts)


def require_places(name: str, arrays: Mapping[str, xr.DataArray]) -> None:
    """Refuse lists of points of different lengths, and grids of too many places."""
    sizes = dict[Any, int]()
    for parameter, array in arrays.items():
        for dim, size in array.sizes.items():
            if sizes.setdefault(dim, size) != size:
                allowed = f"{sizes[dim]} values, as others have over {dim}"
                raise InputError.of_value(name, parameter, f"{size} values", allowed)
    if (count := prod(sizes.values())) > _MOST_PLACES:
        allowed = f"a grid of at most {_MOST_PLACES:,}; points=True takes lists as points"
        raise InputError.of_value(name, "parameter", f"{count:,} places", allowed)


def scaled(shares: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the values of parameters at points (n, k) of the unit cube."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    linear = low + (high - low) * shares
    # The ratio of a range that includes 0 is not used.
    ratio = np.where(is_log, high / np.where(is_log, low, 1.0), 1.0)
    return np.where(is_log, low * ratio**shares, linear)


def unscaled(x: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the points of the unit cube that stand for values (n, k), as `scaled` gives them."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithmic = np.log(x / low) / np.log(high / low)
    return np.where(is_log, logarithmic, (x - low) / (high - low))


@dataclass(frozen=True)
class Frame:
    """A form of an observable over the unit cube of some axes."""

    #: Its scale and its groups of parameters.
    form: Form
    #: Parameters that points vary, and those that are the same at all points.
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Any]

    def scale(self, x: np.ndarray) -> np.ndarray:
        """Return the scale of the observable (n,) at points (n, d) of the unit cube."""
        if self.form.scale is None:
            return np.ones(len(x))
        return self._column(self.form.scale, x)

    def places(self, x: np.ndarray) -> np.ndarray:
        """Return the groups at points (n, d) of the unit cube, (n, k), each in its unit."""
        columns = {f"{number}": column for number, column in enumerate(x.T)}
        at = {axis.name: f"{number}" for number, axis in self._numbers().items()}
        for name, function in self.form.inputs.items():
            columns[at.get(name, name)] = self._column(function, x)
        return np.column_stack(list(columns.values()))

    def is_usable(self, x: np.ndarray) -> bool:
        """Whether scale and groups are finite at points, and the scale is above 0."""
        try:
            scale, places = self.scale(x), self.places(x)
        except KeyError:
            # A parameter of the form differs from point to point without being an axis.
            return False
        return bool((scale > 0).all() and np.isfinite(scale).all() and np.isfinite(places).all())

    def _numbers(self) -> dict[int, Axis]:
        """Return the axes that are numbers, by their columns of the unit cube."""
        axes, column = {}, 0
        for axis in self.axes:
            if axis.is_number:
                axes[column] = axis
            column += 1 if axis.is_number or len(axis.choices) == 2 else len(axis.choices)
        return axes

    def _column(self, function: Any, x: np.ndarray) -> np.ndarray:
        numbers = self._numbers()
        axes = list(numbers.values())
        bounds = np.reshape([(axis.low, axis.high) for axis in axes], (-1, 2))
        columns = scaled(x[:, list(numbers)], bounds, [axis.scale for axis in axes]).T
        values = dict(zip([axis.name for axis in axes], columns, strict=True))
        with np.errstate(all="ignore"):
            column = np.asarray(function({**self.fixed, **values}), dtype=float)
        return np.broadcast_to(column, len(x))
