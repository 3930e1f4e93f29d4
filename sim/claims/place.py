"""One point of a study as a judge sees it: its numbers with intervals."""

import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from itertools import product
from math import inf, isfinite, nan, sqrt
from typing import Any

import numpy as np
from uncertainties import UFloat, ufloat

from sim.base.additions import plain_name
from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.claims.verdict import SIGMAS, Untestable
from sim.dataset.replicates import PARAMETERS, SCALARS, outcome
from sim.dataset.results import Results
from sim.parameters import SYSTEMS
from sim.parameters.laws import LAW, MOTION
from sim.parameters.roles import amount_parameters, numerical_parameters, start_parameters
from sim.study.papers import Paper, default_in

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

    ``place["frequency"]`` is a parameter. ``measures`` holds the measures of its profiles that are
    known already: readings and alternatives ask for the same again.
    """

    def __init__(self, results: Results, point: str, measures: dict[Any, Any] | None = None):
        self.id = point
        self._results = results
        self._variables = results.dataset.variables
        self._index = results.dataset.indexes["point"].get_loc(point)
        self._is_completed = self._variables["status"].values[self._index] == "completed"
        self._measures: dict[Any, np.ndarray] = {} if measures is None else measures

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
        names = [name for name in (*SCALARS, *PARAMETERS) if name in self._variables]
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

    def value(self, name: str, error: str = "") -> UFloat:
        """Return a scalar with its interval over replicates.

        ``error`` names the scalar that holds the standard error within a replicate. It is the error
        of a single replicate. With several replicates it is a lower bound for the error from their
        scatter.
        """
        values = self.values(name)
        mean = replicate_mean(values)
        if not error:
            return mean
        smallest = float(np.sqrt((self.values(error) ** 2).sum())) / max(1, values.size)
        return ufloat(mean.nominal_value, max(smallest, mean.std_dev if values.size > 1 else 0.0))

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
        """Return a measure of profiles per completed replicate, (R,); see `measure`."""
        key = function, names, grid or self._results.grid
        if key not in self._measures:
            columns = [self.profile(name, grid) for name in names]
            height = columns[0][1]
            rows = zip(*(values for values, _ in columns), strict=True)
            self._measures[key] = np.array([function(height, *row) for row in rows])
            self._measures[key].flags.writeable = False
        return self._measures[key]


def select_replicated(line: Mapping[float, Place], replicates: int = 2) -> dict[float, Place]:
    """Return the places of a line that have at least ``replicates`` completed replicates."""
    return {value: place for value, place in line.items() if place.completed >= replicates}


#: Stands for the paper's value of a setting, which may follow from other parameters.
USUAL = object()

#: Value of a numerical setting that a judge names to say that runs may differ in it.
ANY = object()

#: Parameters that a judge names without the hash of a plug-in.
CHOSEN = (LAW.name, MOTION.name)

#: The `start_parameters` that a row has, those that are named left out.
Start = tuple[object, ...]


class Rows:
    """Rows of parameters: of the points of a study, or of its boundaries.

    ``columns`` are arrays over the rows: ``system``, and every parameter. ``paper`` is the one
    whose values stand for parameters that a judge does not name. A judge looks up places a thousand
    times, so comparisons with these values are cached.
    """

    def __init__(self, columns: Mapping[str, np.ndarray], paper: Paper | None = None):
        self.columns, self.paper = columns, paper
        self._default_masks: dict[tuple[str, str], np.ndarray] = {}

    def matching(self, system: str, conditions: Mapping[str, Any], free: str = "") -> np.ndarray:
        """Return the numbers of the rows with the given values, and the paper's of all others.

        Numerical settings (`sim.parameters.roles.numerical_parameters`) without a given value may
        have any value, and so may the parameter ``free``.
        """
        names = SYSTEMS[system].model_fields.keys() - numerical_parameters(SYSTEMS[system])
        optional = {name for name, value in conditions.items() if value is ANY} | {free, "system"}
        is_match = self.columns["system"] == system
        for name in (names | conditions.keys()) - optional:
            if name in conditions:
                is_match = is_match & self._has_value(name, conditions[name])
            else:
                is_match = is_match & self._has_default(system, name)
        return np.flatnonzero(is_match)

    def _has_value(self, name: str, value: Any) -> np.ndarray:
        """True per row with a value; a choice of a plug-in is compared by name, without hash."""
        values = self.columns[name]
        if name in CHOSEN:
            return np.array([value in (entry, plain_name(entry)) for entry in values], bool)
        return values == value

    def _has_default(self, system: str, name: str) -> np.ndarray:
        """True per row with the paper's value, which may follow from other parameters."""
        if (system, name) not in self._default_masks:
            model, mask = SYSTEMS[system], np.zeros(len(self.columns["system"]), bool)
            for number in np.flatnonzero(self.columns["system"] == system):
                row = {one: self.columns[one][number] for one in model.model_fields}
                usual = default_in(self.paper, system, name, row)
                by_name = plain_name if name in CHOSEN else lambda value: value
                mask[number] = by_name(row[name]) == by_name(usual)
            self._default_masks[system, name] = mask
        return self._default_masks[system, name]


