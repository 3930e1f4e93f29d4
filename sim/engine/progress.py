"""How far a run is: a bar on a terminal, log lines elsewhere, a small file beside the output."""

import logging
import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from time import monotonic

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, ValidationError
from tqdm import tqdm

from sim.base.files import read_regular
from sim.base.words import duration
from sim.parameters import Parameters, point_id

log = logging.getLogger("talus")

#: Seconds to the first log line about progress. Each pause is twice the one before, up to the
#: longest.
FIRST_PAUSE = 10.0
LONGEST_PAUSE = 300.0

#: Least number of seconds between two writes of the progress file.
WRITE_INTERVAL = 2.0

#: Seconds for which a progress file stands for a run on a machine that cannot be asked. Samples
#: that take long stretch it.
CREDIT = 120.0
CREDIT_SAMPLES = 3


#: Largest number that a progress file may hold; beyond it something else has written it.
MOST = 10**18


class Progress(BaseModel):
    """What a progress file says: how far a run was when it was written.

    Attributes
    ----------
    point : str
        Id of the point.
    done, total : int
        Steps over all replicates, without settling.
    at_most : bool
        The run may end before its total: when its mean velocity is known well enough.
    particles : int
        Particles of the run.
    rate : float
        Particle-steps per second, mean since the first sample of this process: what comes before
        it, loading and the settling of a bed, says nothing about the rest.
    elapsed : float
        Seconds since then, by a clock that nobody sets.
    started, updated : datetime
        When this process started on the point, and when this was written.
    expires : datetime
        Until when another machine should believe that the run goes on.
    pid, host : int, str
        The process and its machine.
    """

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    point: str
    done: int = Field(ge=0, le=MOST)
    total: int = Field(gt=0, le=MOST)
    at_most: bool
    particles: int = Field(gt=0, le=MOST)
    rate: float = Field(ge=0, le=MOST)
    elapsed: float = Field(ge=0, le=MOST)
    started: AwareDatetime
    updated: AwareDatetime
    expires: AwareDatetime
    pid: int = Field(gt=0, lt=2**31)
    host: str

    @property
    def percent(self) -> int:
        """Percentage of the total that is done, 100 only at the end."""
        return min(100, 100 * self.done // self.total)

    @property
    def left(self) -> float | None:
        """Expected seconds to the total; none as long as nothing has been done."""
        if self.rate == 0:
            return None
        return max(0, self.total - self.done) * self.particles / self.rate

    @property
    def time_left(self) -> str:
        """`left` in words."""
        if self.left is None:
            return "unknown"
        return f"{'at most' if self.at_most else 'about'} {duration(self.left)}"


def may_end_early(parameters: Parameters) -> bool:
    """Return whether a run may end before its total, once its mean velocity is known."""
    return parameters.longest_samples > parameters.shortest_samples


def length(parameters: Parameters) -> str:
    """Say how many steps all replicates of a point take, or take at most."""
    bound = "at most " if may_end_early(parameters) else ""
    return f"{bound}{parameters.replicates * parameters.steps:,} steps"


def progress_file(output: Path) -> Path:
    """Return the path of the progress file of the run that will write ``output``."""
    return output.with_name(f".{output.name}.progress")


def read_progress(output: Path) -> Progress | None:
    """Return the progress of the run that will write ``output``; none without a readable file."""
    try:
        return Progress.model_validate_json(read_regular(progress_file(output)))
    except (OSError, ValidationError):
        return None


@contextmanager
def progress(
    parameters: Parameters, output: Path, quiet: bool = False, done: int = 0
) -> Iterator[Callable[[int], None]]:
    """Yield a function that is told the number of steps of every advance.

    Parameters
    ----------
    parameters : Parameters
        The point.
    output : Path
        The run file to be; the progress file lies beside it until the block ends, and stays after a
        ``SystemExit``, for the next start to replace.
    quiet : bool
        Neither bar nor log lines.
    done : int
        Steps that lie behind a run that resumes.
    """
    meter = _Meter(parameters, done)
    name = f"{meter.point} (at most)" if meter.at_most else meter.point
    shown = bar(meter.total, name, "step", quiet, meter.done)
    file = progress_file(output)
    written, lines = meter.start, _LogLines(meter.start)
    _write(file, meter.read())

    def advanced(steps: int) -> None:
        nonlocal written
        now = meter.advance(steps)
        shown.update(steps)
        if now - written >= WRITE_INTERVAL:
            written = now
            _write(file, meter.read())
        if shown.disable and not quiet and lines.is_due(now):
            log.info(meter.line())

    try:
        with shown:
            yield advanced
    except SystemExit:
        # Terminated after a checkpoint: interrupted, and so it shall be seen.
        raise
    except BaseException:
        _remove(file)
        raise
    _remove(file)


class _Meter:
    """Steps done and the time they took, by a clock that nobody sets."""

    def __init__(self, parameters: Parameters, done: int):
        self.point = point_id(parameters)
        self.length = length(parameters)
        self.at_most = may_end_early(parameters)
        self.particles = parameters.particles
        self.total = parameters.replicates * parameters.steps
        self.done = done
        self.started = datetime.now(UTC)
        self.start = self.latest = monotonic()
        self.longest = 0.0
        self.samples = 0
        self.reference = (done, self.start)

    def advance(self, steps: int) -> float:
        """Count steps; return the present time (s)."""
        now = monotonic()
        if self.samples == 1:
            self.reference = (self.done, self.latest)
        self.samples += 1
        self.done += steps
        self.longest = max(self.longest, now - self.latest)
        self.latest = now
        return now

    def read(self) -> Progress:
        """Return the present contents of the progress file."""
        steps, seconds = self.done - self.reference[0], self.latest - self.reference[1]
        now = datetime.now(UTC)
        credit = max(CREDIT, CREDIT_SAMPLES * self.longest)
        return Progress(
            point=self.point,
            done=self.done,
            total=self.total,
            at_most=self.at_most,
            particles=self.particles,
            # The first sample includes loading, and compiling where that is still to be done.
            rate=steps * self.particles / seconds if self.samples > 1 and seconds > 0 else 0.0,
            elapsed=self.latest - self.start,
            started=self.started,
            updated=now,
            expires=now + timedelta(seconds=credit),
            pid=os.getpid(),
            host=socket.gethostname(),
        )

    def line(self) -> str:
        """Return the line for the log."""
        now = self.read()
        done = f"{now.point}: {now.percent} % of {self.length}"
        if now.left is None:
            return done
        return f"{done}, {now.rate / 1e6:.1f} million particle-steps/s, {now.time_left} left"


def bar(total: int, name: str, unit: str, quiet: bool = False, done: int = 0) -> tqdm:
    """Return a bar that appears on terminals and in notebooks alone."""
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


class _LogLines:
    """When log lines about progress are due: ever more rarely, see `FIRST_PAUSE`."""

    def __init__(self, start: float):
        self.pause = FIRST_PAUSE
        self.due = start + self.pause

    def is_due(self, now: float) -> bool:
        """Return whether a line is due at a time (s); if so, the next one is after a pause."""
        if now < self.due:
            return False
        self.pause = min(2 * self.pause, LONGEST_PAUSE)
        self.due = now + self.pause
        return True


def _remove(file: Path) -> None:
    for path in (file, _temporary(file)):
        with suppress(OSError):
            path.unlink(missing_ok=True)


def _temporary(file: Path) -> Path:
    return file.with_name(f"{file.name}.part")


def _write(file: Path, now: Progress) -> None:
    """Replace the progress file. That it cannot be written must not end a run.

    It need not survive a power cut, so nothing waits for the disk.
    """
    with suppress(OSError):
        _temporary(file).write_text(now.model_dump_json(indent=2) + "\n")
        _temporary(file).replace(file)
