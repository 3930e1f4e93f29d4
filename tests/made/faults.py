"""Commands in forks of one process, in which a chosen call on a file goes wrong.

``python -m tests.made.faults`` is that process, with the library of ``faults.c`` preloaded. It
reads a line of JSON for each command, and answers with one.
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import IntEnum, IntFlag
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

import pytest

from tests.made.processes import ROOT

LIBRARY = "libfaults.so"


class Calls(IntFlag):
    """Kinds of calls on files, as in ``faults.c``; those that change names and folders write."""

    OPEN, READ, WRITE, STATUS = 1, 2, 4, 8


class What(IntEnum):
    """What becomes of the chosen call; ``SHORT`` reads or writes half of it."""

    FAIL, SHORT, DELAY, KILL = range(4)


class Fault(NamedTuple):
    """A call that goes wrong: the ``at``-th of some kinds, and all later ones where ``lasting``.

    ``number`` is that of the error, or the milliseconds of a delay.
    """

    what: What
    at: int
    calls: Calls = ~Calls(0)
    number: int = 0
    lasting: bool = False


class Outcome(NamedTuple):
    """Exit code of a command, the numbers of its calls on files by kind, and what it printed."""

    code: int
    calls: dict[Calls, int]
    output: str
    error: str


#: Nothing goes wrong, and calls are counted.
PEACE = Fault(What.DELAY, 2**31 - 1)


class Commands:
    """The process that runs commands, and the folder of which it counts the calls."""

    def __init__(self, folder: Path, server: subprocess.Popen):
        self.folder, self._server = folder, server

    def run(self, words: Sequence[str], fault: Fault = PEACE, stdin: str = "") -> Outcome:
        """Run a command in the folder, with a fault."""
        order = {"words": list(map(str, words)), "fault": fault, "stdin": stdin}
        self._server.stdin.write(json.dumps(order | {"folder": str(self.folder)}) + "\n")
        self._server.stdin.flush()
        answer = self._server.stdout.readline()
        assert answer, "the process of the commands has ended"
        code, calls, *said = json.loads(answer)
        return Outcome(code, dict(zip(Calls, calls, strict=True)), *said)


def build_library(room: Path) -> Path:
    """Compile the library into a folder, and return its path. Skip without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not (compiler and sys.platform == "linux"):
        pytest.skip("calls are intercepted by a library for Linux, which a C compiler makes")
    library = room / LIBRARY
    source = Path(__file__).with_suffix(".c")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    return library


class Seams:
    """A command that is killed at each seam: after every file that it names or removes.

    Each name in ``folder`` counts once, if it contains ``only``. With ``alone`` the process that
    named the file is killed, else its whole group, as when a machine loses its power. ``room``,
    another folder, gets the library and the names.
    """

    def __init__(self, folder: Path, room: Path, *, alone: bool, only: str = ""):
        self.folder, self._log, self._list = folder, room / "seams.log", room / "seams.txt"
        self._list.touch()
        self._options = {"FAULTS_SEAMS": str(self._list), "FAULTS_FOLDER": f"{folder}/"}
        self._options |= {"LD_PRELOAD": str(build_library(room)), "TALUS_CHECKPOINT_SECONDS": "0"}
        self._options |= {"PYTHONPATH": str(ROOT)} | ({"FAULTS_ALONE": "1"} if alone else {})
        self._options |= {"FAULTS_ONLY": only} if only else {}

    @property
    def names(self) -> list[str]:
        """Return the files at which processes were killed so far."""
        return self._list.read_text().splitlines()

    def run(self, *words: str) -> str:
        """Give a command of the program again and again, until no process of it was killed.

        Return what it said in the end. It may fail only where one of its processes was killed.
        """
        while True:
            before = len(self.names)
            with self._log.open("w") as log:
                code = subprocess.Popen(
                    [sys.executable, "-m", "sim", *words],
                    cwd=self.folder,
                    env=os.environ | self._options,
                    stdout=log,
                    stderr=log,
                    start_new_session=True,
                ).wait()
            said, seams = self._log.read_text(), self.names[before:]
            assert "Traceback" not in said, f"{said} after {seams or self.names[-1:]}"
            if not seams:
                assert code == 0, f"{said} after {self.names[-1:]}"
                return said


@contextmanager
def faulty_commands(folder: Path, room: Path) -> Iterator[Commands]:
    """Start the process; ``room``, another folder, gets the library. Skip without a compiler."""
    library = build_library(room)
    server = subprocess.Popen(
        [sys.executable, "-m", "tests.made.faults"],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"LD_PRELOAD": str(library), "TALUS_CHECKPOINT_SECONDS": "0"},
    )
    try:
        yield Commands(folder, server)
    finally:
        server.stdin.close()
        server.wait()


def serve() -> None:
    """Run the commands of the standard input, each in a fork."""
    library = ctypes.CDLL(os.environ.pop("LD_PRELOAD"))
    for line in sys.stdin:
        order = json.loads(line)
        what, at, calls, number, lasting = order["fault"]
        names = [Path(order["folder"]).parent / f"{name}.txt" for name in ("out", "error", "in")]
        names[2].write_text(order["stdin"])
        library.faults_arm(os.fsencode(order["folder"]), calls, what, number, at, int(lasting))
        child = os.fork()
        if not child:
            _become(order, names)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        calls = [library.faults_calls(kind) for kind in Calls]
        answer = [code, calls, *(path.read_text(errors="replace") for path in names[:2])]
        print(json.dumps(answer), flush=True)


def _become(order: dict[str, Any], names: Sequence[Path]) -> None:
    """Run a command in this process and end it."""
    from sim.__main__ import main

    for number, path in zip((1, 2, 0), names, strict=True):
        flags = os.O_RDONLY if not number else os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        os.dup2(os.open(path, flags), number)
    sys.stdin = os.fdopen(0, closefd=False)
    code = 70
    try:
        os.chdir(order["folder"])
        code = main(order["words"])
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code or 0)


def _import_all() -> None:
    """Import and compile what commands need, so that each fork has it."""
    import sklearn.gaussian_process  # noqa: F401

    import sim.surrogates.inquiries  # noqa: F401
    from sim.base.command_line import COMMANDS, JOBS
    from sim.engine.command import _compile
    from sim.parameters import BeltParameters
    from sim.study.validate import file_models

    for function, *_ in (*COMMANDS.values(), *JOBS.values()):
        resolve_name(function)
    file_models()
    _compile([BeltParameters(beads=10, width=5)])


if __name__ == "__main__":
    _import_all()
    serve()
