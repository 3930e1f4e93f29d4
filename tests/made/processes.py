"""Processes of the program, waiting for their effects, and plug-ins that tests remove again.

A busy machine may take any time, so tests wait for an effect or for the end of the processes.
"""

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager
from pathlib import Path
from subprocess import CompletedProcess

import psutil

from sim.__main__ import main
from sim.base import additions, plugins
from sim.parameters import Parameters, canonical_values

ROOT = Path(__file__).parents[2]

#: What lets numba compile for processors with vectors of four numbers, as laptops have.
SHORTER_VECTORS = {"NUMBA_CPU_NAME": "skylake", "NUMBA_CPU_FEATURES": ""}

#: Seconds after which a process counts as hanging, on any machine.
HANG = 3600.0


def wait_until(is_so: Callable[[], bool], *processes: subprocess.Popen) -> None:
    """Wait until ``is_so()`` is true; fail if all the processes end before."""
    while not is_so():
        if processes and all(process.poll() is not None for process in processes):
            assert is_so(), "ended before it happened"
        time.sleep(0.02)


def is_alive(number: int) -> bool:
    """Return whether a process goes on; one that has ended may wait for someone to ask."""
    try:
        return psutil.Process(number).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def program(*words: str, **options) -> subprocess.CompletedProcess:
    """Run ``python -m sim`` to its end; return the finished process with its output."""
    options = {"cwd": ROOT, "capture_output": True, "text": True, "timeout": HANG} | options
    return subprocess.run([sys.executable, "-m", "sim", *words], **options)


def refusal(capsys, *words: object) -> str:
    """Run a command that must be refused with code 2; return its one line on standard error."""
    capsys.readouterr()
    assert main(list(map(str, words))) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    return line


def start_run(parameters: Parameters, output: Path, **options) -> subprocess.Popen:
    """Start the run of a point in a process of its own, whose messages can be read."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sim", "run", "-", "--output", str(output)],
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


def fork(folder: Path, work: Callable, *arguments: object, **settings: str) -> CompletedProcess:
    """Call a function in a folder, in a new process; return that with its output.

    The process is a fork of a server that has imported `tests.made.forked`. It has the present
    environment and ``settings``.
    """
    forks = multiprocessing.get_context("forkserver")
    forks.set_forkserver_preload(["tests.made.forked", "tests.made.project"])
    with tempfile.TemporaryDirectory() as folder_of_output:
        outputs = [Path(folder_of_output) / name for name in ("stdout", "stderr")]
        how = (folder, dict(os.environ) | settings, outputs, work, arguments)
        process = forks.Process(target=_call, args=how)
        # The first call starts the server, which imports from its own folder alone.
        with chdir(ROOT):
            process.start()
        process.join()
        said = (path.read_text() for path in outputs)
        return CompletedProcess(arguments, process.exitcode, *said)


def _call(
    folder: Path,
    environment: Mapping[str, str],
    outputs: Sequence[Path],
    work: Callable,
    arguments: Sequence[object],
) -> None:
    for number, path in enumerate(outputs, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    work(*arguments)


def run_lines(folder: Path, lines: str, **settings: str) -> CompletedProcess:
    """Run lines of Python in a folder, in a new process, whose engine has no earlier additions."""
    return fork(folder, exec, lines, {}, TALUS_CACHE_DIR=str(folder / "cache"), **settings)


def in_process(folder: Path, lines: str) -> None:
    """Run lines of Python as `run_lines` does; fail where they do."""
    done = run_lines(folder, lines)
    assert done.returncode == 0, done.stderr


@contextmanager
def restore_plugins() -> Iterator[None]:
    """Remove, at the end of the block, the plug-ins that were loaded in it."""
    plugins_before = dict(plugins._plugins)
    additions_before = {kind: dict(entries) for kind, entries in additions._additions.items()}
    try:
        yield
    finally:
        plugins._plugins.clear()
        plugins._plugins.update(plugins_before)
        additions._additions.clear()
        additions._additions.update(additions_before)
        additions.notify_listeners()


def plugin_claims(systems: Collection[str]) -> list:
    """Return the claims of plug-ins on systems alone, in place of `sim.claims.claim.claims`."""
    claims = [addition.value for addition in additions.additions("judge").values()]
    return [claim for claim in claims if claim.system in systems]


@contextmanager
def without_plugins() -> Iterator[None]:
    """Run the block as in a process without plug-ins."""
    with restore_plugins():
        plugins._plugins.clear()
        additions._additions.clear()
        additions.notify_listeners()
        yield
