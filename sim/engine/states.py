"""The states of a run's replicates in one file, to continue a run that was killed or too short."""

import io
import json
import logging
import os
import signal
import threading
import time
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any, Self

import numpy as np

from sim.base.errors import InputError
from sim.base.files import atomic_write, is_of_system, open_regular
from sim.base.numbers import number
from sim.base.seals import is_damaged, seal, set_aside
from sim.engine.identity import NUMERICS
from sim.engine.stored_run import is_alike
from sim.parameters import Parameters, point_id

#: Arrays and numbers by path in a nested structure, such as ``spheres.position``. A state is stored
#: as such data alone, and a new structure supplies the types of the containers: so the content of a
#: file can become numbers of a flow and nothing else.
FlatState = dict[str, Any]

_PLAIN = (bool, int, float, str, np.generic)


def flatten(structure: Any) -> FlatState:
    """Return all arrays and numbers of nested tuples, lists and dictionaries, by path."""
    if isinstance(structure, (np.ndarray, *_PLAIN)):
        return {"": structure.item() if isinstance(structure, np.generic) else structure}
    return {
        f"{name}.{path}" if path else str(name): value
        for name, part in _parts(structure).items()
        for path, value in flatten(part).items()
    }


def _parts(value: Any) -> Mapping[Any, Any]:
    if isinstance(value, dict):
        return value
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return value._asdict()
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    raise TypeError(f"{type(value).__name__} is not kept in states")


def subtree(path: str, values: Mapping[str, Any]) -> FlatState:
    """Return the values whose paths begin with ``path``, named by the rest of their paths."""
    prefix = f"{path}."
    return {name[len(prefix) :]: values[name] for name in values if name.startswith(prefix)}


def refill(structure: Any, values: Mapping[str, Any], growing_axis: int = -1) -> Any:
    """Return a structure of the same kind that holds other arrays and numbers.

    An array that occurs at two paths of the structure is one array in the result, too. Arrays may
    be longer or shorter along ``growing_axis``, as those of contacts are when their number changes.
    Raises `ValueError` when ``values`` has other paths than the structure, or an array there has
    another type or other lengths.
    """
    left, arrays = dict(values), dict[int, Any]()

    def fill(part: Any, path: str) -> Any:
        if isinstance(part, (np.ndarray, *_PLAIN)):
            if path not in left or _kind(part, growing_axis) != _kind(left[path], growing_axis):
                raise ValueError(f"{path} is not as in the system")
            new = left.pop(path)
            return arrays.setdefault(id(part), new) if isinstance(part, np.ndarray) else new
        filled = {
            name: fill(one, f"{path}.{name}" if path else str(name))
            for name, one in _parts(part).items()
        }
        if isinstance(part, dict):
            return filled
        return type(part)(**filled) if hasattr(part, "_asdict") else type(part)(filled.values())

    whole = fill(structure, "")
    if left:
        raise ValueError(f"{min(left)} is not in the system")
    return whole


def _kind(value: Any, growing_axis: int) -> tuple[Any, ...]:
    """Return the type of a value and, of an array, its lengths but for the growing axis."""
    if not isinstance(value, np.ndarray):
        return (str if isinstance(value, str) else float,)
    before, after = value.shape[:growing_axis], value.shape[growing_axis:]
    return value.dtype, value.ndim, before + after[1:]


log = logging.getLogger("talus")

#: A signal handler of Python.
_Handler = Callable[[int, FrameType | None], Any] | int | None

#: Seconds between two checkpoints, unless TALUS_CHECKPOINT_SECONDS says otherwise.
INTERVAL = 120.0

#: Largest share of the wall time that writing checkpoints may take.
SHARE = 0.05

#: Exit code of a process that was ended by SIGTERM.
TERMINATION_CODE = 128 + signal.SIGTERM

#: Version of the file layout.
FORMAT = 3

#: Name of the archive member with the numbers of a state; the other members are arrays.
_NUMBERS = "numbers.json"


def checkpoint_interval() -> float:
    """Return the seconds between two checkpoints, as set in the environment."""
    name = "TALUS_CHECKPOINT_SECONDS"
    text = os.environ.get(name) or str(INTERVAL)
    with suppress(ValueError):
        if (seconds := number(text)) >= 0.0:
            return seconds
    raise InputError.of_value("environment", name, text, "a number of seconds >= 0")


def pack(state: FlatState) -> bytes:
    """Return a state as a compressed archive of its arrays and a JSON text of its numbers."""
    buffer = io.BytesIO()
    numbers = {name: value for name, value in state.items() if not isinstance(value, np.ndarray)}
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(_NUMBERS, json.dumps(numbers))
        for name in state.keys() - numbers.keys():
            with archive.open(name, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, state[name], allow_pickle=False)
    return buffer.getvalue()


def unpack(archive: bytes) -> FlatState:
    """Return the state in an archive."""
    with np.load(io.BytesIO(archive)) as file:
        state = {name: file[name] for name in file.files}
    return json.loads(state.pop(_NUMBERS)) | state


def _samples(archive: bytes) -> int:
    """Return the number of samples in an archive, without reading its arrays."""
    with np.load(io.BytesIO(archive)) as file:
        return json.loads(file[_NUMBERS])["told.shown"]


def state_file(output: Path) -> Path:
    """Return the path of the states of the run that writes ``output``."""
    return output.with_name(f".{output.name}.state")


