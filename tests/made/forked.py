"""Workflows in processes that need not import Snakemake, which takes most of the time of a dry run.

A server that has imported it once forks for each.
"""

import multiprocessing
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from subprocess import CompletedProcess

# Not the package itself, of which some tests have a copy.
import numpy  # noqa: F401
import pydantic  # noqa: F401
import smart_open  # noqa: F401
import snakemake.cli

# With it come the plug-ins of Snakemake.
snakemake.cli.get_argument_parser()


def snakemake_in(folder: Path, arguments: Sequence[str]) -> CompletedProcess:
    """Let Snakemake run to its end in a folder, in the present environment; return what it said."""
    forks = multiprocessing.get_context("forkserver")
    forks.set_forkserver_preload([__name__])
    with tempfile.TemporaryDirectory() as kept:
        said = [Path(kept) / name for name in ("stdout", "stderr")]
        process = forks.Process(target=_run, args=(folder, arguments, dict(os.environ), said))
        process.start()
        process.join()
        return CompletedProcess(arguments, process.exitcode, *(path.read_text() for path in said))


def _run(
    folder: Path, arguments: Sequence[str], environment: Mapping[str, str], said: Sequence[Path]
) -> None:
    for number, path in enumerate(said, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[:] = ["snakemake", *arguments]
    snakemake.cli.main(arguments)
