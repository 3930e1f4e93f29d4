"""The runs of a study, each read once: from an earlier or adopted dataset, or its run file."""

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path

import numpy as np

from sim.base.damage import checked_read
from sim.dataset.adopted import AdoptedPoints
from sim.dataset.earlier import adopted_rows, earlier_rows
from sim.dataset.gather import amounts_text
from sim.dataset.rows import OF_PROFILES, Rows, select_rows
from sim.dataset.side_by_side import read_files
from sim.parameters import Parameters, amounts
from sim.study.figure_spec import Shown


class Runs:
    """Rows of runs by point.

    Parameters
    ----------
    folder : Path
        Results of the study: its runs, and its earlier dataset if there is one.
    particle_need : callable
        Returns how much figures need of the particles of a point, by its id.
    adopted : AdoptedPoints
        The points that are in adopted datasets.
    processes : int
        Number of processes that read run files in parallel.
    scheduler : str, optional
        Address of a dask scheduler whose workers read them instead.
    """

    def __init__(
        self,
        folder: Path,
        particle_need: Callable[[str], Shown],
        adopted: AdoptedPoints,
        processes: int = 1,
        scheduler: str | None = None,
    ):
        self._folder, self._particle_need = folder / "runs", particle_need
        self._adopted = adopted
        self._processes, self._scheduler = processes, scheduler
        self._blocks: list[Rows] = []
        self._rows: dict[str, tuple[Rows, int]] = {}
        self._add(earlier_rows(folder, particle_need))

    def _add(self, blocks: Iterable[Rows]) -> None:
        for block in blocks:
            self._blocks.append(block)
            self._rows |= {point: (block, row) for row, point in enumerate(block.points)}

    def read(self, points: Mapping[str, Parameters]) -> None:
        """Read the runs of points that have not been read yet, or were read with other amounts.

        Raises
        ------
        InputError
            When a run file is missing or damaged, see `read_files`.
        """
        amounts_by_point = {point: amounts(parameters) for point, parameters in points.items()}
        new = {
            point: point_amounts
            for point, point_amounts in amounts_by_point.items()
            if not self._is_read(point, point_amounts)
        }
        if self._rows.keys() & new:
            blocks = select_rows(self._blocks, self._rows.keys() - new)
            self._blocks, self._rows = [], {}
            self._add(blocks)
        sources = {point: self._adopted.source(point, points[point]) for point in new}
        for dataset in sorted({source.dataset for source in sources.values() if source}):
            members = {
                point: new[point]
                for point, source in sources.items()
                if source and source.dataset == dataset
            }
            with checked_read(dataset, "dataset that was adopted", replaceable=True):
                self._add(adopted_rows(dataset, members, self._particle_need))
        files = [
            (self._folder / f"{point}.nc", point_amounts, bool(self._particle_need(point)))
            for point, point_amounts in new.items()
            if not sources[point]
        ]
        self._add(read_files(files, self._processes, self._scheduler))

    def _is_read(self, point: str, point_amounts: Mapping[str, float]) -> bool:
        if point not in self._rows:
            return False
        block, row = self._rows[point]
        return block.origin["wanted"][row] == amounts_text(point_amounts)

    def scalars(self, point: str) -> dict[str, np.ndarray]:
        """Return the scalars of a run that has been read; replicates beyond its own are empty."""
        block, row = self._rows[point]
        arrays = block.values.items()
        return {name: array[row] for name, array in arrays if name not in OF_PROFILES}

    def rows(self, points: Collection[str]) -> list[Rows]:
        """Return the rows of points that have been read."""
        return select_rows(self._blocks, points)
