"""Evidence for judges: places of a study under one protocol and one reading, with intervals."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.base.statistics import student, student_half_width
from sim.claims.place import ANY, Place, Points, Rows, with_interval
from sim.claims.verdict import SIGMAS, Ambiguous, Unbounded, Untestable
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, roles
from sim.parameters.words import setting
from sim.study.papers import Paper, Readings, papers


class Evidence:
    """All places of a study of one protocol, ``published`` or ``converged``, and one reading.

    ``reading`` has the parameters of the reading (`sim.parameters.roles.reading_parameters`) that
    differ from their defaults; ``points`` are those of the study, if they have been read already,
    and have the paper, see `sim.claims.place.Rows`.
    """

    def __init__(
        self,
        results: Results,
        protocol: str,
        reading: Mapping[str, Any] | None = None,
        points: Points | None = None,
    ):
        self.protocol = protocol
        self.reading = dict(reading or {})
        self._results = results
        self._points = points or Points(results)

    @property
    def grid(self) -> str:
        """Grid on which profiles are evaluated, one of `sim.dataset.grids.GRIDS`."""
        return self._results.grid

    def with_default(self, name: str) -> "Evidence":
        """Return this evidence with one parameter of the reading reset to its default."""
        if name not in self.reading:
            return self
        reading = {key: value for key, value in self.reading.items() if key != name}
        return Evidence(self._results, self.protocol, reading, self._points)

    def with_reading(self, **reading: Any) -> "Evidence":
        """Return this evidence with further parameters added to the reading."""
        return Evidence(self._results, self.protocol, self.reading | reading, self._points)

    def at(self, system: str, **where: Any) -> Place:
        """Return the place with these parameters, all others at the paper's values.

        Numerical settings (`sim.parameters.roles.numerical_parameters`) that are not named may have
        any value, cell and start (`sim.parameters.roles.start_parameters`) where it makes no
        difference, or where they are named as `ANY`. The paper's are preferred, then more
        replicates, then longer runs. Raises `Untestable` when there is no such place, or none of
        its replicates completed, and `Ambiguous` when there are two whose velocities differ by more
        than their intervals.
        """
        rows = self._rows(system, where)
        if not rows.size:
            label = f"{_describe(where)}, all else as in the paper"
            raise Untestable(f"no {self.protocol} run of the {system} at {label}")
        ((place,),) = self._alike(system, [rows], where)
        return place

    def line(self, system: str, along: str, **where: Any) -> dict[float, Place]:
        """Return the places along a parameter, sorted by its value; all others as for `at`.

        All have one cell and one start, if they are not named those that most values of the
        parameter have. Empty where there are none.
        """
        rows = self._rows(system, where, free=along)
        column = self._points.columns[along][rows]
        values = sorted(set(column.tolist()))
        rows_at = [rows[column == value] for value in values]
        found = zip(values, self._alike(system, rows_at, {**where, along: None}), strict=True)
        return {value: place for value, places in found for place in places}

    def has_runs(self, system: str) -> bool:
        """True where the study has any point of the system under the protocol."""
        dataset = self._results.dataset
        return bool(((dataset["system"] == system) & (dataset["protocol"] == self.protocol)).any())

    def require_points(self, groups: Iterable[Collection[str]]) -> None:
        """Raise `ValueError` for the first name that is no point of the study."""
        points = set(self._results.dataset["point"].values.tolist())
        for name in sorted(set().union(*groups) - points):
            raise ValueError(f"the study has no point {name!r}, which a check names")

    def unsteady_note(self, points: Iterable[str]) -> str:
        """Return a note on how many points are not steady, by regime; empty where all are."""
        regimes = Counter(self._place(point).regime for point in points)
        others = [f"{count} {regime}" for regime, count in regimes.items() if regime != "steady"]
        if not others:
            return ""
        count = regimes.total() - regimes["steady"]
        verb = "is" if count == 1 else "are"
        return f"{count} of {regimes.total()} points {verb} not steady: {', '.join(others)}"

    def boundary(
        self, system: str, of: str, along: str, *, any_protocol: bool = False, **where: Any
    ) -> UFloat:
        """Return a boundary found by refinement; its interval is the bracket.

        Boundaries that differ in the seed alone are pooled. The interval is infinite unless some
        boundary of this kind was searched from two seeds. With ``any_protocol`` the boundary may be
        of the other protocol.

        Raises `Untestable` when the study searches no such boundary. Raises `Unbounded` when a seed
        has none within the range: without that seed the others would agree too well.
        """
        rows, selection = self._boundaries(system, of, along, any_protocol, where)
        settings = [name for name in SYSTEMS[system].model_fields if name not in ("seed", along)]
        is_bracketed = rows[["low", "high"]].notna().all(axis=1)
        groups = is_bracketed.groupby([rows[name] for name in settings], dropna=False)
        candidates = selection[groups.transform("all")[selection.index]]
        if candidates.empty:
            missing_seeds = sorted(set(selection.loc[~is_bracketed[selection.index], "seed"]))
            seed_list = ", ".join(f"{seed:g}" for seed in missing_seeds)
            boundary = f"boundary of {of} along {along} at {_describe(where)}"
            raise Unbounded(f"no {boundary} found from seed {seed_list}")
        return _pool_seeds(rows[is_bracketed], candidates, settings)

    def brackets(self, system: str, of: str, along: str, **where: Any) -> pd.DataFrame:
        """Return ``low`` and ``high`` of a boundary, a row per ``seed``, unknown ends as NaN.

        Raises `Untestable` when the study searches no such boundary.
        """
        _, selection = self._boundaries(system, of, along, False, where)
        return selection.set_index("seed")[["low", "high"]].astype(float)

    def _boundaries(
        self, system: str, of: str, along: str, any_protocol: bool, where: Mapping[str, Any]
    ) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return the boundaries of a kind, and those with the parameters."""
        rows = selection = self._results.boundaries
        if len(rows):
            is_of = (rows["system"] == system) & (rows["of"] == of) & (rows["along"] == along)
            rows = selection = rows[is_of & (any_protocol | (rows["protocol"] == self.protocol))]
        if len(rows):
            # A boundary of the other protocol is selected under its own protocol.
            conditions = self._conditions({"protocol": rows["protocol"].iloc[0]} | dict(where))
            columns = {name: values.to_numpy() for name, values in rows.items()}
            of_paper = Rows(columns, self._points.paper)
            selection = rows.iloc[of_paper.matching(system, conditions, along)]
        if selection.empty:
            raise Untestable(f"no boundary of {of} along {along} at {_describe(where)}")
        return rows, selection

    def _rows(self, system: str, where: Mapping[str, Any], free: str = "") -> np.ndarray:
        return self._points.matching(system, self._conditions(where), free)

    def _conditions(self, where: Mapping[str, Any]) -> dict[str, Any]:
        """Return the required parameter values; all other parameters have the paper's values."""
        # Runs of a reading have its values, whatever else may differ.
        named = {
            name: value
            for name, value in where.items()
            if value is not ANY or name not in self.reading
        }
        return {"protocol": self.protocol} | self.reading | named

    def _alike(
        self, system: str, places: Sequence[np.ndarray], where: Mapping[str, Any]
    ) -> list[list[Place]]:
        """Return the best of the rows at each place, none where none is like those of the others.

        Raises `Ambiguous` for two rows that claim to be one flow and are not.
        """
        free = {name for name, value in where.items() if value is ANY}
        found: list[list[Place]] = []
        for rows in self._points.alike(system, [rows.tolist() for rows in places], where):
            ids = self._points.columns["point"][rows].tolist()
            for row, other in zip(rows[1:], ids[1:], strict=True):
                names = self._points.differences(system, rows[0], row)
                if names != ["seed"] and free.isdisjoint(names):
                    _require_one_flow(self._place(ids[0]), self._place(other), names)
            found.append([self._place(point) for point in ids[:1]])
        return found

    def _place(self, point: str) -> Place:
        key = self._results.grid, point
        if key not in self._points.places:
            measures = self._points.measures[point]
            self._points.places[key] = Place(self._results, point, measures)
        return self._points.places[key]


