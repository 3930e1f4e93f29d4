"""The states of a run's replicates in one file, from which it goes on when killed or too short."""

import io
import json
import logging
import os
import signal
import threading
import time
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, BinaryIO, Self

import numpy as np

from sim.base.errors import InputError
from sim.base.files import is_damaged, open_regular, replacing, seal, set_aside
from sim.engine.flatten import FlatState
from sim.engine.identity import NUMERICS
from sim.parameters import Parameters, point_id

if TYPE_CHECKING:
    from sim.engine.replicate import Replicate

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
FORMAT = 3
LONGEST = 65536

#: Where the numbers of a state are, among its arrays.
_NUMBERS = "numbers.json"


def checkpoint_interval() -> float:
    """Return the seconds between two checkpoints that the environment asks for."""
    name = "TALUS_CHECKPOINT_SECONDS"
    text = os.environ.get(name) or str(INTERVAL)
    with suppress(ValueError):
        if (seconds := float(text)) >= 0.0:
            return seconds
    raise InputError.of_value("environment", name, text, "a number of seconds >= 0")


def packed(state: FlatState) -> bytes:
    """Return a state as a compressed archive of its arrays and a JSON text of its numbers."""
    buffer = io.BytesIO()
    numbers = {name: value for name, value in state.items() if not isinstance(value, np.ndarray)}
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(_NUMBERS, json.dumps(numbers))
        for name in state.keys() - numbers.keys():
            with archive.open(name, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, state[name], allow_pickle=False)
    return buffer.getvalue()


def numbers(archive: bytes) -> dict[str, Any]:
    """Return the numbers of a state that was packed, none where it was not."""
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as file:
            return json.loads(file.read(_NUMBERS))
    except (zipfile.BadZipFile, LookupError, ValueError):
        return {}


def unpacked(archive: bytes) -> FlatState:
    """Return the state that was packed; raises ``ValueError`` when that was none."""
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as file:
            state = json.loads(file.read(_NUMBERS))
            for name in file.namelist():
                if name != _NUMBERS:
                    with file.open(name) as member:
                        state[name] = np.lib.format.read_array(member, allow_pickle=False)
    except (zipfile.BadZipFile, LookupError, EOFError) as error:
        raise ValueError(str(error)) from None
    return state


class States:
    """The file ``.<output>.state`` beside the output of a run.

    A line of JSON names point, numerics and the sizes of what follows: one archive per replicate,
    then the seal. It is written now and then while the run is under way, and stays when the run is
    done. As a context, it makes SIGTERM end the process when a replicate is next offered, after
    saving it, or at once before the first offer: that is how batch systems ask first.

    Parameters
    ----------
    output : Path
        The run file.
    parameters : Parameters
        The point; states of another one are not accepted.
    interval : float
        Seconds of wall time between two writes.
    origin : sequence of int
        For runs that start from another's end, how many samples that had (`sim.engine.origin`).
    own : bool
        Whether the run is that of this process, which sets damaged states aside; of another's it is
        an error that they are.
    """

    def __init__(
        self,
        output: Path,
        parameters: Parameters,
        interval: float = INTERVAL,
        origin: Sequence[int] = (),
        own: bool = True,
    ):
        self.path = output.with_name(f".{output.name}.state")
        self.interval = interval
        self._identity = {"format": FORMAT, "numerics": NUMERICS, "point": point_id(parameters)}
        self._origin = list(origin)
        self._own = own
        self._due = time.monotonic() + interval
        self._terminated = False
        self._under_way = False
        self._before: _Handler = None
        self._archives = self._load()

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
        # Loops that are being compiled for the first time hold nothing to save.
        if not self._under_way:
            raise SystemExit(TERMINATED)

    def replicate(self, parameters: Parameters, number: int) -> "Replicate | None":
        """Return a replicate as far as it is known, to be run to the lengths of ``parameters``.

        None where nothing is known of it, or what is known is none of this program's states.
        """
        # Who asks for the interval alone, as every start of the workflow, waits for no numba.
        from sim.engine.replicate import Replicate

        archive = self._archives.get(number)
        if archive is None:
            return None
        try:
            return Replicate.restored(parameters, number, unpacked(archive))
        except (ValueError, TypeError, LookupError) as error:
            log.warning("%s: replicate %d starts anew: %s", self.path, number, error)
            return None

    def __contains__(self, number: int) -> bool:
        """Return whether something is known of a replicate."""
        return number in self._archives

    def samples(self, number: int) -> int:
        """Return how many samples of a replicate are known."""
        return numbers(self._archives[number]).get("told.shown", 0)

    def offer(self, replicate: "Replicate") -> None:
        """Write the states if it is time. That it cannot be done stops no run.

        Raises ``SystemExit`` after SIGTERM.
        """
        self._under_way = True
        began = time.monotonic()
        if began < self._due and not self._terminated:
            return
        self.keep(replicate)
        if self._terminated:
            self.heed()
        self.save()
        ended = time.monotonic()
        self._due = ended + max(self.interval, (ended - began) / SHARE)

    def heed(self) -> None:
        """Save and raise ``SystemExit`` after SIGTERM."""
        if self._terminated:
            self.save()
            log.warning("%s: terminated; the next start continues from here", self.path)
            raise SystemExit(TERMINATED)

    def keep(self, replicate: "Replicate") -> None:
        """Take the present state of a replicate into what will be written."""
        self._archives[replicate.number] = packed(replicate.state())

    def save(self) -> None:
        """Write all states, complete or not at all; that it cannot be done is a warning."""
        try:
            self._write()
        except OSError as error:
            log.warning("%s: no states are kept: %s", self.path, error.strerror or error)

    def _write(self) -> None:
        sizes = {number: len(archive) for number, archive in sorted(self._archives.items())}
        with replacing(self.path) as temporary:
            with temporary.open("wb") as file:
                header = self._identity | {"sizes": sizes, "origin": self._origin}
                file.write(json.dumps(header).encode() + b"\n")
                for number in sizes:
                    file.write(self._archives[number])
            seal(temporary)

    def _load(self) -> dict[int, bytes]:
        """Return the archives of the file by replicate, none where there is no file.

        One that is damaged or belongs to another run is set aside with a warning.
        """
        try:
            with open_regular(self.path) as file:
                sizes = self._sizes(file)
                return {int(number): file.read(size) for number, size in sizes.items()}
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            if not self._own:
                raise InputError(f"{self.path}: {reason}") from None
            aside = set_aside(self.path)
            log.warning("%s: %s; set aside as %s", self.path, reason, aside)
            return {}

    def _sizes(self, file: BinaryIO) -> dict[str, int]:
        """Read up to the archives and return their sizes; raise ``ValueError`` where they are not
        of this run."""
        try:
            header = json.loads(file.readline(LONGEST))
            differ = [key for key, value in self._identity.items() if header.get(key) != value]
        except (ValueError, AttributeError):
            raise ValueError("damaged or no states of a run") from None
        if differ:
            raise ValueError(f"states of other {differ[0]}")
        known = zip(header.get("origin", []), self._origin, strict=False)
        if any(one != other for one, other in known):
            raise ValueError("states from before the run that they start from went on")
        if is_damaged(self.path):
            raise ValueError("damaged: the checksum is wrong")
        return header["sizes"]
