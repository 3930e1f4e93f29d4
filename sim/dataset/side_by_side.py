"""Run files read side by side: by processes of this machine, or by the workers of a cluster."""

import os
import signal
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.errors import InputError
from sim.base.plugins import load, places
from sim.dataset.earlier import reading_code
from sim.dataset.gather import read_run
from sim.dataset.rows import Rows, merged

#: Most run files that are read before what they hold is handed over.
BATCH = 40

#: Fewest files for which processes are started: dask and two forks cost as much as ten files, and
#: save half of the time.
FEW = 40

#: Seconds within which a dask scheduler answers.
PATIENCE = 10

_ALONE = threading.Lock()

#: A run file, how much is wanted of its point, and whether the state of its particles is kept.
File = tuple[Path, Mapping[str, float], bool]


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
    files : sequence of (Path, mapping, bool)
        The files, how much is wanted of each point, and whether the state of its particles is kept.
    processes : int
        How many read side by side, where there are files enough.
    scheduler : str, optional
        Address of a dask scheduler whose workers read them instead; they see the same folders.

    Raises
    ------
    InputError
        When a file is missing or damaged, naming the first. All damaged ones are set aside.
    """
    batches = list(_batches(files, processes, scheduler))
    if problems := [problem for batch in batches for problem in batch.problems]:
        others = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise InputError(f"{problems[0]}{others}")
    return [block for batch in batches for block in batch.blocks]


def _batches(files: Sequence[File], processes: int, scheduler: str | None) -> Iterable[Batch]:
    """Read the files in batches, in this process, in forks of it or by a cluster."""
    size = max(1, min(BATCH, -(-len(files) // max(1, processes))))
    parts = [files[first : first + size] for first in range(0, len(files), size)]
    if files and scheduler is not None:
        with _cluster(scheduler) as how:
            there = [[(file[0].absolute(), file[1], file[2]) for file in part] for part in parts]
            return _computed(there, how)
    if processes > 1 and len(files) >= FEW:
        with _processes(min(processes, len(parts))) as how:
            return _computed(parts, how)
    return map(read_batch, parts)


def _computed(parts: Sequence[Sequence[File]], how: Mapping[str, Any]) -> Sequence[Batch]:
    """Read batches of files with dask."""
    import dask

    return dask.compute(*(dask.delayed(read_batch, pure=False)(part) for part in parts), **how)


def read_batch(files: Sequence[File]) -> Batch:
    """Read some run files, all of them before a damaged one is reported."""
    found, problems = [], []
    # A worker of a cluster may have several threads, and HDF5 is not safe in them.
    with _ALONE:
        for path, wanted, shown in files:
            try:
                found.append(read_run(path, wanted, shown))
            except InputError as error:
                problems.append(str(error))
    return Batch(merged(found), problems)


@contextmanager
def _processes(count: int) -> Iterator[dict[str, Any]]:
    """Give dask processes of this machine. They are forks, which have all libraries at once."""
    with ProcessPoolExecutor(count, get_context("fork"), initializer=_start) as pool:
        yield {"scheduler": "processes", "pool": pool, "chunksize": 1}


@contextmanager
def _cluster(address: str) -> Iterator[dict[str, Any]]:
    """Give dask the cluster that a user runs."""
    key = "--dask-scheduler"
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError(f"{key}: needs the package distributed: pip install distributed") from None
    try:
        get_address_host_port(address, strict=True)
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        allowed = f"the address of a dask scheduler that answers ({error})"
        raise InputError.of_value(key, "", address, allowed) from None
    with client:
        client.run(load, places(), Path(), "plugins")
        told = client.run(reading_code, on_error="return").values()
        if others := {str(each) for each in told} - {reading_code()}:
            raise InputError(f"{key}: its workers have not this program: {others.pop()}")
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
