"""What judges ask for: places of a study under one protocol and one reading, with intervals."""

import warnings
from collections.abc import Callable, Mapping
from functools import cached_property
from math import inf, isfinite, nan
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat, ufloat

from sim.claims.starts import over_seeds
from sim.claims.verdict import SIGMAS, Unbounded, Untestable
from sim.errors import InputError
from sim.outcome import outcome, student_half_width
from sim.parameters import NUMERICAL, SYSTEMS, field_info
from sim.results import Results

# Beds at rest and exact experiments do have no error at all.
warnings.filterwarnings("ignore", message="Using UFloat objects with std_dev==0")

#: Parameters that tell readings of the papers apart, besides the published default of each.
READINGS = {
    "chute": ("law", "overlap_memory", "friction_cap", "tangential_ratio", "tangential_exponent"),
    "belt": ("damping_mass", "attraction", "belt_ghost", "integrator"),
}


def measured(value: float, half_width: float) -> UFloat:
    """Return a number whose standard deviation stands for the half width of its 95 % interval."""
    return ufloat(value, half_width / SIGMAS if isfinite(half_width) else inf)


def joined(values: np.ndarray) -> UFloat:
    """Return the mean over replicates with Student's interval; endless for fewer than two."""
    values = np.asarray(values, float)
    if values.size == 0:
        return measured(nan, inf)
    return measured(float(values.mean()), float(student_half_width(values)))


