"""Output of a running workflow: a line per failed point or job, and a bar on a terminal."""

import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from tqdm import tqdm

from sim.base.errors import InputError
from sim.base.plugins import NOTICE
from sim.base.program import PACKAGE
from sim.report.status import as_text, survey
from sim.study.load import Study

#: Seconds between two checks of the folder of runs.
PAUSE = 1.0

#: Seconds before the first preview, and share of the time that previews may take.
FIRST, SHARE = 60.0, 0.05

#: Format of the bar on a terminal.
BAR_FORMAT = "{desc}: {n_fmt} of {total_fmt} points |{bar:30}| {remaining} left{postfix}"

#: The event of a failed job in Snakemake's log.
EVENT = "job_error"

#: Beginnings of uninformative sentences in Snakemake's messages on failed jobs of a cluster.
ADVICE = ("Detailed failure reason unavailable", "For further error details")

#: Beginnings of Snakemake's messages on outputs of failed jobs without a backup, on the whole
#: command of a job, on turns of the scheduler, on a report that a preview stood in for, and at the
#: end of a workflow whose jobs said why.
NO_NEWS = (
    "WorkflowError:\nAt least one job did not complete",
    "Complete log(s): ",
    "Elapsed time: ",
    "Warning: the following output files of rule report",
    "Cannot restore ",
    "RuleException:\nCalledProcessError ",
    "Select jobs to execute",
    "Execute ",
)

#: Seconds by which the time of a file may precede its writing: file systems store ticks or whole
#: seconds, and those of a cluster have their own clocks.
CLOCKS_DIFFER_BY = 2.0


class Watch(threading.Thread):
    """Thread that follows the run files and logs of a study until `end` is called.

    Points of rounds of refinement are reported once they have run files. ``folder`` has the
    results: ``runs`` and ``logs/runs``.
    """

    def __init__(self, study: Study, folder: Path):
        super().__init__(daemon=True)
        self._study, self._folder = study, folder
        self._runs, self._logs = folder / "runs", folder / "logs" / "runs"
        self._points = study.points.keys()
        self._ended = threading.Event()
        self._inodes = self._read_run_files()
        self._failed_count = 0
        self._bar = tqdm(
            desc=study.name,
            total=len(self._points),
            initial=len(self._points & self._inodes.keys()),
            bar_format=BAR_FORMAT,
            file=sys.stderr,
            disable=not sys.stderr.isatty(),
        )
        self._previews = Previews(study, folder)

    def run(self) -> None:
        """Report points at intervals of `PAUSE`."""
        while not self._ended.wait(PAUSE):
            self._report()
            self._previews.update(len(self._points & self._inodes.keys()))

    def follow(self, log: logging.Logger) -> None:
        """Start, and add to Snakemake's log the lines of failed jobs, in place of its own."""
        self.start()
        log.addFilter(lambda record: not record.getMessage().startswith(NO_NEWS))
        log.addHandler(FailedJobs(self.write))

    def summarize(self) -> None:
        """End, and print the status of all points and where the report on them is.

        An error here must not fail the workflow.
        """
        self.end()
        report, dataset = self._folder / "report.html", self._folder / "dataset.nc"
        try:
            print(f"\n{as_text(survey(self._study, self._folder.parent))}\n", file=sys.stderr)
            with suppress(FileNotFoundError):
                if report.stat().st_mtime >= dataset.stat().st_mtime:
                    print(f"report: {report}", file=sys.stderr)
        except (InputError, OSError) as error:
            print(f"no summary: {error}", file=sys.stderr)

    def end(self) -> None:
        """Stop the thread, and report the points that have finished since."""
        self._ended.set()
        if self.is_alive():
            self.join()
        self._previews.stop()
        self._report()
        self._bar.close()

    def write(self, line: str) -> None:
        """Write a line, above the bar if there is one."""
        self._bar.write(line, file=sys.stderr)

    def _read_run_files(self) -> dict[str, int]:
        """Return the inode of each run file by point; each new file has another."""
        inodes = {}
        with suppress(FileNotFoundError), os.scandir(self._runs) as entries:
            for entry in entries:
                if entry.name.endswith(".nc") and not entry.name.startswith("."):
                    with suppress(FileNotFoundError):
                        inodes[entry.name.removesuffix(".nc")] = entry.inode()
        return inodes

    def _report(self) -> None:
        """Write a line for each point that has failed since the last check, and move the bar."""
        inodes = self._read_run_files()
        for name in inodes.keys() - self._inodes.keys():
            self._bar.update(name in self._points)
        for name in inodes:
            if self._inodes.get(name) != inodes[name] and "failed" in (line := self._line(name)):
                self._failed_count += 1
                self.write(line)
        self._inodes |= inodes
        self._bar.set_postfix_str(f"{self._failed_count} failed")

    def _line(self, name: str) -> str:
        """Return the last line with the result in the log of a run, empty without one."""
        with suppress(OSError):
            lines = (self._logs / f"{name}.log").read_text(encoding="utf-8").splitlines()
            return next((x for x in reversed(lines) if x.startswith(f"{name}: ")), "")
        return ""


class Previews:
    """Processes that write previews of a study, one at a time and seldom."""

    def __init__(self, study: Study, folder: Path):
        self._study, self._log = study, folder / "logs" / "preview.log"
        self._process: subprocess.Popen[bytes] | None = None
        self._started, self._next, self._shown = 0.0, time.monotonic() + FIRST, 0

    def update(self, ended: int) -> None:
        """Start a preview if it is time, given how many points have ended; with all, none is."""
        if ended >= len(self._study.points):
            self.stop()
        elif self._process:
            if self._process.poll() is not None:
                now, self._process = time.monotonic(), None
                self._next = now + (now - self._started) / SHARE
        elif ended > self._shown and time.monotonic() >= self._next:
            self._started, self._shown = time.monotonic(), ended
            command = [sys.executable, "-P", "-m", "sim", "job", "preview"]
            paths = [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]
            environment = os.environ | {"PYTHONPATH": ":".join(filter(None, paths))}
            with suppress(OSError), self._log.open("wb") as log:
                self._process = subprocess.Popen(
                    [*command, str(self._study.path)], env=environment, stdout=log, stderr=log
                )

    def stop(self) -> None:
        """End the process, if there is one, before it writes."""
        if self._process and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._process = None


class FailedJobs(logging.Handler):
    """Log handler that calls ``write`` with a line for each failed job of Snakemake."""

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
                return _said(logs[0])[-1]
        # A job that could not be resubmitted has the empty log of its first attempt.
        with suppress(OSError):
            return "".join(f"see {path}" for path in logs[-1:] if _said(path))
        return ""


def _said(log: Path) -> list[str]:
    """Return the lines of a log without those on plug-ins, which say of no job why it ended."""
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    return [line for line in lines if not line.startswith(NOTICE)]
