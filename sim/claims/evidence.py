"""What judges ask for: places of a study under one protocol and one reading, with intervals."""

from collections.abc import Mapping
from functools import cached_property
from math import inf
from typing import Any

import pandas as pd
from uncertainties import UFloat

from sim.claims.place import Place, measured
from sim.claims.starts import over_seeds
from sim.claims.verdict import Unbounded, Untestable
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, Parameters, default_of
from sim.parameters.roles import changing_start, numerical


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
    """

    def __init__(self, results: Results, protocol: str, reading: Mapping[str, Any] | None = None):
        self.protocol = protocol
        self.reading = dict(reading or {})
        self._results = results
        self._places: dict[str, Place] = {}

    def at(self, system: str, **where: Any) -> Place:
        """Return the place with these parameters, all others at the paper's values.

        Numerical settings (`sim.parameters.roles.numerical`) that are not named may have any value:
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
        rows = self._results.boundaries
        if len(rows):
            same = (rows["system"] == system) & (rows["of"] == of) & (rows["along"] == along)
            rows = rows[same & (any_protocol | (rows["protocol"] == self.protocol))]
        if any_protocol and len(rows):
            where = {"protocol": rows["protocol"].iloc[0]} | where
        chosen = self._matching(rows, system, where, along) if len(rows) else rows
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
        return self._matching(rows, system, where, free)

    def _matching(
        self, rows: pd.DataFrame, system: str, where: Mapping[str, Any], free: str
    ) -> pd.DataFrame:
        """Return the rows that have the parameters named, and the paper's values of the others."""
        usual, following = _usual(SYSTEMS[system])
        wanted = usual | {"protocol": self.protocol} | self.reading | dict(where)
        matching = pd.Series(True, index=rows.index)
        for name in wanted.keys() - {free}:
            matching &= rows[name] == wanted[name]
        found = rows[matching]
        for name in following - {*wanted, free}:
            found = found[found[name] == _defaults(SYSTEMS[system], name, found)]
        return found

    def _richest(self, system: str, rows: pd.DataFrame, where: Mapping[str, Any]) -> str:
        """Return the point with the fewest unusual settings, most replicates and longest runs."""
        unusual = pd.Series(0, index=rows.index)
        model = SYSTEMS[system]
        for name in set(changing_start(model)) - set(where):
            unusual += (rows[name] != _defaults(model, name, rows)).astype(int)
        ranked = rows.assign(unusual=unusual).sort_values(
            ["unusual", "completed", "steps"], ascending=[True, False, False]
        )
        return ranked["point"].iloc[0]

    def _place(self, point: str) -> Place:
        if point not in self._places:
            self._places[point] = Place(self._results, point)
        return self._places[point]


def _text(where: Mapping[str, Any]) -> str:
    """Write parameters for a message: ``frequency 20, amplitude 1``."""
    return ", ".join(f"{name} {value}" for name, value in where.items()) or "the paper's values"


def _usual(model: type[Parameters]) -> tuple[dict[str, Any], set[str]]:
    """Return the paper's values of what sets which flow a point is, and names of what follows."""
    names = set(model.model_fields) - numerical(model) - {"system"}
    following = {name for name in names if model.model_fields[name].default_factory}
    paper = model()
    return {name: getattr(paper, name) for name in names - following}, following


def _defaults(model: type[Parameters], name: str, rows: pd.DataFrame) -> list[Any]:
    """Return the paper's value of a parameter at each row, as it may follow from others there."""
    return [default_of(model, name, row) for row in rows.to_dict("records")]
