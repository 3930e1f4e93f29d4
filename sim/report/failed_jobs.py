"""A line per failed job; Snakemake itself writes a page or, when quiet, nothing."""

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

#: The event of a failed job in Snakemake's log.
EVENT = "job_error"

#: Beginnings of uninformative sentences in Snakemake's messages on failed jobs of a cluster.
ADVICE = ("Detailed failure reason unavailable", "For further error details")

#: Beginnings of Snakemake's messages on outputs of failed jobs without a backup, on the whole
#: command of a job, and on turns of the scheduler.
NO_NEWS = (
    "Cannot restore ",
    "RuleException:\nCalledProcessError ",
    "Select jobs to execute",
    "Execute ",
)

#: Seconds by which the time of a file may precede its writing: file systems store ticks or whole
#: seconds, and those of a cluster have their own clocks.
CLOCKS_DIFFER_BY = 2.0


def is_news(record: logging.LogRecord) -> bool:
    """Return whether a message of Snakemake adds to the lines of points and failed jobs."""
    return not record.getMessage().startswith(NO_NEWS)


class FailedJobs(logging.Handler):
    """Log handler that writes a line for each failed job of Snakemake.

    Parameters
    ----------
    write : callable
        Called with each line.
    """

    def __init__(self, write: Callable[[str], object]):
        super().__init__()
        self._write = write
        self._since = time.time() - CLOCKS_DIFFER_BY

    def emit(self, record: logging.LogRecord) -> None:
        """Write the line of a failed job; ignore other records."""
        fields = record.__dict__
        if fields.get("event") == EVENT:
            logs = [Path(path) for path in fields["log"]]
            name = logs[0].stem if logs else fields["rule_name"]
            message = (fields["rule_msg"] or "").partition("\n")[0]
            for advice in ADVICE:
                message = message.partition(advice)[0].rstrip(". ")
            parts = (name, "job failed", message, self._last_line(logs))
            self._write(": ".join(filter(None, parts)))

    def _last_line(self, logs: Sequence[Path]) -> str:
        """Return the last line of the first log if this workflow wrote it, else which to see."""
        with suppress(OSError, IndexError):
            if logs[0].stat().st_mtime >= self._since:
                return logs[0].read_text(encoding="utf-8", errors="replace").splitlines()[-1]
        # A job that could not be resubmitted has the empty log of its first attempt.
        return "".join(f"see {path}" for path in logs[-1:] if path.exists() and path.stat().st_size)