class Place:
    """One point of a study as a judge sees it: its completed replicates together.

    ``place["frequency"]`` is a parameter.
    """

    def __init__(self, results: Results, point: str):
        self.id = point
        self._results = results
        self._row = results.dataset.sel(point=point)
        self._outcome = outcome(self._row)
        done = self._row["status"].values == "completed"
        self._completed = self._row.isel(replicate=np.flatnonzero(done))

    def __getitem__(self, parameter: str) -> Any:
        return self._row[parameter].values.item()

    @property
    def completed(self) -> int:
        """Completed replicates."""
        return self._outcome["completed"]

    @property
    def regime(self) -> str:
        """Regime of all replicates together, as in `sim.outcome`."""
        return self._outcome["regime"]

    @property
    def quality(self) -> str:
        """What the means are worth, as in `sim.outcome`."""
        return self._outcome["quality"]

    @cached_property
    def samples(self) -> float:
        """Independent samples behind the mean velocity, of all completed replicates together.

        Endless for flows at rest: they do not fluctuate, their verdict rests on the interval alone.
        """
        if self.regime == "arrested":
            return inf if self.completed else 0.0
        return float(np.nansum(self._completed["independent_samples"].values))

    @cached_property
    def velocity(self) -> UFloat:
        """Mean velocity (m/s)."""
        return measured(self._outcome["velocity"], self._outcome["half_width"])

    def values(self, name: str) -> np.ndarray:
        """Return a scalar of all completed replicates."""
        if name not in self._completed:
            raise Untestable(f"{self.id} has no {name}")
        return self._completed[name].values

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

    def profile(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a profile (R, H) of all completed replicates and its heights (H,) in m."""
        try:
            return self._results.profile(self.id, name)
        except InputError as error:
            raise Untestable(str(error)) from None

    def measure(self, function: Callable[..., float], *names: str) -> UFloat:
        """Return a measure of profiles with its interval over replicates.

        ``function(height, *profiles)`` is called per replicate with one profile (H,) per name.
        """
        columns = [self.profile(name) for name in names]
        height = columns[0][1]
        rows = zip(*(values for values, _ in columns), strict=True)
        return joined(np.array([function(height, *row) for row in rows]))


class Evidence:
    """All places of one protocol and one reading.

    Parameters
    ----------
    results : Results
        The study.
    protocol : str
        ``published`` or ``converged``.
    reading : mapping, optional
        Parameters among `READINGS` that differ from their defaults.
    """

    def __init__(self, results: Results, protocol: str, reading: Mapping[str, Any] | None = None):
        self.protocol = protocol
        self.reading = dict(reading or {})
        self._results = results
        self._places: dict[str, Place] = {}

    def at(self, system: str, **where: Any) -> Place:
        """Return the place with these parameters, all others at the paper's values.

        Numerical settings (`sim.parameters.NUMERICAL`) that are not named may have any value:
        defaults come first, then more replicates, then longer runs. Raises `Untestable` when there
        is no such place, or none of its replicates completed.
        """
        found = self._rows(system, where)
        if found.empty:
            raise Untestable(f"no {self.protocol} run of the {system} at {_text(where)}")
        return self._place(self._richest(system, found, where))

    def line(self, system: str, along: str, **where: Any) -> dict[float, Place]:
        """Return the places along a parameter in its order, all others as for `at`.

        Empty where there are none.
        """
        found = self._rows(system, where, free=along)
        return {
            value: self._place(self._richest(system, rows, where))
            for value, rows in found.groupby(along, sort=True)
        }

    def boundary(
        self, system: str, of: str, along: str, *, seeds: bool = False, **where: Any
    ) -> UFloat:
        """Return a boundary found by refinement; its interval is the bracket.

        Boundaries that differ in nothing but the seed are joined, see `sim.claims.starts`. With
        ``seeds`` the interval is endless where none of the kind was looked for from two seeds.
        Raises `Untestable` when the study looks for no such boundary, and `Unbounded` when it does
        but one seed at least has none: without those beyond the range the others would agree too
        well.
        """
        rows = self._results.boundaries
        if len(rows):
            same = (rows["system"] == system) & (rows["of"] == of) & (rows["along"] == along)
            rows = rows[same & (rows["protocol"] == self.protocol)]
        chosen = rows[self._matching(rows, system, where, along)] if len(rows) else rows
        if chosen.empty:
            raise Untestable(f"no boundary of {of} along {along} at {_text(where)}")
        settings = [name for name in SYSTEMS[system].model_fields if name not in ("seed", along)]
        found = rows[["low", "high"]].notna().all(axis=1)
        complete = found.groupby([rows[name] for name in settings], dropna=False).transform("all")
        bounded = chosen[complete[chosen.index]]
        if bounded.empty:
            lacking = sorted(set(chosen.loc[~found[chosen.index], "seed"]))
            listed = ", ".join(f"{seed:g}" for seed in lacking)
            what = f"boundary of {of} along {along} at {_text(where)}"
            raise Unbounded(f"no {what} found from seed {listed}")
        value, half_width, freedom = over_seeds(rows[found], bounded, settings)
        return measured(value, inf if seeds and not freedom else half_width)

    @cached_property
    def _table(self) -> pd.DataFrame:
        dataset = self._results.dataset
        names = [name for name, values in dataset.coords.items() if values.dims == ("point",)]
        table = pd.DataFrame({name: dataset[name].values for name in names})
        return table.assign(
            completed=(dataset["status"].values == "completed").sum(axis=1),
            steps=dataset["steps"].sum("replicate").values,
        )

    def _rows(self, system: str, where: Mapping[str, Any], free: str = "") -> pd.DataFrame:
        table = self._table
        rows = table[(table["system"] == system) & (table["completed"] > 0)]
        return rows[self._matching(rows, system, where, free)]

    def _matching(
        self, rows: pd.DataFrame, system: str, where: Mapping[str, Any], free: str
    ) -> pd.Series:
        """Return which rows have the parameters named, and the paper's values of the others."""
        wanted = _usual(system) | {"protocol": self.protocol} | self.reading | dict(where)
        wanted.pop(free, None)
        if "friction_plane" not in where:
            wanted.pop("friction_plane", None)
        matching = pd.Series(True, index=rows.index)
        for name, value in wanted.items():
            matching &= rows[name] == value
        if system == "chute" and "friction_plane" not in where:
            matching &= rows["friction_plane"] == rows["friction"]
        return matching

    def _richest(self, system: str, rows: pd.DataFrame, where: Mapping[str, Any]) -> str:
        """Return the point with the fewest unusual settings, most replicates and longest runs."""
        unusual = pd.Series(0, index=rows.index)
        for name in _CHANGES_START & set(field_info(SYSTEMS[system])) - set(where):
            usual = [_default(system, name, row) for row in rows.to_dict("records")]
            unusual += (rows[name] != usual).astype(int)
        ranked = rows.assign(unusual=unusual).sort_values(
            ["unusual", "completed", "steps"], ascending=[True, False, False]
        )
        return ranked["point"].iloc[0]

    def _place(self, point: str) -> Place:
        if point not in self._places:
            self._places[point] = Place(self._results, point)
        return self._places[point]


#: Numerical settings that an answer may depend on after all: unless a judge names them, places with
#: their defaults come first.
_CHANGES_START = {"cell", "initial_velocity"}


def _text(where: Mapping[str, Any]) -> str:
    """Write parameters for a message: ``frequency 20, amplitude 1``."""
    return ", ".join(f"{name} {value}" for name, value in where.items()) or "the paper's values"


def _usual(system: str) -> dict[str, Any]:
    """Return the paper's value of every parameter that sets which flow a point is."""
    usual = SYSTEMS[system]()
    names = set(SYSTEMS[system].model_fields) - NUMERICAL - {"system"}
    return {name: getattr(usual, name) for name in names}


def _default(system: str, name: str, row: Mapping[str, Any]) -> Any:
    """Return the default of a setting, which may follow from the depth."""
    settings = {"depth": row["depth"]} if system == "chute" else {}
    return getattr(SYSTEMS[system](**settings), name)
