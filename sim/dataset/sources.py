"""Gather the rows of a study from datasets and run files, which several processes may read."""

import os
import signal
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.errors import InputError
from sim.base.plugins import load, places
from sim.dataset.adopted import AdoptedPoints
from sim.dataset.earlier import earlier_rows
from sim.dataset.gather import read_run
from sim.dataset.rows import Rows, merge_rows, reader_hash, row_points
from sim.parameters import amounts
from sim.study.model import Point, Study

#: Most run files that are read before their rows are handed over.
BATCH = 40

#: Fewest files for which processes are started. Dask and two forks cost as much time as ten files,
#: and halve the time of reading.
MIN_FILES = 40

#: Seconds within which a dask scheduler answers.
SCHEDULER_TIMEOUT = 10

_READ_LOCK = threading.Lock()

#: A run file, the amounts to read, and whether to read the state of its particles.
File = tuple[Path, Mapping[str, float], bool]


class Batch(NamedTuple):
    """Rows of run files, and the errors of those that could not be read."""

    blocks: list[Rows]
    problems: list[str]


def gather_rows(
    study: Study,
    folder: Path,
    points: Mapping[str, Point],
    processes: int = 1,
    scheduler: str | None = None,
) -> list[Rows]:
    """Return the rows of points of a study, each from the first source that has it.

    These are the earlier dataset, adopted datasets, and run files.

    Parameters
    ----------
    study : Study
        The study, which says how much its figures need of particles.
    folder : Path
        Its results.
    points : mapping
        The points by id, with the amounts to read.
    processes, scheduler
        See `read_files`.

    Raises
    ------
    InputError
        When an adopted dataset is damaged, or run files are missing or damaged, see `read_files`.
    """
    need, blocks = study.particles_needed, []
    missing = {key: point.parameters for key, point in points.items()}
    for source in (partial(earlier_rows, folder, need), AdoptedPoints(study, folder).rows):
        blocks += source(missing)
        stored = set(row_points(blocks))
        missing = {key: point for key, point in missing.items() if key not in stored}
    files = [
        (folder / "runs" / f"{key}.nc", amounts(point), bool(need(key)))
        for key, point in missing.items()
    ]
    return blocks + read_files(files, processes, scheduler)


def read_files(
    files: Sequence[File], processes: int = 1, scheduler: str | None = None
) -> list[Rows]:
    """Read the rows of run files.

    Parameters
    ----------
    files : sequence of (Path, mapping, bool)
        The files, the amounts of each, and whether to read the state of its particles.
    processes : int
        Number of processes that read in parallel, where there are files enough.
    scheduler : str, optional
        Address of a dask scheduler whose workers read them instead; they must see the same folders.

    Raises
    ------
    InputError
        When files are missing or damaged; the message names the first. All damaged files are set
        aside.
    """
    batches = list(_batches(files, processes, scheduler))
    if problems := [problem for batch in batches for problem in batch.problems]:
        raise InputError.of_several(problems)
    return [block for batch in batches for block in batch.blocks]


def _batches(files: Sequence[File], processes: int, scheduler: str | None) -> Iterable[Batch]:
    """Read the files in batches: in this process, in forks of it, or by a cluster."""
    size = max(1, min(BATCH, -(-len(files) // max(1, processes))))
    parts = [files[first : first + size] for first in range(0, len(files), size)]
    if files and scheduler is not None:
        with _dask_cluster(scheduler) as options:
            absolute = [[(file[0].absolute(), file[1], file[2]) for file in part] for part in parts]
            return _compute(absolute, options)
    if processes > 1 and len(files) >= MIN_FILES:
        with _process_pool(min(processes, len(parts))) as options:
            return _compute(parts, options)
    return map(read_batch, parts)


def _compute(parts: Sequence[Sequence[File]], options: Mapping[str, Any]) -> Sequence[Batch]:
    """Read batches of files with dask, whose scheduler ``options`` select."""
    import dask

    return dask.compute(*(dask.delayed(read_batch, pure=False)(part) for part in parts), **options)


def read_batch(files: Sequence[File]) -> Batch:
    """Read some run files; a damaged one does not keep the others from being read."""
    rows, problems = [], []
    # A worker of a cluster may have several threads, and HDF5 is not thread-safe.
    with _READ_LOCK:
        for path, wanted, has_state in files:
            try:
                rows.append(read_run(path, wanted, has_state))
            except InputError as error:
                problems.append(str(error))
    return Batch(merge_rows(rows), problems)


@contextmanager
def _process_pool(count: int) -> Iterator[dict[str, Any]]:
    """Yield options for dask with forks of this process, which have all libraries loaded."""
    with ProcessPoolExecutor(count, get_context("fork"), initializer=_follow_parent) as pool:
        yield {"scheduler": "processes", "pool": pool, "chunksize": 1}


@contextmanager
def _dask_cluster(address: str) -> Iterator[dict[str, Any]]:
    """Yield options for dask with the cluster of the user."""
    key = "--dask-scheduler"
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError(f"{key}: needs the package distributed: pip install distributed") from None
    try:
        get_address_host_port(address, strict=True)
        client = Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        allowed = f"the address of a dask scheduler that answers ({error})"
        raise InputError.of_value(key, "", address, allowed) from None
    with client:
        client.run(load, places(), Path(), "plugins")
        hashes = client.run(reader_hash, on_error="return").values()
        if others := {str(value) for value in hashes} - {reader_hash()}:
            raise InputError(f"{key}: its workers do not have this program: {others.pop()}")
        yield {"scheduler": client}


def _follow_parent() -> None:
    """Leave interrupts to the parent of this process, and end when the parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    assert parent is not None

    def end_with_parent() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
