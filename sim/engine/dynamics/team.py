"""Threads that advance one flow together: shares of the work between common gates.

A step of a few thousand particles takes some hundred microseconds, too short for a scheduler of
tasks. Every thread therefore runs the same compiled loop and waits at a gate for the others. The
shares depend only on the number of threads, and so do the bits of the result.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import kernel

#: Looks at a closed gate before a thread offers its core to others.
PATIENCE = 2000

# Entries of a gate.
ARRIVALS, OPENINGS, THREADS, BROKEN = range(4)

_yield = types.ExternalFunction("sched_yield", types.int32())


def _address(context, builder, signature, args):
    array = context.make_array(signature.args[0])(context, builder, args[0])
    return builder.gep(array.data, [args[1]])


class Share(NamedTuple):
    """Particles ``begin``..``end``, those of the thread of this ``rank``."""

    rank: int
    begin: int
    end: int


@intrinsic
def _add(typingctx, array, index):
    """Add one to an entry, atomically, and return the old value."""

    def codegen(context, builder, signature, args):
        one = context.get_constant(types.int64, 1)
        return builder.atomic_rmw(
            "add", _address(context, builder, signature, args), one, "seq_cst"
        )

    return types.int64(array, types.int64), codegen


@intrinsic
def _read(typingctx, array, index):
    """Read an entry that other threads change."""

    def codegen(context, builder, signature, args):
        return builder.load_atomic(_address(context, builder, signature, args), "seq_cst", 8)

    return types.int64(array, types.int64), codegen


def make_gate(threads: int) -> np.ndarray:
    """Return a gate that opens whenever this many threads have arrived."""
    return np.array([0, 0, threads, 0], np.int64)


@kernel
def barrier(gate):
    """Wait until all threads of the gate have arrived; return True if one of them has failed."""
    threads = gate[THREADS]
    if threads == 1:
        return False
    openings = _read(gate, OPENINGS)
    if _add(gate, ARRIVALS) == threads - 1:
        gate[ARRIVALS] = 0
        _add(gate, OPENINGS)
        return False
    looks = 0
    while _read(gate, OPENINGS) == openings:
        if _read(gate, BROKEN):
            return True
        looks += 1
        if looks > PATIENCE:
            _yield()
    return False


class Team:
    """Runs a function of a thread's rank on all threads of a team."""

    def __init__(self, threads: int):
        self.gate = make_gate(threads)
        self._ranks = range(1, threads)
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def run(self, task: Callable[[int], int]) -> int:
        """Run a task for all ranks; return the result of ``task(0)`` once all have ended.

        When one of them raises an exception before it has reached the gate, the gate is broken for
        good, so that no thread waits for it, and the exception is passed on.
        """
        others = [self._pool.submit(self._run_guarded, task, rank) for rank in self._ranks]
        try:
            return task(0)
        except BaseException:
            self.gate[BROKEN] = 1
            raise
        finally:
            for other in others:
                other.result()

    def _run_guarded(self, task: Callable[[int], int], rank: int) -> int:
        try:
            return task(rank)
        except BaseException:
            self.gate[BROKEN] = 1
            raise
