"""A surrogate: mean, error and probability of each regime between the points of a series."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError, percent
from sim.base.messages import one_of
from sim.base.statistics import MANY, student
from sim.parameters import SYSTEMS
from sim.parameters.in_place import known_scales, plain_numbers
from sim.parameters.observables import forms
from sim.parameters.words import setting
from sim.study.design import Axis
from sim.study.plottable import numbers
from sim.study.surrogate import SurrogateFile, fewest_points
from sim.surrogates import answers
from sim.surrogates.answers import Refusal
from sim.surrogates.extreme import extreme
from sim.surrogates.fit import Regimes, counted_probability, fit_process
from sim.surrogates.process import Process
from sim.surrogates.sample import Frame, omissions, points_of_mean, require_places, unit_cube

#: Share of a range by which a value may be outside it: sums of steps need not end on it.
_SLACK = 1e-9

#: Largest distance to a point near a place, over the largest between neighbours.
_REACH = 1.5

#: Most ranges by which a value may be outside, where it is asked for.
_MOST_OUTSIDE = 100.0


@dataclass(frozen=True)
class Surrogate:
    """A surrogate of an observable; called with values of its parameters, it predicts.

    Attributes
    ----------
    name, observable, unit, meaning, system : str
        Its name; what it is of, in which SI unit; the system of its points.
    axes : tuple of Axis
        Parameters that the points vary.
    fixed : mapping
        Parameters that are the same at all points, by name.
    mean_regimes : tuple of str
        Regimes whose points the mean is of.
    sample : xarray.Dataset
        Its points, see `sim.surrogates.sample.sample_points`.
    process, regimes : Process, Regimes
        The mean, and the probability of each regime.
    setting : mapping
        Values of words and switches, where they are chosen.
    """

    name: str
    observable: str
    unit: str
    meaning: str
    system: str
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Any]
    mean_regimes: tuple[str, ...]
    sample: xr.Dataset
    process: Process = field(repr=False)
    regimes: Regimes = field(repr=False)
    setting: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def fit(cls, spec: SurrogateFile, sample: xr.Dataset) -> "Surrogate":
        """Return the surrogate that a study asks for, through points as of `sample_points`.

        Raises `Refusal` when fewer than `fewest_points` have a mean and a regime that counts.
        """
        chosen, fewest = points_of_mean(sample, spec.mean_regimes), fewest_points(len(spec.axes))
        if chosen.sum() < fewest:
            raise Refusal(
                f"no mean, as {chosen.sum()} of {len(chosen)} points of "
                f"series {spec.series} count ({' or '.join(spec.mean_regimes)}) and {fewest} are "
                f"needed; left out are {omissions(sample, spec.mean_regimes) or 'none'}; "
                "more points, other ranges or the key regimes may give others"
            )
        x, fixed = unit_cube(spec.axes, sample), sample.attrs["fixed"]
        process = fit_process(
            x[chosen],
            sample["mean"].values[chosen],
            sample["standard_error"].values[chosen] ** 2,
            bool(sample.attrs["scatter"]),
            [Frame(one, spec.axes, fixed) for one in forms(spec.system, spec.observable).values()],
        )
        observable = numbers(spec.system)[spec.observable]
        return cls(
            name=spec.name,
            observable=spec.observable,
            unit=observable.unit,
            meaning=observable.meaning,
            system=spec.system,
            axes=spec.axes,
            fixed=fixed,
            mean_regimes=spec.mean_regimes,
            sample=sample,
            process=process,
            regimes=Regimes.fit(x, sample["regime"].values, spec.mean_regimes),
        )

    @property
    def numeric(self) -> tuple[Axis, ...]:
        """The axes that are numbers."""
        return tuple(axis for axis in self.axes if axis.is_number)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Their names, in order."""
        return tuple(axis.name for axis in self.numeric)

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest value of each of them, (k, 2)."""
        return np.array([(axis.low, axis.high) for axis in self.numeric], dtype=float)

    @property
    def scales(self) -> tuple[str, ...]:
        """Scale of each of them, ``linear`` or ``log``."""
        return tuple(axis.scale for axis in self.numeric)

    @property
    def choices(self) -> dict[str, tuple[Any, ...]]:
        """Values of the parameters that are words or switches and are not set, by name."""
        words = (axis for axis in self.axes if not axis.is_number)
        return {axis.name: axis.choices for axis in words if axis.name not in self.setting}

    def at(self, **setting: Any) -> "Surrogate":
        """Return the surrogate at values of parameters that are words or switches."""
        for name, value in setting.items():
            if name not in self.choices:
                allowed = "one of " + ", ".join(self.choices) if self.choices else "none"
                raise InputError.of_value(self.name, "parameter", name, allowed)
            if value not in self.choices[name]:
                raise self._error(name, value)
        return replace(self, setting={**self.setting, **setting})

    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and standard deviation of the mean (n,), in the unit of the observable.

        ``x`` has values of `parameters`, (n, k), in the units of study files, not checked.
        """
        return self.process.predict(self.cube(x))

    def correlation(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return how errors go together, (g, m, r), at values (g, m, k) and (g, r, k) in groups."""
        cubes = (
            self.cube(part.reshape(-1, part.shape[-1])).reshape(*part.shape[:2], -1)
            for part in (x, others)
        )
        return self.process.correlation(*cubes)

    def probability(self, x: np.ndarray) -> np.ndarray:
        """Return the probability of each of ``regimes.names`` at points as of `predict`, (m, n)."""
        return self.regimes.predict(self.cube(x))

    def __call__(
        self, *, extrapolate: bool = False, points: bool = False, **values: Any
    ) -> xr.Dataset:
        """Predict at values of the parameters.

        Parameters
        ----------
        extrapolate : bool
            Predict outside the ranges, too; the attribute ``caveats`` says how far outside.
        points : bool
            Lists are coordinates of points, over ``point``, not of a grid.
        **values
            A number, a list of numbers, an `xarray.DataArray` or a column of a table for each
            parameter, in the units of study files, or numbers with a unit. A list becomes a
            dimension of its name; arrays and columns that share a dimension or an index are points.
            Fixed ones may be left out. A number that is left out is held in the middle of its
            range, as in pictures.

        Returns
        -------
        xarray.Dataset
            ``mean``, ``half_width`` of its 95 % interval, and ``probability`` over ``regime``. The
            attribute ``caveats`` says what is doubtful about them, the worst first, and ``held``
            which numbers are in the middle of their ranges.

        Raises
        ------
        InputError
            For a word that is missing, an unknown parameter, and a value outside the range of the
            points.
        """
        values = self._plain(values)
        chosen = [name for name in values if name in self.choices]
        surrogate = self.at(**{name: values.pop(name) for name in chosen})
        names = [axis.name for axis in self.axes]
        for name in [name for name in values if name not in names]:
            self._require_fixed(name, values.pop(name))
        for name in surrogate.choices:
            raise self._error(name, None)
        held = {axis.name: axis.middle for axis in self.numeric if axis.name not in values}
        values |= held
        arrays = [self._array(axis, values[axis.name], points) for axis in self.numeric]
        require_places(self.name, dict(zip(self.parameters, arrays, strict=True)))
        outside = self._outside(arrays, extrapolate)
        broadcast = xr.broadcast(*arrays)
        x = np.column_stack([array.values.ravel() for array in broadcast])
        mean, error = surrogate.predict(x)
        shape, dims = broadcast[0].shape, broadcast[0].dims
        probability = surrogate.probability(x).reshape(-1, *shape)
        width, meaning = float(student(MANY)) * error, self.meaning
        about = {"units": self.unit, "long_name": meaning}
        of_width = about | {"long_name": f"half width of the 95 % interval of {meaning}"}
        answer = xr.Dataset(
            {
                "mean": (dims, mean.reshape(shape), about),
                "half_width": (dims, width.reshape(shape), of_width),
                "probability": (("regime", *dims), probability, {"units": "1"}),
            },
            dict(zip(self.parameters, arrays, strict=True))
            | {"regime": list(self.regimes.names)}
            | dict(surrogate.setting),
        )
        counted = counted_probability(self, probability)
        places = answers.caveats_of_places(counted, self.mean_regimes, surrogate.is_far(x))
        answer.attrs = {
            "surrogate": self.name,
            "observable": self.observable,
            "error": self.error,
            "held": ", ".join(setting(self.system, *one) for one in held.items()),
            answers.KEY: answers.joined([*places, *outside, *self.caveats]),
        }
        return answer

    def highest(self, **values: Any) -> xr.Dataset:
        """Predict where the mean is highest, at some values of parameters if they are given.

        See `sim.surrogates.extreme.extreme`.
        """
        return extreme(self, 1, self._plain(values))

    def lowest(self, **values: Any) -> xr.Dataset:
        """Predict where the mean is lowest, as `highest` does."""
        return extreme(self, -1, self._plain(values))

    def _plain(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return values of parameters with those that have a unit as plain numbers."""
        known = known_scales({**self.fixed, **values})
        return plain_numbers(values, SYSTEMS[self.system], known)

    def cube(self, x: np.ndarray) -> np.ndarray:
        """Return points as of `predict` in the unit cube of the process."""
        for name in self.choices:
            raise self._error(name, None)
        columns = dict(zip(self.parameters, np.asarray(x, dtype=float).T, strict=True))
        chosen = {name: np.full(len(x), value, object) for name, value in self.setting.items()}
        return unit_cube(self.axes, columns | chosen)

    def _error(self, name: str, value: Any) -> InputError:
        """Return the error of a value of a parameter that the points vary."""
        axis = next(one for one in self.axes if one.name == name)
        allowed = f"a number in [{axis.low:g}, {axis.high:g}], the range of its points"
        if not axis.is_number:
            allowed = "one of " + ", ".join(map(str, axis.choices))
        return InputError.of_value(self.name, name, value, allowed)

    def _require_fixed(self, name: str, value: Any) -> None:
        """Refuse a parameter that no point varies, unless its value is that of all points."""
        if name not in self.fixed:
            names = one_of(name, [axis.name for axis in self.axes])
            raise InputError.of_value(self.name, "parameter", name, names)
        fixed = self.fixed[name]
        if np.ndim(value) or value != fixed:
            shown = f"{fixed:g}" if type(fixed) in (int, float) else fixed
            raise InputError.of_value(self.name, name, value, f"{shown}, as all its points have")

    def _array(self, axis: Axis, value: Any, points: bool) -> xr.DataArray:
        """Return values of a parameter as a labelled array."""
        array = value.to_xarray() if isinstance(value, pd.Series) else value
        if not isinstance(array, xr.DataArray):
            try:
                plain = np.asarray(value, dtype=float)
            except (TypeError, ValueError):
                raise self._error(axis.name, value) from None
            if plain.ndim > 1:
                got = f"an array of {plain.ndim} dimensions"
                allowed = "a number, a list of numbers, or an array of xarray"
                raise InputError.of_value(self.name, axis.name, got, allowed)
            dims = ("point" if points else axis.name,) * plain.ndim
            array = xr.DataArray(plain, {} if points else dict.fromkeys(dims, plain), dims)
        if not array.size or not np.isfinite(array.values.astype(float)).all():
            raise self._error(axis.name, value)
        return array.astype(float)

    def _outside(self, arrays: list[xr.DataArray], extrapolate: bool) -> list[str]:
        """Return how far values are outside the ranges, in words, or refuse them."""
        notes = []
        for axis, array in zip(self.numeric, arrays, strict=True):
            for value in dict.fromkeys((float(array.min()), float(array.max()))):
                beyond = max(axis.low - value, value - axis.high) / (axis.high - axis.low)
                if beyond <= _SLACK:
                    continue
                is_absurd = beyond > _MOST_OUTSIDE or (axis.scale == "log" and value <= 0)
                if is_absurd or not extrapolate:
                    raise self._error(axis.name, value)
                notes.append(
                    f"{axis.name} = {value:g} is {percent(beyond)} of its range outside "
                    f"[{axis.low:g}, {axis.high:g}]"
                )
        return notes

    @cached_property
    def in_mean(self) -> np.ndarray:
        """Which points the mean is of, (n,)."""
        return points_of_mean(self.sample, self.mean_regimes)

    @cached_property
    def leave_one_out(self) -> xr.Dataset:
        """The points of the mean as the others predict them, over ``point``.

        ``run`` and ``run_error`` are the mean of the runs and its standard deviation; ``mean`` and
        ``error`` what the other points predict, lengths unchanged.
        """
        left_out, rows = self.process.left_out, self.sample.isel(point=self.in_mean)
        columns = {
            "run": rows["mean"].values,
            "run_error": left_out.noise,
            "mean": left_out.mean,
            "error": self.process.widening * self.process.own_widening() * left_out.error,
        }
        return xr.Dataset({name: ("point", one) for name, one in columns.items()}, rows.coords)

    @cached_property
    def error(self) -> float:
        """Error of the mean, relative to the mean size of the observable.

        The larger of how far points are from what others predict (rms), less their own errors, and
        the error that the process gives itself there.
        """
        own, size = np.mean(self.process.left_out.error**2), np.abs(self.process.y).mean() or 1.0
        return float(np.sqrt(max(self.process.unexplained, own)) / size)

    def is_far(self, x: np.ndarray) -> np.ndarray:
        """Return which places as of `predict` have no point of the mean near them, (n,).

        The distance to the nearest is larger there than any usual one between neighbours.
        """
        from scipy.spatial import KDTree

        tree = KDTree(self.process.x)
        apart = tree.query(self.process.x, k=2)[0][:, 1].max()
        return np.asarray(tree.query(self.cube(x))[0] > _REACH * apart)

    @cached_property
    def coverage(self) -> float:
        """Share of points in the 95 % interval that the others give them, before it is widened."""
        return float(np.mean(self.process.deviations < student(MANY)))

    @property
    def basis(self) -> str:
        """Of how many points the mean is, and its error, in words."""
        points = f"{len(self.process.y)} of {self.sample.sizes['point']} points"
        text = f"mean of {points}, error {percent(self.error)}"
        return f"{text}, {self.process.frame.form.meaning}" if self.process.frame else text

    @cached_property
    def caveats(self) -> tuple[str, ...]:
        """What is doubtful about it, the worst first."""
        share = self.process.unexplained_share
        means = answers.caveats_of_mean(
            self.sample, self.in_mean, self.error, share, self.omissions
        )
        return *means, *answers.caveats_of_axes(self.sample.isel(point=self.in_mean), self.axes)

    @property
    def omissions(self) -> str:
        """How many points of which regime, or without a value, the mean leaves out, in words."""
        return omissions(self.sample, self.mean_regimes)
