"""Workflows in forks of a server that has imported Snakemake.

The import takes most of the time of a dry run.
"""

import multiprocessing
import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from subprocess import CompletedProcess

# Not the package itself: some tests have a copy of it.
import numpy  # noqa: F401
import pydantic  # noqa: F401
import smart_open  # noqa: F401
import snakemake.cli

# This imports the plug-ins of Snakemake.
snakemake.cli.get_argument_parser()


def snakemake_in(folder: Path, arguments: Sequence[str]) -> CompletedProcess:
    """Run Snakemake to its end in a folder with the present environment; return its output."""
    forks = multiprocessing.get_context("forkserver")
    forks.set_forkserver_preload([__name__])
    with tempfile.TemporaryDirectory() as folder_of_output:
        outputs = [Path(folder_of_output) / name for name in ("stdout", "stderr")]
        process = forks.Process(target=_run, args=(folder, arguments, dict(os.environ), outputs))
        process.start()
        process.join()
        return CompletedProcess(
            arguments, process.exitcode, *(path.read_text() for path in outputs)
        )


def _run(
    folder: Path, arguments: Sequence[str], environment: Mapping[str, str], outputs: Sequence[Path]
) -> None:
    for number, path in enumerate(outputs, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[:] = ["snakemake", *arguments]
    snakemake.cli.main(arguments)
