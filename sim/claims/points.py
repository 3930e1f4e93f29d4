"""Which points of a study, or which of its boundaries, are where a judge looks."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from sim.dataset.results import Results
from sim.parameters import SYSTEMS, default_of
from sim.parameters.choices import named
from sim.parameters.laws import LAW
from sim.parameters.motions import MOTION
from sim.parameters.roles import changing_start, numerical


class Rows:
    """Rows of parameters: of the points of a study, or of its boundaries.

    A judge asks for a place a thousand times, so what a row has of its own is found out once.

    Parameters
    ----------
    columns : mapping
        Arrays over the rows: ``system``, and every parameter.
    """

    def __init__(self, columns: Mapping[str, np.ndarray]):
        self.columns = columns
        self._usual: dict[tuple[str, str], np.ndarray] = {}

    def matching(self, system: str, wanted: Mapping[str, Any], free: str = "") -> np.ndarray:
        """Return the numbers of the rows with the values wanted and the paper's of all others.

        Numerical settings (`sim.parameters.roles.numerical`) that are not wanted may have any
        value, and so may the parameter that is ``free``.
        """
        names = set(SYSTEMS[system].model_fields) - numerical(SYSTEMS[system]) - {"system", free}
        found = self.columns["system"] == system
        for name in names | (wanted.keys() - {free}):
            if name in wanted:
                found = found & self._has(name, wanted[name])
            else:
                found = found & self._is_usual(system, name)
        return np.flatnonzero(found)

    def _has(self, name: str, value: Any) -> np.ndarray:
        """Return whether each row has a value; that of a plug-in goes by its name without hash."""
        values = self.columns[name]
        if name in (LAW.name, MOTION.name):
            return np.array([value in (one, named(one)) for one in values], bool)
        return values == value

    def unusual_starts(self, system: str, rows: np.ndarray, where: Mapping[str, Any]) -> np.ndarray:
        """Return how many settings of the start of some rows differ from the paper's."""
        names = set(changing_start(SYSTEMS[system])) - set(where)
        return sum(
            (~self._is_usual(system, name)[rows] for name in names), np.zeros(len(rows), int)
        )

    def _is_usual(self, system: str, name: str) -> np.ndarray:
        """Return whether each row has the paper's value, which may follow from others there."""
        if (system, name) not in self._usual:
            usual = np.zeros(len(self.columns["system"]), bool)
            for number, row in self._of_system(system):
                usual[number] = row[name] == default_of(SYSTEMS[system], name, row)
            self._usual[system, name] = usual
        return self._usual[system, name]

    def _of_system(self, system: str) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield the rows of a system by their numbers."""
        names = SYSTEMS[system].model_fields
        for number in np.flatnonzero(self.columns["system"] == system):
            yield int(number), {name: self.columns[name][number] for name in names}


class Points(Rows):
    """The points of a study with a completed replicate."""

    def __init__(self, results: Results):
        held = results.dataset.variables
        self._completed = (held["status"].values == "completed").sum(axis=1)
        self._chosen = np.flatnonzero(self._completed)
        super().__init__(
            {
                str(name): values.values[self._chosen]
                for name, values in results.dataset.coords.variables.items()
                if values.dims == ("point",)
            }
        )
        self._steps = np.nansum(held["steps"].values, axis=1)[self._chosen]
        self._completed = self._completed[self._chosen]

    def richest(self, system: str, rows: np.ndarray, where: Mapping[str, Any]) -> str:
        """Return the point with the fewest unusual starts, most replicates and longest runs."""
        unusual = self.unusual_starts(system, rows, where)
        order = np.lexsort((-self._steps[rows], -self._completed[rows], unusual))
        return str(self.columns["point"][rows[order[0]]])
