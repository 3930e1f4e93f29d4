"""Times of files, by which Snakemake decides which jobs to rerun."""

import os
import time
from contextlib import suppress
from pathlib import Path

#: Maximum difference (s) of clocks of machines that share a folder; and a time before all others.
CLOCK_ERROR = 60.0
OLD = 86400.0

#: A time (s) before all runs; and the shift (s) that dates a run file back to before that time.
YEAR_2000 = 946684800.0
FIFTY_YEARS = 50 * 365.25 * 86400


def write_start(path: Path) -> None:
    """Write a file that is older than all runs, with fresh content each time; see `age`.

    Snakemake reruns a job if an input is newer than its output and has changed since the output was
    made. This holds whatever Snakemake has recorded of a failed job.
    """
    path.parent.mkdir(exist_ok=True)
    path.write_text(str(time.time_ns()), encoding="utf-8")
    os.utime(path, (YEAR_2000, YEAR_2000))


def age(path: Path, is_old: bool) -> None:
    """Date an output before the file of `write_start`, or restore its time."""
    with suppress(OSError):
        time_modified = path.stat().st_mtime
        if is_old != (time_modified < YEAR_2000):
            time_modified += -FIFTY_YEARS if is_old else FIFTY_YEARS
            os.utime(path, (time_modified, time_modified))


def correct_future_times(results: Path) -> None:
    """Correct file times in the future, due to a wrong clock, so that no change is missed.

    A run file gets the present time. All other files, which derive from runs, get a very old time.
    Snakemake then makes those anew whose inputs have changed, as their checksums show.
    """
    now = time.time()
    for path in results.rglob("*"):
        if path.is_file() and path.stat().st_mtime > now + CLOCK_ERROR:
            new_time = now if path.match("runs/*.nc") else OLD
            os.utime(path, (new_time, new_time))
