"""Rows of a study from datasets and from run files, which several processes may read."""

import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.plugins import load, places
from sim.base.seals import UNREADABLE, is_damaged, read_seal
from sim.dataset.gather import read_run
from sim.dataset.grids import open_group
from sim.dataset.rows import (
    OF_PROFILES,
    PARTICLES,
    RUNS,
    WORDS,
    Row,
    amounts_text,
    reader_hash,
    stored_names,
)
from sim.parameters import SYSTEMS, Parameters, amounts
from sim.study.model import Need, Point, Study
from sim.study.plottable import Shown

#: Most run files that are read before their rows are handed over.
BATCH = 40

#: Fewest files for which processes are started, which take time as well.
MIN_FILES = 40

#: Seconds within which a dask scheduler answers, for which a cluster may be without any worker, and
#: between two looks at it.
SCHEDULER_TIMEOUT, WORKER_TIMEOUT, POLL = 10, 120, 0.2

#: The option that names a cluster, for messages.
_KEY = "--dask-scheduler"

_READ_LOCK = threading.Lock()

#: A run file, the amounts to read, and what is needed of it.
File = tuple[Path, Mapping[str, float], Need]


class Batch(NamedTuple):
    """Rows of run files, and the errors of those that could not be read."""

    rows: list[Row]
    problems: list[str]


def gather_rows(
    study: Study,
    folder: Path,
    points: Mapping[str, Point],
    processes: int = 1,
    scheduler: str | None = None,
) -> dict[str, Row]:
    """Return the rows of points of a study by point, each from the first source that has it.

    These are the earlier dataset and run files. The study says how much its figures need of
    particles, ``folder`` has its results, and ``points`` have the amounts to read, by id. For
    ``processes`` and ``scheduler`` see `read_files`. Raises `InputError` when run files are missing
    or damaged, see `read_files`.
    """
    need = study.need
    known = {key: point.parameters for key, point in points.items()}
    rows = {row.point: row for row in earlier_rows(folder, need, known)}
    files = [
        (folder / "runs" / f"{key}.nc", amounts(parameters), need(key))
        for key, parameters in known.items()
        if key not in rows
    ]
    rows |= {row.point: row for row in read_files(files, processes, scheduler)}
    for row in rows.values():
        for name in () if need(row.point).profiles else OF_PROFILES.keys() & row.values.keys():
            del row.values[name]
    return rows


def read_files(
    files: Sequence[File], processes: int = 1, scheduler: str | None = None
) -> list[Row]:
    """Read the rows of run files.

    Each of ``files`` has its path, the amounts of it, and what is needed of it. If they are enough,
    a number of ``processes`` read in parallel, or instead the workers of a dask ``scheduler`` at
    this address; they must see the same folders. Raises `InputError` when files are missing or
    damaged; the message names the first. All damaged files are set aside.
    """
    batches = list(_batches(files, processes, scheduler))
    if problems := [problem for batch in batches for problem in batch.problems]:
        raise InputError.of_several(problems)
    return [row for batch in batches for row in batch.rows]


