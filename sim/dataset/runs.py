"""The rows of the runs of a study, each read once, from the first source that has it."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from sim.dataset.gather import amounts_text
from sim.dataset.rows import OF_PROFILES, Rows, row_points, select_rows
from sim.parameters import Parameters, amounts


class Source(Protocol):
    """Where rows of runs come from: the earlier dataset, adopted datasets, or run files."""

    def rows(self, points: Mapping[str, Parameters]) -> list[Rows]:
        """Return the rows that this has of some points, by id, each with the amounts of its point.

        Raises
        ------
        InputError
            When a file that has to be read is missing or damaged.
        """
        ...


class Runs:
    """Rows of runs by point.

    Parameters
    ----------
    sources : sequence of Source
        The sources, in the order in which they are asked; the last one has all points.
    """

    def __init__(self, sources: Sequence[Source]):
        self._sources = sources
        self._blocks: list[Rows] = []
        self._rows: dict[str, tuple[Rows, int]] = {}

    def _add(self, blocks: Iterable[Rows]) -> None:
        for block in blocks:
            self._blocks.append(block)
            self._rows |= {point: (block, row) for row, point in enumerate(block.points)}

    def read(self, points: Mapping[str, Parameters]) -> None:
        """Read the runs of points that have not been read yet, or were read with other amounts.

        Raises
        ------
        InputError
            When a run file or an adopted dataset is missing or damaged, see `Source`.
        """
        new = {point: value for point, value in points.items() if not self._is_read(point, value)}
        if self._rows.keys() & new:
            blocks = select_rows(self._blocks, self._rows.keys() - new)
            self._blocks, self._rows = [], {}
            self._add(blocks)
        for source in self._sources:
            blocks = source.rows(new)
            self._add(blocks)
            read = set(row_points(blocks))
            new = {point: value for point, value in new.items() if point not in read}

    def _is_read(self, point: str, parameters: Parameters) -> bool:
        if point not in self._rows:
            return False
        block, row = self._rows[point]
        return block.origin["wanted"][row] == amounts_text(amounts(parameters))

    def scalars(self, point: str) -> dict[str, np.ndarray]:
        """Return the scalars of a run that has been read; replicates beyond its own are empty."""
        block, row = self._rows[point]
        arrays = block.values.items()
        return {name: array[row] for name, array in arrays if name not in OF_PROFILES}

    def rows(self, points: Collection[str]) -> list[Rows]:
        """Return the rows of points that have been read."""
        return select_rows(self._blocks, points)
