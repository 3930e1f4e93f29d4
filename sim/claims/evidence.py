"""What judges ask for: places of a study under one protocol and one reading, with intervals."""

from collections import Counter
from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.claims.place import Place, measured
from sim.claims.points import Points, Rows
from sim.claims.starts import over_seeds
from sim.claims.verdict import Unbounded, Untestable
from sim.dataset.results import Results
from sim.parameters import SYSTEMS


class Evidence:
    """All places of one protocol and one reading.

    Parameters
    ----------
    results : Results
        The study.
    protocol : str
        ``published`` or ``converged``.
    reading : mapping, optional
        Parameters that tell readings apart (`sim.parameters.roles.readings`) and differ from their
        defaults.
    points : Points, optional
        Those of the study, where they are known already.
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
        self._places: dict[str, Place] = {}

    def without(self, name: str) -> "Evidence":
        """Return what the same protocol offers under a reading that leaves one parameter usual."""
        if name not in self.reading:
            return self
        reading = {key: value for key, value in self.reading.items() if key != name}
        return Evidence(self._results, self.protocol, reading, self._points)

    def under(self, **reading: Any) -> "Evidence":
        """Return what the same protocol offers with these parameters besides its own reading."""
        return Evidence(self._results, self.protocol, self.reading | reading, self._points)

    def at(self, system: str, **where: Any) -> Place:
        """Return the place with these parameters, all others at the paper's values.

        Numerical settings (`sim.parameters.roles.numerical`) that are not named may have any value:
        defaults come first, then more replicates, then longer runs. Raises `Untestable` when there
        is no such place, or none of its replicates completed.
        """
        found = self._rows(system, where)
        if not found.size:
            at = f"{_text(where)}, all else as in the paper"
            raise Untestable(f"no {self.protocol} run of the {system} at {at}")
        return self._place(self._points.richest(system, found, where))

    def line(self, system: str, along: str, **where: Any) -> dict[float, Place]:
        """Return the places along a parameter in its order, all others as for `at`.

        Empty where there are none.
        """
        found = self._rows(system, where, free=along)
        values = self._points.columns[along][found]
        return {
            value: self._place(self._points.richest(system, found[values == value], where))
            for value in sorted(set(values.tolist()))
        }

    def has_runs(self, system: str) -> bool:
        """Return whether the study has any point of the system under the protocol."""
        held = self._results.dataset
        return bool(((held["system"] == system) & (held["protocol"] == self.protocol)).any())

    def unsteady(self, points: Iterable[str]) -> str:
        """Say how many of some points are not steady, and what instead; empty where all are."""
        found = Counter(self._place(point).regime for point in points)
        others = [f"{count} {regime}" for regime, count in found.items() if regime != "steady"]
        if not others:
            return ""
        count = found.total() - found["steady"]
        verb = "is" if count == 1 else "are"
        return f"{count} of {found.total()} points {verb} not steady: {', '.join(others)}"

    def boundary(
        self,
        system: str,
        of: str,
        along: str,
        *,
        seeds: bool = False,
        any_protocol: bool = False,
        **where: Any,
    ) -> UFloat:
        """Return a boundary found by refinement; its interval is the bracket.

        Boundaries that differ in nothing but the seed are joined, see `sim.claims.starts`. With
        ``seeds`` the interval is endless where none of the kind was looked for from two seeds. With
        ``any_protocol`` it may be one of the other protocol.
        Raises `Untestable` when the study looks for no such boundary, and `Unbounded` when it does
        but one seed at least has none: without those beyond the range the others would agree too
        well.
        """
        rows = self._bounds(system, of, along, any_protocol)
        chosen = self._chosen(rows, system, of, along, where)
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

    def brackets(self, system: str, of: str, along: str, **where: Any) -> pd.DataFrame:
        """Return ``low`` and ``high`` of a boundary, a row per ``seed``, unknown ends as NaN.

        Raises `Untestable` when the study looks for no such boundary.
        """
        rows = self._bounds(system, of, along, any_protocol=False)
        chosen = self._chosen(rows, system, of, along, where)
        return chosen.set_index("seed")[["low", "high"]].astype(float)

    def _bounds(self, system: str, of: str, along: str, any_protocol: bool) -> pd.DataFrame:
        """Return all boundaries of a kind."""
        rows = self._results.boundaries
        if not len(rows):
            return rows
        same = (rows["system"] == system) & (rows["of"] == of) & (rows["along"] == along)
        return rows[same & (any_protocol | (rows["protocol"] == self.protocol))]

    def _chosen(
        self, rows: pd.DataFrame, system: str, of: str, along: str, where: Mapping[str, Any]
    ) -> pd.DataFrame:
        """Return those of some boundaries that are at a place; raise `Untestable` without any."""
        if len(rows):
            # A boundary of the other protocol is at that place of its own.
            wanted = self._wanted({"protocol": rows["protocol"].iloc[0]} | dict(where))
            columns = {name: values.to_numpy() for name, values in rows.items()}
            rows = rows.iloc[Rows(columns).matching(system, wanted, along)]
        if rows.empty:
            raise Untestable(f"no boundary of {of} along {along} at {_text(where)}")
        return rows

    def _rows(self, system: str, where: Mapping[str, Any], free: str = "") -> np.ndarray:
        return self._points.matching(system, self._wanted(where), free)

    def _wanted(self, where: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of parameters that are asked for; of all others the paper's count."""
        return {"protocol": self.protocol} | self.reading | dict(where)

    def _place(self, point: str) -> Place:
        if point not in self._places:
            self._places[point] = Place(self._results, point)
        return self._places[point]


def _text(where: Mapping[str, Any]) -> str:
    """Write parameters for a message: ``frequency 20, amplitude 1``."""
    return ", ".join(f"{name} {value}" for name, value in where.items()) or "the paper's values"
