"""Run files read side by side: by processes of this machine, or by the workers of a cluster."""

import os
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.errors import InputError
from sim.dataset.gather import read_run
from sim.dataset.rows import Rows, joined

#: Run files that are read before what they hold is handed over.
BATCH = 40

#: Fewest files for which it is worth while to start processes.
FEW = 60

#: Seconds within which a dask scheduler answers.
PATIENCE = 10

#: A run file, and whether the state of its particles is kept.
File = tuple[Path, bool]


class Batch(NamedTuple):
    """What some files hold, and what is wrong with the others."""

    blocks: list[Rows]
    problems: list[str]


def read_files(
    files: Sequence[File], processes: int = 1, scheduler: str | None = None
) -> list[Rows]:
    """Read what a dataset keeps of run files.

    Parameters
    ----------
    files : sequence of (Path, bool)
        The files, and whether the state of the particles of each is kept.
    processes : int
        How many read side by side, where there are files enough.
    scheduler : str, optional
        Address of a dask scheduler whose workers read them instead; they see the same folders.

    Raises
    ------
    InputError
        When a file is missing or damaged, naming the first. All damaged ones are set aside.
    """
    batches: Iterable[Batch]
    parts = [files[first : first + BATCH] for first in range(0, len(files), BATCH)]
    if scheduler is not None:
        with _cluster(scheduler) as how:
            batches = _computed([[(path.absolute(), s) for path, s in part] for part in parts], how)
    elif processes > 1 and len(files) >= FEW:
        with _processes(min(processes, len(parts))) as how:
            batches = _computed(parts, how)
    else:
        batches = map(read_batch, parts)
    return _blocks(batches)


def read_batch(files: Sequence[File]) -> Batch:
    """Read some run files, all of them before a damaged one is reported."""
    found, problems = [], []
    for path, shown in files:
        try:
            found.append(read_run(path, shown))
        except InputError as error:
            problems.append(str(error))
    return Batch(joined(found), problems)


def _blocks(batches: Iterable[Batch]) -> list[Rows]:
    """Return the rows of all batches; raise if anything is wrong with a file."""
    blocks, problems = [], []
    for batch in batches:
        blocks += batch.blocks
        problems += batch.problems
    if problems:
        others = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise InputError(f"{problems[0]}{others}")
    return blocks


def _computed(parts: Sequence[Sequence[File]], how: dict[str, Any]) -> Sequence[Batch]:
    """Read batches of files with dask."""
    import dask

    return dask.compute(*(dask.delayed(read_batch, pure=False)(part) for part in parts), **how)


@contextmanager
def _processes(count: int) -> Iterator[dict[str, Any]]:
    """Give dask processes of this machine: HDF5 is not safe in threads.

    They are forks, which have all libraries at once.
    """
    with ProcessPoolExecutor(count, get_context("fork"), initializer=_start) as pool:
        yield {"scheduler": "processes", "pool": pool, "chunksize": 1}


@contextmanager
def _cluster(address: str) -> Iterator[dict[str, Any]]:
    """Give dask the cluster that a user runs."""
    key = "--dask-scheduler"
    try:
        from distributed import Client

        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except ImportError:
        raise InputError(f"{key}: needs the package distributed: pip install distributed") from None
    except (OSError, ValueError) as error:
        allowed = f"the address of a dask scheduler that answers ({error})"
        raise InputError.of_value(key, "", address, allowed) from None
    with client:
        yield {"scheduler": client}


def _start() -> None:
    """Leave interrupts to the parent of this process, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    assert parent is not None

    def follow() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
