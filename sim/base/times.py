"""Times of files, by which Snakemake decides which jobs to rerun."""

import os
import shutil
import sys
import time
from contextlib import suppress
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import atomic_write

#: Maximum difference (s) of clocks of machines that share a folder; and a time before all others.
CLOCK_ERROR = 60.0
OLD = 86400.0

#: A time (s) before all runs; and the shift (s) that dates a run file back to before that time.
YEAR_2000 = 946684800.0
FIFTY_YEARS = 50 * 365.25 * 86400

#: Outputs of the workflow in the folder of a study, beside adopted datasets.
OUTPUTS = (
    *("adopted/*.nc", "runs/*.nc", "runs/.warm", "rounds/*.json", "figures/*", "pages/*.html"),
    *("dataset.nc", "boundaries.csv", "claims.csv", "verdicts.csv", "claims.json", "report.html"),
)

#: Those of them that are made of many run files.
READERS = ("rounds/*.json", "dataset.nc")


def write_start(path: Path) -> None:
    """Write a file that is older than all runs, with fresh content each time; see `age`.

    Snakemake reruns a job if an input is newer than its output and has changed since the output was
    made. This holds whatever Snakemake has recorded of a failed job.
    """
    path.parent.mkdir(exist_ok=True)
    with atomic_write(path, durable=False) as temporary:
        temporary.write_text(str(time.time_ns()), encoding="utf-8")
        os.utime(temporary, (YEAR_2000, YEAR_2000))


def age(path: Path, is_old: bool) -> None:
    """Date an output before the file of `write_start`, or restore its time.

    Where the file has other names, as in other studies, those keep their time: it is copied first.
    """
    with suppress(OSError):
        status = path.stat()
        if is_old != (status.st_mtime < YEAR_2000):
            if status.st_nlink > 1:
                with atomic_write(path) as temporary:
                    shutil.copyfile(path, temporary)
            time_modified = status.st_mtime + (-FIFTY_YEARS if is_old else FIFTY_YEARS)
            os.utime(path, (time_modified, time_modified))


def date_back_readers(results: Path) -> None:
    """Date what is made of run files before them, where some have come with times of their own.

    Snakemake then makes those anew whose inputs have changed, as their checksums show.
    """
    for path in (path for pattern in READERS for path in results.glob(pattern)):
        with suppress(OSError):
            os.utime(path, (OLD, OLD), follow_symlinks=False)


def correct_future_times(results: Path) -> None:
    """Correct times of `OUTPUTS` in the future, due to a wrong clock, so that no change is missed.

    A run file gets the present time. All other files, which derive from runs, get a very old time.
    Snakemake then makes those anew whose inputs have changed, as their checksums show. One line on
    standard error names what the system does not let correct.
    """
    now, problems = time.time(), []
    for path in (path for pattern in OUTPUTS for path in results.glob(pattern)):
        try:
            if path.is_file() and path.stat().st_mtime > now + CLOCK_ERROR:
                new_time = now if path.match("runs/*.nc") else OLD
                os.utime(path, (new_time, new_time))
        except FileNotFoundError:
            pass  # removed in the meantime
        except OSError as error:
            problems.append(f"{path}: {error.strerror}")
    if problems:
        names = InputError.of_several(problems)
        print(
            f"warning: dated in the future, so what derives from it may not be made again: {names}",
            file=sys.stderr,
        )
