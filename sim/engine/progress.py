"""Progress of a run: a bar on a terminal, log lines elsewhere, a small file beside the output."""

import logging
import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, ValidationError
from tqdm import tqdm

from sim.base.errors import duration
from sim.base.files import atomic_write, read_regular
from sim.parameters import Parameters, point_id

log = logging.getLogger("talus")

#: Seconds to the first log line about progress. Each pause is twice the previous one, up to the
#: longest.
FIRST_PAUSE = 10.0
LONGEST_PAUSE = 300.0

#: Shortest time (s) between two writes of the progress file.
WRITE_INTERVAL = 2.0

#: Seconds without a report after which a run on another machine is taken for interrupted.
LONGEST_SILENCE = 600.0


class Progress(BaseModel):
    """The content of a progress file: the state of a run at the time of writing.

    ``done`` of ``total`` steps over all replicates, without settling; ``at_most`` where the run may
    end before, once its mean velocity is precise enough. ``rate`` is in particle-steps per second,
    the mean since the first sample of this process: the time before it, for loading and for
    settling a bed, is not representative. ``elapsed`` are the seconds since this process started
    on the point, by a monotonic clock; ``updated`` is when the file was written.
    """

    model_config = ConfigDict(allow_inf_nan=False)

    point: str
    done: int = Field(ge=0)
    total: int = Field(gt=0)
    at_most: bool
    particles: int
    rate: float = Field(ge=0)
    elapsed: float
    updated: AwareDatetime
    pid: int = Field(gt=0, lt=2**31)
    host: str

    @property
    def percent(self) -> int:
        """Percentage of the total that is done; 100 only at the end."""
        return min(100, 100 * self.done // self.total)

    @property
    def remaining_seconds(self) -> float | None:
        """Expected seconds to the total; None until a rate is known."""
        return (self.total - self.done) * self.particles / self.rate if self.rate else None

    @property
    def remaining_time(self) -> str:
        """`remaining_seconds` in words."""
        if self.remaining_seconds is None:
            return "unknown"
        return f"{'at most' if self.at_most else 'about'} {duration(self.remaining_seconds)}"


def may_end_early(parameters: Parameters) -> bool:
    """True where a run may end before its total, once its mean velocity is precise enough."""
    return parameters.longest_samples > parameters.shortest_samples


def length(parameters: Parameters) -> str:
    """Return the text of the number of steps of all replicates, a bound where it may vary."""
    bound = "at most " if may_end_early(parameters) else ""
    return f"{bound}{parameters.replicates * parameters.steps:,} steps"


def progress_file(output: Path) -> Path:
    """Return the path of the progress file of the run that will write ``output``."""
    return output.with_name(f".{output.name}.progress")


def read_progress(output: Path) -> Progress | None:
    """Return the progress of the run that will write ``output``; None without a readable file."""
    try:
        return Progress.model_validate_json(read_regular(progress_file(output)))
    except (OSError, ValidationError):
        return None


@contextmanager
def progress(
    parameters: Parameters, output: Path, quiet: bool = False, done: int = 0
) -> Iterator[Callable[[int], None]]:
    """Yield a function to call with the number of steps of every advance.

    ``output`` is the future run file. The progress file lies beside it until the block ends; after
    a ``SystemExit`` it stays, and the next start replaces it. ``quiet``: neither bar nor log lines.
    ``done`` are the steps that a resumed run has done already.
    """
    meter, is_kept = _Meter(parameters, output, quiet, done), False
    try:
        with meter.bar:
            yield meter.advance
    except SystemExit:
        # Terminated after a checkpoint: the file stays, so that the run counts as interrupted.
        is_kept = True
        raise
    finally:
        if not is_kept:
            with suppress(OSError):
                meter.file.unlink(missing_ok=True)


class _Meter:
    """Counts the steps of a run, measures their time by a monotonic clock, and tells of both."""

    def __init__(self, parameters: Parameters, output: Path, quiet: bool, done: int):
        self.now = Progress(
            point=point_id(parameters),
            done=done,
            total=parameters.replicates * parameters.steps,
            at_most=may_end_early(parameters),
            particles=parameters.particles,
            rate=0.0,
            elapsed=0.0,
            updated=datetime.now(UTC),
            pid=os.getpid(),
            host=socket.gethostname(),
        )
        self.length, self.file, self.quiet = length(parameters), progress_file(output), quiet
        name = f"{self.now.point} (at most)" if self.now.at_most else self.now.point
        self.bar = bar(self.now.total, name, "step", quiet, done)
        self.start = self.last_write = monotonic()
        #: Steps done at a time; the first sample includes loading, and compilation where needed.
        self.reference: tuple[int, float] | None = None
        self.pause, self.next_line = FIRST_PAUSE, self.start + FIRST_PAUSE
        self.write()

    def advance(self, steps: int) -> None:
        """Count steps; update the bar and, where they are due, the file and the log."""
        time, now = monotonic(), self.now
        now.done += steps
        now.elapsed, now.updated = time - self.start, datetime.now(UTC)
        if not self.reference:
            self.reference = now.done, time
        elif seconds := time - self.reference[1]:
            now.rate = (now.done - self.reference[0]) * now.particles / seconds
        self.bar.update(steps)
        if time - self.last_write >= WRITE_INTERVAL:
            self.last_write = time
            self.write()
        if self.bar.disable and not self.quiet and time >= self.next_line:
            self.pause = min(2 * self.pause, LONGEST_PAUSE)
            self.next_line = time + self.pause
            log.info(self.line())

    def write(self) -> None:
        """Replace the progress file; an error must not end a run.

        The file need not survive a power cut, so nothing waits for the disk.
        """
        with suppress(OSError), atomic_write(self.file, durable=False) as temporary:
            temporary.write_text(self.now.model_dump_json(indent=2) + "\n")

    def line(self) -> str:
        """Return the text of a log line."""
        now = self.now
        done = f"{now.point}: {now.percent} % of {self.length}"
        if now.remaining_seconds is None:
            return done
        return f"{done}, {now.rate / 1e6:.1f} million particle-steps/s, {now.remaining_time} left"


def bar(total: int, name: str, unit: str, quiet: bool = False, done: int = 0) -> tqdm:
    """Return a progress bar that appears only on terminals and in notebooks."""
    kind, in_notebook = tqdm, "ipykernel" in sys.modules
    if in_notebook:
        from tqdm.auto import tqdm as kind
    return kind(
        total=total,
        initial=done,
        desc=name,
        unit=unit,
        unit_scale=True,
        disable=quiet or not (in_notebook or sys.stderr.isatty()),
    )
