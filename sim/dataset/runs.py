"""The runs of a study, each read once: from an earlier or adopted dataset or from its file."""

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path

import numpy as np

from sim.base.damage import checked_read
from sim.dataset.adopted import Adopted
from sim.dataset.earlier import adopted_rows, earlier_rows
from sim.dataset.gather import as_text
from sim.dataset.rows import OF_PROFILES, Rows, selected
from sim.dataset.side_by_side import read_files
from sim.parameters import Parameters, amounts
from sim.study.catalogue import Shown


class Runs:
    """Rows of runs by point.

    Parameters
    ----------
    folder : Path
        Results of the study: its runs, and its earlier dataset if there is one.
    shown : callable
        Tells what figures show of the particles of a point.
    adopted : Adopted
        Tells which points are taken from adopted datasets.
    processes : int
        How many read run files side by side.
    scheduler : str, optional
        Address of the dask scheduler whose workers read them instead.
    """

    def __init__(
        self,
        folder: Path,
        shown: Callable[[str], Shown],
        adopted: Adopted,
        processes: int = 1,
        scheduler: str | None = None,
    ):
        self._folder, self._shown, self._adopted = folder / "runs", shown, adopted
        self._processes, self._scheduler = processes, scheduler
        self._blocks: list[Rows] = []
        self._places: dict[str, tuple[Rows, int]] = {}
        self._add(earlier_rows(folder, shown))

    def _add(self, blocks: Iterable[Rows]) -> None:
        for block in blocks:
            self._blocks.append(block)
            self._places |= {point: (block, row) for row, point in enumerate(block.points)}

    def read(self, points: Mapping[str, Parameters]) -> None:
        """Read the runs of points that are not known yet, or of which other amounts are.

        Raises
        ------
        InputError
            When a run file is missing or damaged, see `read_files`.
        """
        wanted = {point: amounts(parameters) for point, parameters in points.items()}
        new = {point: much for point, much in wanted.items() if not self._is_known(point, much)}
        if self._places.keys() & new:
            known = selected(self._blocks, self._places.keys() - new)
            self._blocks, self._places = [], {}
            self._add(known)
        sources = {point: self._adopted.source(point, points[point]) for point in new}
        for dataset in sorted({held.dataset for held in sources.values() if held}):
            mine = {
                point: new[point]
                for point, held in sources.items()
                if held and held.dataset == dataset
            }
            with checked_read(dataset, "dataset that was adopted", replaceable=True):
                self._add(adopted_rows(dataset, mine, self._shown))
        files = [
            (self._folder / f"{point}.nc", much, bool(self._shown(point)))
            for point, much in new.items()
            if not sources[point]
        ]
        self._add(read_files(files, self._processes, self._scheduler))

    def _is_known(self, point: str, wanted: Mapping[str, float]) -> bool:
        if point not in self._places:
            return False
        block, row = self._places[point]
        return block.origin["wanted"][row] == as_text(wanted)

    def scalars(self, point: str) -> dict[str, np.ndarray]:
        """Return the scalars of a run that was read; replicates that it has not are empty."""
        block, row = self._places[point]
        values = block.values.items()
        return {name: held[row] for name, held in values if name not in OF_PROFILES}

    def rows(self, points: Collection[str]) -> list[Rows]:
        """Return the rows of points that were read."""
        return selected(self._blocks, points)
