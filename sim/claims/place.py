"""One point of a study as a judge sees it, its numbers with intervals."""

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

# Beds at rest and exact experiments do have no error at all.
warnings.filterwarnings("ignore", message="Using UFloat objects with std_dev==0")


def measured(value: float, half_width: float) -> UFloat:
    """Return a number whose standard deviation stands for the half width of its 95 % interval."""
    return ufloat(value, half_width / SIGMAS if isfinite(half_width) else inf)


def joined(values: np.ndarray) -> UFloat:
    """Return the mean over replicates with Student's interval; endless for fewer than two."""
    values = np.asarray(values, float)
    if values.size == 0:
        return measured(nan, inf)
    return measured(float(values.mean()), float(student_half_width(values)))


def quotient(over: UFloat, under: UFloat) -> UFloat:
    """Return a ratio whose 95 % interval holds even where the divisor is hardly known.

    It reaches as far to both sides as Fieller's interval does to the farther one, without an end
    where the divisor's own interval holds zero.
    """
    value = over.nominal_value / under.nominal_value
    unsure = (SIGMAS * under.std_dev / under.nominal_value) ** 2
    if not unsure < 1:
        return measured(value, inf)
    above = (SIGMAS * over.std_dev / under.nominal_value) ** 2
    spread = sqrt(above * (1 - unsure) + value**2 * unsure)
    return measured(value, (abs(value) * unsure + spread) / (1 - unsure))


class Place:
    """One point of a study as a judge sees it: its completed replicates together.

    ``place["frequency"]`` is a parameter.
    """

    def __init__(self, results: Results, point: str):
        self.id = point
        self._results = results
        self._held = results.dataset.variables
        self._number = results.dataset.indexes["point"].get_loc(point)
        self._done = self._held["status"].values[self._number] == "completed"

    def __getitem__(self, name: str) -> Any:
        return np.asarray(self._held[name].values[self._number]).item()

    @property
    def completed(self) -> int:
        """Completed replicates."""
        return int(self._done.sum())

    @cached_property
    def outcome(self) -> dict[str, Any]:
        """What replicates say together, as in `sim.dataset.replicates`."""
        names = (*SCALARS, *PARAMETERS)
        return outcome({name: self._held[name].values[self._number] for name in names})

    @property
    def regime(self) -> str:
        """Regime of all replicates together."""
        return self.outcome["regime"]

    @cached_property
    def samples(self) -> float:
        """Independent samples behind the mean velocity, of all completed replicates together.

        Endless for flows at rest: they do not fluctuate, their verdict rests on the interval alone.
        """
        if self.regime == "arrested":
            return inf if self.completed else 0.0
        return float(np.nansum(self.values("independent_samples")))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of intervals: those over replicates, or within a single one."""
        return max(1.0, self.samples - 1) if self.completed == 1 else self.completed - 1.0

    @cached_property
    def velocity(self) -> UFloat:
        """Mean velocity (m/s)."""
        return measured(self.outcome["velocity"], self.outcome["half_width"])

    @cached_property
    def window(self) -> float:
        """Length of the window over which means are taken (s), mean over replicates."""
        end = self.values("steps") * self.values("time_step_used")
        return float((end - self.values("average_start")).mean())

    @cached_property
    def change(self) -> UFloat:
        """Change of the velocity (m/s) over the window, from the mean signed slope."""
        slope = self.outcome["acceleration"], self.outcome["acceleration_half_width"]
        return self.window * measured(*slope)

    def values(self, name: str) -> np.ndarray:
        """Return a scalar of all completed replicates."""
        if name not in self._held:
            raise Untestable(f"{self.id} has no {name}")
        return self._held[name].values[self._number][self._done]

    def value(self, name: str, error: str = "", half_width: str = "") -> UFloat:
        """Return a scalar with its interval over replicates.

        ``error`` names the scalar with its standard error within a replicate, ``half_width`` that
        with half of its 95 % interval: what replicates know of themselves counts where there is a
        single one, and is the least that their scatter can give otherwise.
        """
        values = self.values(name)
        over = joined(values)
        if not (error or half_width):
            return over
        own = self.values(error) if error else self.values(half_width) / SIGMAS
        least = float(np.sqrt((own**2).sum())) / max(1, values.size)
        scatter = over.std_dev if values.size > 1 else 0.0
        return ufloat(over.nominal_value, max(least, scatter))

    def profile(self, name: str, grid: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return a profile (R, H) of all completed replicates and its heights (H,) in m.

        That of a belt is on one of the grids of `sim.dataset.grids`, that of the reading if none
        is named.
        """
        try:
            return self._results.profile(self.id, name, grid)
        except InputError as error:
            raise Untestable(str(error)) from None

    def measure(self, function: Callable[..., float], *names: str, grid: str = "") -> UFloat:
        """Return a measure of profiles with its interval over replicates.

        ``function(height, *profiles)`` is called per replicate with one profile (H,) per name.
        """
        return joined(self.each(function, *names, grid=grid))

    def each(self, function: Callable[..., float], *names: str, grid: str = "") -> np.ndarray:
        """Return a measure of profiles of each completed replicate, (R,); see `measure`."""
        columns = [self.profile(name, grid) for name in names]
        height = columns[0][1]
        rows = zip(*(values for values, _ in columns), strict=True)
        return np.array([function(height, *row) for row in rows])