class States:
    """The file ``.<output>.state`` beside the output of a run.

    The first line is JSON with the point, the numerics and the sizes of the archives. Then follow
    one archive per replicate and the seal. The file is written from time to time during the run and
    stays when the run is done. Used as a context, it makes SIGTERM (by which batch systems announce
    the end) save the states and end the process when a replicate is next offered. Before the first
    offer SIGTERM ends the process at once.

    ``interval`` are the seconds of wall time between two writes. A run that starts from the end of
    another one has as its ``origin`` the number of samples of each replicate of that run
    (`sim.engine.replicate`). Where ``is_own``, this process runs the point: states that are damaged
    or of another run are set aside; else they are an error.
    """

    def __init__(
        self,
        output: Path,
        parameters: Parameters,
        interval: float = INTERVAL,
        origin: Sequence[int] = (),
        is_own: bool = True,
    ):
        self.path = state_file(output)
        self.interval = interval
        self._identity = {"format": FORMAT, "numerics": NUMERICS, "point": point_id(parameters)}
        self._origin = list(origin)
        self._is_own = is_own
        self._next_write = time.monotonic() + interval
        self._is_terminated = False
        self._has_started = False
        self._previous_handler: _Handler = None
        self._archives = self._load()

    def __enter__(self) -> Self:
        # Only the main thread may set signal handlers.
        if threading.current_thread() is threading.main_thread():
            self._previous_handler = signal.signal(signal.SIGTERM, self._terminate)
        return self

    def __exit__(self, *_: object) -> None:
        if self._previous_handler is not None:
            signal.signal(signal.SIGTERM, self._previous_handler)

    def _terminate(self, *_: object) -> None:
        self._is_terminated = True
        # During the first compilation there is nothing to save.
        if not self._has_started:
            raise SystemExit(TERMINATION_CODE)

    def archive(self, number: int) -> bytes | None:
        """Return the packed state of a replicate, None where none is stored."""
        return self._archives.get(number)

    def samples(self, numbers: Iterable[int]) -> list[int]:
        """Return the numbers of samples in the states of those replicates that have one."""
        return [_samples(self._archives[number]) for number in numbers if number in self._archives]

    def offer(self, replicate: Any) -> None:
        """Write the states if it is time; an error of the file system is only a warning.

        ``replicate`` has a ``number`` and gives all that is needed to continue it by ``state()``.
        Called at least every few tenths of a second of a replicate's running time. Raises
        ``SystemExit`` after SIGTERM.
        """
        self._has_started = True
        start = time.monotonic()
        if start < self._next_write and not self._is_terminated:
            return
        self.keep(replicate)
        if self._is_terminated:
            self.check_signals()
        self.save()
        end = time.monotonic()
        self._next_write = end + max(self.interval, (end - start) / SHARE)

    def check_signals(self) -> None:
        """Save the states and raise ``SystemExit`` after SIGTERM; else do nothing."""
        if self._is_terminated:
            self.save()
            log.warning("%s: terminated; the next start continues from here", self.path)
            raise SystemExit(TERMINATION_CODE)

    def keep(self, replicate: Any) -> None:
        """Add the present state of a replicate to the states that will be written."""
        self._archives[replicate.number] = pack(replicate.state())

    def save(self) -> None:
        """Write all states, completely or not at all; an error of the file system is a warning."""
        archives = dict(sorted(self._archives.items()))
        sizes = {number: len(archive) for number, archive in archives.items()}
        header = json.dumps(self._identity | {"sizes": sizes, "origin": self._origin}).encode()
        try:
            with atomic_write(self.path) as temporary:
                with temporary.open("wb") as file:
                    file.writelines([header, b"\n", *archives.values()])
                seal(temporary)
        except OSError as error:
            log.warning("%s: no states are kept: %s", self.path, error.strerror or error)

    def _load(self) -> dict[int, bytes]:
        """Return the archives of the file by replicate, empty where there is no file.

        A file that is damaged or belongs to another run is set aside with a warning.
        """
        try:
            if is_damaged(self.path):
                raise ValueError("damaged or no states of a run: the checksum is wrong")
            with open_regular(self.path) as file:
                header = json.loads(file.readline())
                self._require_own(header)
                return {int(number): file.read(size) for number, size in header["sizes"].items()}
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            if is_of_system(error):
                raise
            reason = error.strerror if isinstance(error, OSError) else error
            if not self._is_own:
                raise InputError(f"{self.path}: {reason}") from None
            new_path, _ = set_aside(self.path)
            log.warning("%s: %s; set aside as %s", self.path, reason, new_path)
            return {}

    def _require_own(self, header: Mapping[str, Any]) -> None:
        """Raise ``ValueError`` where the first line is not that of this run."""
        for key, value in self._identity.items():
            if header.get(key) != value:
                raise ValueError(f"states of other {key}")
        if not is_alike(header.get("origin", []), self._origin):
            raise ValueError("states from before the run that they start from went on")


def stored_samples(output: Path, parameters: Parameters) -> list[int]:
    """Return the samples in the states of a point's replicates beside its run file.

    It is empty where no state can be used. Raises ``OSError`` where the system does not give the
    bytes of the file.
    """
    with suppress(InputError):
        return States(output, parameters, is_own=False).samples(range(parameters.replicates))
    return []