class Points(Rows):
    """The points of a study with a completed replicate.

    ``places`` holds those already looked up, by profile grid and point, and ``measures`` those of
    their profiles, by point: readings share them.
    """

    def __init__(self, results: Results, paper: Paper | None = None):
        variables = results.dataset.variables
        completed = (variables["status"].values == "completed").sum(axis=1)
        indices = np.flatnonzero(completed)
        coordinates = results.dataset.coords.variables.items()
        super().__init__(
            {str(name): one.values[indices] for name, one in coordinates if one.dims == ("point",)},
            paper,
        )
        self._steps = np.nansum(variables["steps"].values, axis=1)[indices]
        self._completed = completed[indices]
        self.places: dict[tuple[str, str], Place] = {}
        self.measures: defaultdict[str, dict[Any, np.ndarray]] = defaultdict(dict)

    def alike(
        self, system: str, places: Sequence[Sequence[int]], where: Mapping[str, Any]
    ) -> list[list[int]]:
        """Return the rows to choose from at each place, the best first; none where none is alike.

        The best are alike in the `start_parameters` that are not in ``where``: they have those of
        most places, so that a control in another cell does not stand in for a flow. Where several
        have equally many places, the paper's come first, and the rows of the others follow. Among
        equals, more replicates come first, then longer runs. Where a start may be `ANY`, the
        paper's comes before that.
        """
        starts = [{row: self._starts(system, row, where) for row in place} for place in places]
        riches, counts = Counter[Start](), Counter[Start]()
        for place in starts:
            counts.update(set().union(*place.values()))
            for row, fitting in place.items():
                riches.update(dict.fromkeys(fitting, int(self._completed[row])))
        equal = {start for start, count in counts.items() if count == max(counts.values())}
        best = max(equal, key=lambda one: (one.count(USUAL), riches[one]), default=())
        names = start_parameters(SYSTEMS[system])
        free = [self._has_default(system, name) for name in names if where.get(name) is ANY]

        def rank(row: int) -> tuple[float, ...]:
            unusual = sum(not mask[row] for mask in free)
            return best not in place[row], unusual, -self._completed[row], -self._steps[row]

        chosen = []
        for place in starts:
            rows = sorted((row for row in place if equal & place[row]), key=rank)
            chosen.append(rows if rows and best in place[rows[0]] else [])
        return chosen

    def _starts(self, system: str, row: int, named: Collection[str]) -> set[Start]:
        """Return what a row has of the `start_parameters`: values, and `USUAL` for the paper's.

        The paper's cell is another above a depth: a line along the depth may have the paper's
        throughout, or one value.
        """
        values = (
            (self.columns[name][row], *[USUAL] * bool(self._has_default(system, name)[row]))
            for name in start_parameters(SYSTEMS[system])
            if name not in named
        )
        return set(product(*values))

    def differences(self, system: str, first: int, second: int) -> list[str]:
        """Return the parameters, other than amounts, in which two rows differ."""
        amounts = amount_parameters(SYSTEMS[system])
        names = (name for name in SYSTEMS[system].model_fields if name not in amounts)
        return [name for name in names if self.columns[name][first] != self.columns[name][second]]
