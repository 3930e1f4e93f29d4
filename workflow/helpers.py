"""What the rules need besides Snakemake: a folder that others may have left."""

import fcntl
import os
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import TextIO

#: Seconds by which clocks of machines that share a folder may differ, and a time before all others.
CLOCK_ERROR = 60.0
OLD = 86400.0

#: A time before which no run was made, and seconds from a run's time to one before that.
YEAR_2000 = 946684800.0
FIFTY_YEARS = 50 * 365.25 * 86400


def release_stale_lock(folder: Path = Path(".snakemake")) -> TextIO:
    """Remove the lock of a Snakemake that was killed, and only then; return this one's own.

    Every Snakemake of this workflow holds a shared file lock for as long as it lives; the kernel
    drops it with the process. Whoever gets it exclusively is therefore alone, and a lock that
    Snakemake itself has left in its folder belongs to nobody. Nor do its notes of incomplete files:
    ours appear whole or not at all.
    """
    folder.mkdir(exist_ok=True)
    held = (folder / "talus.lock").open("w")
    with suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for left in ("locks", "incomplete"):
            shutil.rmtree(folder / left, ignore_errors=True)
        # Without it Snakemake would look through all that it knows of files.
        (folder / "incomplete").mkdir(exist_ok=True)
    with suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_SH)
    return held


def write_start(path: Path) -> None:
    """Write a file older than all runs, and never the same twice, for `age`.

    Snakemake runs a job again whose input is newer than its output and not what it was when the
    output was made, whatever it has noted of a job that was killed.
    """
    path.write_text(str(time.time_ns()), encoding="utf-8")
    os.utime(path, (YEAR_2000, YEAR_2000))


def age(path: Path, is_old: bool) -> None:
    """Make an output older than what `write_start` writes, or give it back its time."""
    with suppress(OSError):
        then = path.stat().st_mtime
        if is_old != (then < YEAR_2000):
            then += -FIFTY_YEARS if is_old else FIFTY_YEARS
            os.utime(path, (then, then))


def correct_future_times(results: Path) -> None:
    """Give files that a wrong clock has dated into the future times that hide no change.

    A run file was made before now. Whatever is made from runs becomes as old as can be; where its
    inputs have changed since, which Snakemake knows by checksums, it is made again.
    """
    now = time.time()
    for path in results.rglob("*"):
        if path.is_file() and path.stat().st_mtime > now + CLOCK_ERROR:
            then = now if path.match("runs/*.nc") else OLD
            os.utime(path, (then, then))
