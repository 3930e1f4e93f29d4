"""One point of a study as a judge sees it: its numbers with intervals."""

import warnings
from collections.abc import Callable
from functools import cached_property
from math import inf, isfinite, nan, sqrt
from typing import Any

import numpy as np
from uncertainties import UFloat, ufloat

from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.claims.verdict import SIGMAS, Untestable
from sim.dataset.replicates import PARAMETERS, SCALARS, outcome
from sim.dataset.results import Results

# Beds at rest and exact experiments have an error of exactly zero.
warnings.filterwarnings("ignore", message="Using UFloat objects with std_dev==0")


def with_interval(value: float, half_width: float) -> UFloat:
    """Return a number whose standard deviation stands for the half width of its 95 % interval."""
    return ufloat(value, half_width / SIGMAS if isfinite(half_width) else inf)


def replicate_mean(values: np.ndarray) -> UFloat:
    """Return the mean over replicates with Student's interval; infinite for fewer than two."""
    values = np.asarray(values, float)
    if values.size == 0:
        return with_interval(nan, inf)
    return with_interval(float(values.mean()), float(student_half_width(values)))


def quotient(numerator: UFloat, denominator: UFloat) -> UFloat:
    """Return a ratio whose 95 % interval holds even where the divisor is hardly known.

    The interval is symmetric: on both sides it reaches as far as the farther end of Fieller's
    interval. It is infinite where the divisor's own interval contains zero.
    """
    value = numerator.nominal_value / denominator.nominal_value
    uncertainty = (SIGMAS * denominator.std_dev / denominator.nominal_value) ** 2
    if not uncertainty < 1:
        return with_interval(value, inf)
    numerator_uncertainty = (SIGMAS * numerator.std_dev / denominator.nominal_value) ** 2
    spread = sqrt(numerator_uncertainty * (1 - uncertainty) + value**2 * uncertainty)
    return with_interval(value, (abs(value) * uncertainty + spread) / (1 - uncertainty))


class Place:
    """One point of a study as a judge sees it: its completed replicates, pooled.

    ``place["frequency"]`` is a parameter.
    """

    def __init__(self, results: Results, point: str):
        self.id = point
        self._results = results
        self._variables = results.dataset.variables
        self._index = results.dataset.indexes["point"].get_loc(point)
        self._is_completed = self._variables["status"].values[self._index] == "completed"
        self._measures: dict[tuple[Any, ...], np.ndarray] = {}

    def __getitem__(self, name: str) -> Any:
        return np.asarray(self._variables[name].values[self._index]).item()

    @property
    def completed(self) -> int:
        """Number of completed replicates."""
        return int(self._is_completed.sum())

    @property
    def replicates(self) -> int:
        """Number of replicates that were run, those that blew up included."""
        status = self._variables["status"].values[self._index]
        return int(np.isin(status, ("completed", "failed")).sum())

    @cached_property
    def outcome(self) -> dict[str, Any]:
        """Statistics pooled over replicates, see `sim.dataset.replicates`."""
        names = (*SCALARS, *PARAMETERS)
        return outcome({name: self._variables[name].values[self._index] for name in names})

    @property
    def regime(self) -> str:
        """Regime of all replicates together."""
        return self.outcome["regime"]

    @cached_property
    def samples(self) -> float:
        """Independent samples behind the mean velocity, summed over completed replicates.

        Infinite for flows at rest: they do not fluctuate, so their verdict rests on the interval
        alone.
        """
        if self.regime == "arrested":
            return inf if self.completed else 0.0
        return float(np.nansum(self.values("independent_samples")))

    @property
    def looks(self) -> int:
        """How often claims on the point have been judged with the option of buying more runs."""
        return int(self["looks"]) if "looks" in self._variables else 0

    @property
    def freedom(self) -> float:
        """Degrees of freedom of intervals: those over replicates, or within a single one."""
        return max(1.0, self.samples - 1) if self.completed == 1 else self.completed - 1.0

    @cached_property
    def velocity(self) -> UFloat:
        """Mean velocity (m/s)."""
        return with_interval(self.outcome["velocity"], self.outcome["half_width"])

    @cached_property
    def window(self) -> float:
        """Length of the averaging window (s), mean over replicates."""
        end = self.values("steps") * self.values("time_step_used")
        return float((end - self.values("average_start")).mean())

    @cached_property
    def velocity_change(self) -> UFloat:
        """Change of the velocity (m/s) over the window, from the mean signed slope."""
        slope = self.outcome["acceleration"], self.outcome["acceleration_half_width"]
        return self.window * with_interval(*slope)

    def values(self, name: str) -> np.ndarray:
        """Return a scalar of all completed replicates, (R,)."""
        if name not in self._variables:
            raise Untestable(f"{self.id} has no {name}")
        return self._variables[name].values[self._index][self._is_completed]

    def value(self, name: str, error: str = "", half_width: str = "") -> UFloat:
        """Return a scalar with its interval over replicates.

        ``error`` names the scalar that holds the standard error within a replicate; ``half_width``
        names the one that holds half of its 95 % interval. The error within replicates is the error
        of a single replicate. With several replicates it is a lower bound for the error from their
        scatter.
        """
        values = self.values(name)
        mean = replicate_mean(values)
        if not (error or half_width):
            return mean
        own_errors = self.values(error) if error else self.values(half_width) / SIGMAS
        smallest_error = float(np.sqrt((own_errors**2).sum())) / max(1, values.size)
        scatter = mean.std_dev if values.size > 1 else 0.0
        return ufloat(mean.nominal_value, max(smallest_error, scatter))

    def profile(self, name: str, grid: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return a profile (R, H) of all completed replicates and its heights (H,) in m.

        A profile of a belt is on one of the grids of `sim.dataset.grids`, by default that of the
        reading.
        """
        try:
            return self._results.profile(self.id, name, grid)
        except InputError as error:
            raise Untestable(str(error)) from None

    def measure(self, function: Callable[..., float], *names: str, grid: str = "") -> UFloat:
        """Return a measure of profiles with its interval over replicates.

        ``function(height, *profiles)`` is called per replicate with one profile (H,) per name.
        """
        return replicate_mean(self.measure_replicates(function, *names, grid=grid))

    def measure_replicates(
        self, function: Callable[..., float], *names: str, grid: str = ""
    ) -> np.ndarray:
        """Return a measure of profiles per completed replicate, (R,); see `measure`.

        Readings and alternatives ask for the same measure again, which is therefore cached.
        """
        key = function, names, grid
        if key not in self._measures:
            columns = [self.profile(name, grid) for name in names]
            height = columns[0][1]
            rows = zip(*(values for values, _ in columns), strict=True)
            self._measures[key] = np.array([function(height, *row) for row in rows])
            self._measures[key].flags.writeable = False
        return self._measures[key]
