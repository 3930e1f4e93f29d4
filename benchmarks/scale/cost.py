"""What a command costs: processor time, time on the clock, memory."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import psutil

ROOT = Path(__file__).parents[2]

#: Seconds between two looks at the memory of a command, and the most of them that looking may take.
PAUSE, SHARE = 0.1, 0.02


class Cost(NamedTuple):
    """Processor time (s), time on the clock (s), memory (MB) of a command.

    ``memory`` is the most that its processes held together, ``own`` the most that the first of them
    did.
    """

    cpu: float
    wall: float
    memory: float
    own: float


def cost(folder: Path, *words: str, until: Callable[[], bool] | None = None) -> Cost:
    """Run a command of this environment in a folder; return what it cost.

    Once ``until`` holds, the command and all its processes are killed. Raises
    ``CalledProcessError`` when it fails, or ends before.
    """
    command = [sys.executable, "-m", *words]
    began, together, own = time.perf_counter(), 0.0, 0.0
    with (folder / "output.log").open("wb") as log:
        process = subprocess.Popen(
            command,
            cwd=folder,
            stdout=log,
            stderr=log,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            process_group=0,
        )
    under_way = 0.0
    while not (ended := os.wait4(process.pid, os.WNOHANG))[0]:
        looked = time.perf_counter()
        first, others = _memory(process.pid)
        together, own = max(together, first + others), max(own, first)
        if until and not under_way and until():
            under_way = _spent(process.pid)
            os.killpg(process.pid, signal.SIGKILL)
        time.sleep(max(PAUSE, (time.perf_counter() - looked) / SHARE))
    _, status, usage = ended
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != (-signal.SIGKILL if until else 0):
        raise subprocess.CalledProcessError(process.returncode, command)
    wall = time.perf_counter() - began
    spent = usage.ru_utime + usage.ru_stime + under_way
    return Cost(spent, wall, together / 1e6, own / 1e6)


def _memory(pid: int) -> tuple[float, float]:
    """Return the bytes that a process holds, and its descendants; what they share is divided."""
    found = [0.0, 0.0]
    with suppress(psutil.Error):
        first = psutil.Process(pid)
        for each in (first, *first.children(recursive=True)):
            with suppress(psutil.Error):
                found[each != first] += each.memory_full_info().pss
    return found[0], found[1]


def _spent(pid: int) -> float:
    """Return the processor time (s) of the descendants of a process, which nobody waits for."""
    total = 0.0
    for each in psutil.Process(pid).children(recursive=True):
        with suppress(psutil.Error):
            times = each.cpu_times()
            total += times.user + times.system
    return total
