"""Selection of the points of a study, or of its boundaries, by their parameters."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from sim.base.additions import plain_name
from sim.claims.place import Place
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, default_of
from sim.parameters.laws import LAW
from sim.parameters.motions import MOTION
from sim.parameters.roles import numerical_parameters, start_parameters


class Rows:
    """Rows of parameters: of the points of a study, or of its boundaries.

    A judge looks up places a thousand times, so comparisons with the defaults are cached.

    Parameters
    ----------
    columns : mapping
        Arrays over the rows: ``system``, and every parameter.
    """

    def __init__(self, columns: Mapping[str, np.ndarray]):
        self.columns = columns
        self._default_masks: dict[tuple[str, str], np.ndarray] = {}

    def matching(self, system: str, conditions: Mapping[str, Any], free: str = "") -> np.ndarray:
        """Return the numbers of the rows with the given values, and the paper's of all others.

        Numerical settings (`sim.parameters.roles.numerical_parameters`) without a given value may
        have any value, and so may the parameter ``free``.
        """
        names = (
            set(SYSTEMS[system].model_fields)
            - numerical_parameters(SYSTEMS[system])
            - {"system", free}
        )
        is_match = self.columns["system"] == system
        for name in names | (conditions.keys() - {free}):
            if name in conditions:
                is_match = is_match & self._has_value(name, conditions[name])
            else:
                is_match = is_match & self._has_default(system, name)
        return np.flatnonzero(is_match)

    def _has_value(self, name: str, value: Any) -> np.ndarray:
        """True per row with a value; a choice of a plug-in is compared by name, without hash."""
        values = self.columns[name]
        if name in (LAW.name, MOTION.name):
            return np.array([value in (entry, plain_name(entry)) for entry in values], bool)
        return values == value

    def count_unusual_starts(
        self, system: str, rows: np.ndarray, where: Mapping[str, Any]
    ) -> np.ndarray:
        """Return how many settings of the start differ from the paper's, per row."""
        names = set(start_parameters(SYSTEMS[system])) - set(where)
        return sum(
            (~self._has_default(system, name)[rows] for name in names), np.zeros(len(rows), int)
        )

    def _has_default(self, system: str, name: str) -> np.ndarray:
        """True per row with the paper's value, which may follow from other parameters."""
        if (system, name) not in self._default_masks:
            mask = np.zeros(len(self.columns["system"]), bool)
            for number, row in self._rows_of(system):
                mask[number] = row[name] == default_of(SYSTEMS[system], name, row)
            self._default_masks[system, name] = mask
        return self._default_masks[system, name]

    def _rows_of(self, system: str) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield number and parameters of each row of a system."""
        names = SYSTEMS[system].model_fields
        for number in np.flatnonzero(self.columns["system"] == system):
            yield int(number), {name: self.columns[name][number] for name in names}


class Points(Rows):
    """The points of a study with a completed replicate.

    ``places`` holds those already looked up, by profile grid and point: readings share them.
    """

    def __init__(self, results: Results):
        variables = results.dataset.variables
        self._completed = (variables["status"].values == "completed").sum(axis=1)
        self._indices = np.flatnonzero(self._completed)
        super().__init__(
            {
                str(name): values.values[self._indices]
                for name, values in results.dataset.coords.variables.items()
                if values.dims == ("point",)
            }
        )
        self._steps = np.nansum(variables["steps"].values, axis=1)[self._indices]
        self._completed = self._completed[self._indices]
        self.places: dict[tuple[str, str], Place] = {}

    def select_richest(self, system: str, rows: np.ndarray, where: Mapping[str, Any]) -> str:
        """Return the point with the fewest unusual starts, most replicates and longest runs."""
        unusual_starts = self.count_unusual_starts(system, rows, where)
        order = np.lexsort((-self._steps[rows], -self._completed[rows], unusual_starts))
        return str(self.columns["point"][rows[order[0]]])
