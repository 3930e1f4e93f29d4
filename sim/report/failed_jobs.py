"""A line for each job that has failed, of which Snakemake writes a page or, kept quiet, nothing."""

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

#: The event of Snakemake's log that tells of a failed job.
EVENT = "job_error"

#: How sentences begin that tell nothing, in what Snakemake says of a failed job of a cluster.
ADVICE = ("Detailed failure reason unavailable", "For further error details")

#: How it begins what Snakemake says of each output of a failed job of which there is no backup, of
#: its whole command, and of each turn of its scheduler.
NO_NEWS = (
    "Cannot restore ",
    "RuleException:\nCalledProcessError ",
    "Select jobs to execute",
    "Execute ",
)

#: Seconds by which a file's time may be before the moment it was written: file systems keep ticks
#: or whole seconds, and those of a cluster have clocks of their own.
CLOCKS_DIFFER_BY = 2.0


def is_news(record: logging.LogRecord) -> bool:
    """Return whether Snakemake says something that lines of points and failed jobs do not."""
    return not record.getMessage().startswith(NO_NEWS)


class FailedJobs(logging.Handler):
    """Hears Snakemake's log and writes a line for each job that fails.

    Parameters
    ----------
    write : callable
        Is given each line.
    """

    def __init__(self, write: Callable[[str], object]):
        super().__init__()
        self._write = write
        self._since = time.time() - CLOCKS_DIFFER_BY

    def emit(self, record: logging.LogRecord) -> None:
        """Write the line of a failed job; pass over what else the log says."""
        said = record.__dict__
        if said.get("event") == EVENT:
            logs = [Path(path) for path in said["log"]]
            name = logs[0].stem if logs else said["rule_name"]
            message = (said["rule_msg"] or "").partition("\n")[0]
            for words in ADVICE:
                message = message.partition(words)[0].rstrip(". ")
            parts = (name, "job failed", message, self._last_line(logs))
            self._write(": ".join(filter(None, parts)))

    def _last_line(self, logs: Sequence[Path]) -> str:
        """Return the last line of the first log, if it is of this workflow, or which to look at."""
        with suppress(OSError, IndexError):
            if logs[0].stat().st_mtime >= self._since:
                return logs[0].read_text(encoding="utf-8", errors="replace").splitlines()[-1]
        # What could not be submitted again has the empty log of its first attempt.
        return "".join(f"see {path}" for path in logs[-1:] if path.exists() and path.stat().st_size)