def _require_one_flow(first: Place, second: Place, names: Sequence[str]) -> None:
    velocities = first.velocity, second.velocity
    difference = abs(velocities[0].nominal_value - velocities[1].nominal_value)
    if difference > SIGMAS * (velocities[0].std_dev + velocities[1].std_dev):
        both = ", ".join(f"{name} ({first[name]} and {second[name]})" for name in names)
        speeds = " and ".join(
            f"{one.nominal_value:.3g} ± {SIGMAS * one.std_dev:.1g}" for one in velocities
        )
        raise Ambiguous(
            f"{first.id} and {second.id} differ in {both}, and in velocity ({speeds} m/s): the "
            "judge has to name which is meant"
        )


def _describe(where: Mapping[str, Any]) -> str:
    named = [f"{name} {value}" for name, value in where.items() if value is not ANY]
    return ", ".join(named) or "the paper's values"


def _pool_seeds(rows: pd.DataFrame, candidates: pd.DataFrame, settings: Sequence[str]) -> UFloat:
    """Return the boundary with the narrowest bracket of some candidates, and its interval.

    It is pooled with those of all ``rows``, which have finite ends, that agree in the settings. The
    seeds show how much starts differ; with a single seed the interval is infinite. It is never
    narrower than the bracket, each of its ends a bound of one side.
    """
    bracket = 0.5 * (rows["high"] - rows["low"]).astype(float)
    narrowest = rows.loc[bracket[candidates.index].idxmin()]
    starts = rows[(rows[settings] == narrowest[settings]).all(axis=1)]
    middle = 0.5 * (starts["low"] + starts["high"]).to_numpy(float)
    half_width = float(bracket[starts.index].mean() * student(np.inf) / student(np.inf, sides=1))
    scatter = float(student_half_width(middle)) if middle.size > 1 else inf
    return with_interval(float(middle.mean()), max(half_width, scatter))


