"""The complete state of an unfinished run in one file, from which the next start continues."""

import json
import logging
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any, BinaryIO, Self

from sim import __version__
from sim.base.errors import InputError
from sim.base.files import is_damaged, remove_left, replacing, seal, set_aside
from sim.engine.identity import library_versions, source_hash
from sim.parameters import Parameters, canonical

log = logging.getLogger("talus")

#: What Python does on a signal.
_Handler = Callable[[int, FrameType | None], Any] | int | None

#: Seconds between two checkpoints, unless TALUS_CHECKPOINT_SECONDS says otherwise.
INTERVAL = 120.0

#: Largest share of the wall time that writing checkpoints may take.
SHARE = 0.05

#: Exit code of a process that SIGTERM has ended.
TERMINATED = 128 + signal.SIGTERM

#: Number of this layout of the file, and most bytes of its first line.
FORMAT = 2
LONGEST = 16384


def checkpoint_interval() -> float:
    """Return the seconds between two checkpoints that the environment asks for."""
    name = "TALUS_CHECKPOINT_SECONDS"
    text = os.environ.get(name) or str(INTERVAL)
    with suppress(ValueError):
        if (seconds := float(text)) >= 0.0:
            return seconds
    raise InputError.of_value("environment", name, text, "a number of seconds >= 0")


class Checkpoint:
    """The file ``.<output>.checkpoint`` beside the output of a run.

    A line of JSON names what the state belongs to; the state follows as a pickle, then the seal. As
    a context, a checkpoint makes SIGTERM end the process when a state is next offered, after saving
    it: that is how batch systems ask first.

    Parameters
    ----------
    output : Path
        The run file to be.
    parameters : Parameters
        The point; a state of another one is not accepted.
    interval : float
        Seconds of wall time between two checkpoints.
    """

    def __init__(self, output: Path, parameters: Parameters, interval: float = INTERVAL):
        self.path = output.with_name(f".{output.name}.checkpoint")
        self.interval = interval
        self._identity = {
            "format": FORMAT,
            "talus": __version__,
            "source hash": source_hash(),
            "libraries": library_versions(),
            "parameters": canonical(parameters),
        }
        self._due = time.monotonic() + interval
        self._terminated = False
        self._before: _Handler = None

    def __enter__(self) -> Self:
        # Only the main thread may say what signals do.
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGTERM, self._terminate)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGTERM, self._before)

    def _terminate(self, *_: object) -> None:
        self._terminated = True

    def offer(self, state: Any) -> None:
        """Save the state if it is time. A checkpoint that cannot be written stops no run.

        Raises ``SystemExit`` after SIGTERM.
        """
        began = time.monotonic()
        if began < self._due and not self._terminated:
            return
        try:
            self.save(state)
        except OSError as error:
            log.warning("%s: no checkpoint: %s", self.path, error.strerror or error)
        if self._terminated:
            log.warning("%s: terminated; the next start continues from here", self.path)
            raise SystemExit(TERMINATED)
        ended = time.monotonic()
        self._due = ended + max(self.interval, (ended - began) / SHARE)

    def save(self, state: Any) -> None:
        """Write the state, complete or not at all."""
        with replacing(self.path) as temporary:
            with temporary.open("wb") as file:
                file.write(json.dumps(self._identity).encode() + b"\n")
                pickle.dump(state, file, protocol=5)
            seal(temporary)

    def load(self) -> Any:
        """Return the state that was saved, or nothing where there is none.

        A file that is damaged or belongs to another run is set aside with a warning.
        """
        try:
            file = self.path.open("rb")
        except FileNotFoundError:
            return None
        with file:
            objection = self._objection(file)
            if not objection:
                try:
                    return pickle.load(file)
                except (pickle.PickleError, EOFError, LookupError, TypeError, ValueError) as error:
                    objection = f"cannot be unpacked ({error})"
        aside = set_aside(self.path)
        log.warning("%s: %s; set aside as %s, the run starts anew", self.path, objection, aside)
        return None

    def remove(self) -> None:
        """Remove the file and what was left of attempts to write it."""
        self.path.unlink(missing_ok=True)
        remove_left(self.path)

    def _objection(self, file: BinaryIO) -> str:
        """Read up to the state; say why it is not one of this run, or nothing if it is."""
        try:
            header = json.loads(file.readline(LONGEST))
            differ = [key for key, value in self._identity.items() if header.get(key) != value]
        except (ValueError, AttributeError):
            return "damaged or not a checkpoint"
        if differ:
            return f"a checkpoint of other {differ[0]}"
        if is_damaged(self.path, must_be_sealed=True):
            return "damaged: the checksum is wrong"
        return ""