def _batches(files: Sequence[File], processes: int, scheduler: str | None) -> Iterable[Batch]:
    """Read the files in batches: in this process, in forks of it, or by a cluster."""
    size = max(1, min(BATCH, -(-len(files) // max(1, processes))))
    parts = [files[first : first + size] for first in range(0, len(files), size)]
    if files and scheduler is not None:
        absolute = [[(file[0].absolute(), file[1], file[2]) for file in part] for part in parts]
        return _read_by_cluster(absolute, scheduler)
    if processes > 1 and len(files) >= MIN_FILES:
        workers = min(processes, len(parts))
        # Forks have all libraries loaded.
        with ProcessPoolExecutor(workers, get_context("fork"), _follow_parent) as pool:
            return list(pool.map(read_batch, parts))
    return map(read_batch, parts)


def read_batch(files: Sequence[File]) -> Batch:
    """Read some run files; a damaged one does not keep the others from being read."""
    rows, problems = [], []
    # A worker of a cluster may have several threads, and HDF5 is not thread-safe.
    with _READ_LOCK:
        for path, wanted, need in files:
            try:
                rows.append(read_run(path, wanted, need))
            except InputError as error:
                problems.append(str(error))
    return Batch(rows, problems)


def _read_by_cluster(parts: Sequence[Sequence[File]], address: str) -> Sequence[Batch]:
    """Read batches of files by the cluster of the user.

    Raises `InputError` where its scheduler does not answer, or where it has no worker for long.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.client import FutureCancelledError
        from distributed.comm import get_address_host_port
    except ImportError:
        problem = "needs the package distributed: pip install distributed"
        raise InputError(f"{_KEY}: {problem}") from None
    try:
        get_address_host_port(address, strict=True)
        with Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False) as client:
            _require_worker(client, address)
            client.run(load, places(), Path(), "plugins")
            hashes = client.run(reader_hash, on_error="return").values()
            if others := {str(value) for value in hashes} - {reader_hash()}:
                raise InputError(f"{_KEY}: its workers do not have this program: {others.pop()}")
            futures = client.map(read_batch, parts, pure=False)
            while any(not future.done() for future in futures):
                _require_worker(client, address)
                time.sleep(POLL)
            failures = [future.exception() for future in futures if future.status == "error"]
            batches = [] if failures else client.gather(futures)
    except (OSError, ValueError, FutureCancelledError, MemoryError) as error:
        # Another program at the address may announce an answer that no memory holds.
        allowed = f"the address of a dask scheduler that answers ({error})"
        raise InputError.of_value(_KEY, "", address, allowed) from None
    if failures and isinstance(failures[0], KilledWorker):
        raise InputError(f"{_KEY}: {address}: its workers end while they read run files")
    if failures:
        raise failures[0]
    return batches


def _require_worker(client: Any, address: str) -> None:
    """Wait until a cluster has a worker; raise `InputError` where it has none for long."""
    start, is_told = time.monotonic(), False
    while not client.scheduler_info()["workers"]:
        if not is_told:
            print(f"{_KEY}: {address} has no worker; waiting for one", file=sys.stderr)
            is_told = True
        if time.monotonic() - start > WORKER_TIMEOUT:
            allowed = f"a cluster with a worker (none for {WORKER_TIMEOUT} s)"
            raise InputError.of_value(_KEY, "", address, allowed)
        time.sleep(POLL)


def _follow_parent() -> None:
    """Leave interrupts to the parent of this process, and end when the parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    assert parent is not None

    def end_with_parent() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


#: Second name of the last dataset of a study. It stays when the workflow removes ``dataset.nc``,
#: which happens before it makes a new one and when it fails to.
EARLIER_FILE = ".earlier.nc"


def keep_dataset(dataset: Path, folder: Path) -> None:
    """Keep a dataset for `earlier_rows`: a hard link, or a copy where links are impossible."""
    with atomic_write(folder / EARLIER_FILE) as temporary:
        try:
            os.link(dataset, temporary)
        except OSError:
            shutil.copyfile(dataset, temporary)


def earlier_rows(
    folder: Path, need: Callable[[str], Need], points: Mapping[str, Parameters]
) -> list[Row]:
    """Return the rows of points in the earlier dataset that equal what their run files would give.

    ``folder`` has the results of the study. There are no such rows without an earlier dataset, or
    if that is damaged or was made by other code. ``need`` returns what must be stored of a point
    besides its scalars, by its id; ``points`` are by id, too.
    """
    path = folder / EARLIER_FILE
    texts = {point: amounts_text(amounts(value)) for point, value in points.items()}

    def is_same(row: Any, code: str) -> bool:
        run, wanted = folder / "runs" / f"{row.point}.nc", texts.get(row.point)
        with suppress(OSError):
            return row.wanted == wanted and code == reader_hash() and read_seal(run) == row.seal
        return False

    with suppress(*UNREADABLE):
        if path.is_file() and not is_damaged(path):
            return list(read_rows(path, is_same, need))
    return []


def read_rows(
    path: Path, is_selected: Callable[[Any, str], bool], need: Callable[[str], Need]
) -> Iterator[Row]:
    """Yield the selected rows of a dataset that store enough of profiles and particles.

    ``is_selected`` gets the id of a point, its system and what the group `RUNS` says of it, by
    name, and the hash of the code that read it. Variables unknown to the present code are left out.
    """
    with netCDF4.Dataset(path) as file:
        root, runs = (open_group(file, name).load() for name in (None, RUNS))
        groups = {name: open_group(file, name).load() for name in SYSTEMS if name in file.groups}
        places = {
            point: place
            for group in groups.values()
            for place, point in enumerate(group["run"].values)
        }
        states = file.groups[PARTICLES].groups if PARTICLES in file.groups else {}
        known_names = stored_names()
        origin = [str(name) for name in runs if name not in ("variables", "adopted")]
        labels = {name: root[name].values for name in ("point", "system")}
        for number, row in enumerate(runs.to_dataframe().assign(**labels).itertuples()):
            wanted, particles = need(row.point), Shown.NOTHING
            if row.point in states:
                has_path = "path" in states[row.point].variables
                particles = Shown.PATH if has_path else Shown.STATE
            has_enough = particles >= wanted.particles and (
                row.point in places or not wanted.profiles
            )
            if not (has_enough and is_selected(row, runs.attrs["code"])):
                continue
            values = {}
            for name in filter(known_names.__contains__, row.variables.split()):
                if name in OF_PROFILES:
                    stored = groups[row.system].variables[name].values
                    values[name] = stored[places[row.point]]
                else:
                    kind = object if name in WORDS else float
                    values[name] = root.variables[name].values[number].astype(kind)
            state = None
            if particles:
                state = open_group(file, f"{PARTICLES}/{row.point}").load()
            known = {name: getattr(row, name) for name in origin} | {"adopted": ""}
            yield Row(row.point, known, values, state).without_padding()
