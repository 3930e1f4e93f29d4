"""Processes of the program, and waiting for their effects.

A busy machine may take any time, so tests wait for an effect or for the end of the processes.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from sim.__main__ import main
from sim.parameters import Parameters, canonical_values

ROOT = Path(__file__).parents[2]

#: Seconds after which a process counts as hanging, on any machine.
HANG = 3600.0


def wait_until(is_so: Callable[[], bool], *processes: subprocess.Popen) -> None:
    """Wait until ``is_so()`` is true; fail if all the processes end before."""
    while not is_so():
        if processes and all(process.poll() is not None for process in processes):
            assert is_so(), "ended before it happened"
        time.sleep(0.02)


def program(*words: str, **options) -> subprocess.CompletedProcess:
    """Run ``python -m sim`` to its end; return the finished process with its output."""
    options = {"capture_output": True, "text": True, "timeout": HANG} | options
    return subprocess.run([sys.executable, "-m", "sim", *words], cwd=ROOT, **options)


def refusal(capsys, *words: object) -> str:
    """Run a command that must be refused with code 2; return its one line on standard error."""
    capsys.readouterr()
    assert main(list(map(str, words))) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    return line


def run_command(output: Path) -> list[str]:
    """Return the command that runs a point from the standard input into a file."""
    return [sys.executable, "-m", "sim", "run", "-", "--output", str(output)]


def start_run(parameters: Parameters, output: Path, **options) -> subprocess.Popen:
    """Start the run of a point in a process of its own, whose messages can be read."""
    process = subprocess.Popen(
        run_command(output),
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )
    process.stdin.write(json.dumps(canonical_values(parameters)))
    process.stdin.close()
    process.stdin = None
    return process


def in_process(folder: Path, lines: str) -> None:
    """Run lines of Python in a folder, in a new process, whose engine has no earlier additions."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "TALUS_CACHE_DIR": str(folder / "cache")}
    command = [sys.executable, "-c", lines]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
