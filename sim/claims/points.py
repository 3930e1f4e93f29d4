"""Selection of the points of a study, or of its boundaries, by their parameters."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from sim.base.additions import plain_name
from sim.claims.place import Place
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, default_of
from sim.parameters.laws import LAW
from sim.parameters.motions import MOTION
from sim.parameters.roles import amount_parameters, numerical_parameters, start_parameters

#: Stands for the paper's value of a setting, which may follow from other parameters.
USUAL = object()

#: Value of a numerical setting that a judge names to say that runs may differ in it.
ANY = object()

#: The `start_parameters` that a row has, those that are named left out.
Start = tuple[object, ...]


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
        free_names = {free} | {name for name, value in conditions.items() if value is ANY}
        for name in (names | conditions.keys()) - free_names:
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
        free = [
            self._has_default(system, name)
            for name in start_parameters(SYSTEMS[system])
            if where.get(name) is ANY
        ]

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
        names = [name for name in start_parameters(SYSTEMS[system]) if name not in named]
        return set(
            product(
                *(
                    (self.columns[name][row], *[USUAL] * bool(self._has_default(system, name)[row]))
                    for name in names
                )
            )
        )

    def differences(self, system: str, first: int, second: int) -> list[str]:
        """Return the parameters, other than amounts, in which two rows differ."""
        model = SYSTEMS[system]
        return [
            name
            for name in model.model_fields
            if name not in amount_parameters(model)
            and self.columns[name][first] != self.columns[name][second]
        ]
