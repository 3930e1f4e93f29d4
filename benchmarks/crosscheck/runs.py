"""All replicates of all flows in both engines, several at a time; what is done stays done."""

import hashlib
import logging
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from signal import SIG_DFL, SIGINT, signal

import numpy as np

from benchmarks.crosscheck.engines import Record, run
from benchmarks.crosscheck.flows import Flow
from benchmarks.peers import chute_input
from benchmarks.peers.environment import PACKAGES
from sim.base.files import atomic_write
from sim.engine.identity import source_hash
from sim.parameters import canonical_json, point_id

log = logging.getLogger(__name__)

CACHE = Path(__file__).parent / ".cache"

#: A task is the name of an engine, a flow and the number of a replicate.
Task = tuple[str, Flow, int]


def record_path(engine: str, flow: Flow, replicate: int) -> Path:
    """Return where a replicate is kept; the name changes with whatever may change its numbers."""
    versions = [source_hash(), canonical_json(flow.parameters())]
    if engine == "LAMMPS":
        versions += [*PACKAGES, Path(chute_input.__file__).read_text()]
    digest = hashlib.sha256("\n".join(versions).encode()).hexdigest()[:8]
    return CACHE / f"{point_id(flow.parameters())}-{engine}-{replicate}-{digest}.npz"


def tasks(flows: Iterable[Flow]) -> list[Task]:
    """Return what has to be run for these flows: all first replicates, the longest first, etc."""
    every = [
        (engine, flow, replicate)
        for flow in flows
        for replicate in range(flow.replicates)
        for engine in ("LAMMPS", "Talus")
    ]
    return sorted(every, key=lambda task: (task[2], -_cost(task)))


def _cost(task: Task) -> float:
    """Return the particle-steps of a task; LAMMPS takes about twice as long for one."""
    engine, flow, _ = task
    p = flow.parameters()
    return p.particles * p.steps * (2.0 if engine == "LAMMPS" else 1.0)


def compute(task: Task) -> float:
    """Run one replicate and keep its record; return the seconds it took."""
    started = time.perf_counter()
    record = run(*task)
    with atomic_write(record_path(*task)) as path, path.open("wb") as file:
        np.savez_compressed(file, **record._asdict())
    return time.perf_counter() - started


def compute_all(flows: Iterable[Flow], jobs: int) -> None:
    """Compute what is missing, ``jobs`` replicates at a time."""
    missing = [task for task in tasks(flows) if not record_path(*task).exists()]
    CACHE.mkdir(exist_ok=True)
    # An interrupt ends the processes of the pool at once, instead of only their present tasks.
    with ProcessPoolExecutor(jobs, initializer=signal, initargs=(SIGINT, SIG_DFL)) as pool:
        pending = {pool.submit(compute, task): task for task in missing}
        try:
            for number, done in enumerate(as_completed(pending), 1):
                engine, flow, replicate = pending[done]
                seconds = done.result()
                message = "%d of %d: %s, %s, replicate %d: %.0f s"
                log.info(message, number, len(missing), flow.name, engine, replicate, seconds)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def load(engine: str, flow: Flow) -> list[Record]:
    """Return the records of all replicates of a flow in one engine."""
    records = []
    for replicate in range(flow.replicates):
        with np.load(record_path(engine, flow, replicate)) as stored:
            records.append(Record(**stored))
    return records