#: Label of the defaults of all readings.
DEFAULT = "default"

#: The reading that is no parameter of runs: the grid on which the same profiles are evaluated.
GRID = "profile_grid"

#: What stands for the paper of a system that none is about.
NO_PAPER = Paper(name="", author="none", quote="none", system="", folder=Path(), package="")


def paper_of(system: str, paper: str = "") -> Paper:
    """Return a paper by name, for other claims the first one of their system, else `NO_PAPER`.

    The first one has no values of its own: these hold where the paper is named.
    """
    every = papers()
    if paper in every and system in (every[paper].system, *every[paper].defaults):
        return every[paper]
    of_system = (one for one in every.values() if one.system == system and not one.defaults)
    return next(of_system, NO_PAPER)


def readings_of(system: str, paper: str = "") -> Readings:
    """Return how a paper is read, none of them for a system without papers."""
    return paper_of(system, paper).readings


def reading_label(system: str, reading: Mapping[str, Any], readings: Readings) -> str:
    """Return one of the readings of a paper in words, ``default`` for the defaults."""
    words = [
        readings.grids[value] if name == GRID else setting(system, name, value)
        for name, value in reading.items()
    ]
    return "; ".join(words) or DEFAULT


def is_regridded(reading: Mapping[str, Any], headline: Mapping[str, Any]) -> bool:
    """True for runs of another reading than the headline one, evaluated on another grid."""
    return GRID in reading and reading != {**headline, GRID: reading[GRID]}


def combined_readings(results: Results, system: str, one: Paper) -> list[dict[str, Any]]:
    """Return the readings under which runs of a system can be judged.

    The headline reading is first, or the default where no run has it. What the paper's words allow
    together is judged together: the runs of each reading, evaluated on each grid of the profiles.
    """
    runs = [{}, *_readings_with_runs(results, system, one)]
    first = one.readings.headline if one.readings.headline in runs else {}
    ordered = [first, *(reading for reading in runs if reading != first)]
    grids = [{}, *({GRID: name} for name in one.readings.grids)]
    return [reading | grid for reading in ordered for grid in grids]


def model_readings(results: Results, system: str, one: Paper) -> Sequence[Mapping[str, Any]]:
    """Return the readings at which experiments on the model are made.

    The engine is compiled for each, which takes long: a study that has runs of none has the default
    alone.
    """
    names = {name for changes in one.readings.model for name in changes}
    has_runs = any(names & found.keys() for found in _readings_with_runs(results, system, one))
    return one.readings.model if has_runs else [{}]


def _readings_with_runs(results: Results, system: str, one: Paper) -> list[dict[str, Any]]:
    """Return the readings other than the paper's default that some points of a system have.

    Choices of the models come first, then base rows: flows of another cell, or another stiffness.
    """
    model = SYSTEMS[system]
    defaults = vars(model())
    points = results.dataset.isel(point=np.flatnonzero(results.dataset["system"] == system))
    names = roles.reading_parameters(model)
    readings = {}
    for values in zip(*(points[name].values.tolist() for name in names), strict=True):
        row = dict(zip(names, values, strict=True))
        usual = defaults | one.usual(system, row)
        unusual = {name: value for name, value in row.items() if value != usual[name]}
        readings[tuple(unusual.items())] = unusual
    readings.pop((), None)
    rows = ((name, value) for name, values in one.readings.rows.items() for value in values)
    return [
        *readings.values(),
        *({name: value} for name, value in rows if value in points[name].values),
    ]
