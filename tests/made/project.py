"""Folders in which workflows run, with or without a copy of the project, and their output."""

import multiprocessing
import os
import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from subprocess import CompletedProcess

from tests.made.processes import ROOT

PARTS = ("sim", "workflow", "config", "Snakefile", "profiles", "pyproject.toml")
STUDY = "tiny.yaml"


def copy_tree(tree: Path) -> Path:
    """Copy the files that a workflow needs into a folder; return the folder.

    Only for tests that edit the project: a copy compiles the engine anew.
    """
    for part in PARTS:
        if (ROOT / part).is_dir() and not (ROOT / part).is_symlink():
            shutil.copytree(ROOT / part, tree / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / part, tree / part, follow_symlinks=False)
    return tree


def bare_folder(folder: Path, study: str = STUDY) -> Path:
    """Copy only a study of ``tests/data`` into a folder; return the folder.

    Workflows there use the project itself, whose engine other tests have compiled.
    """
    shutil.copy(ROOT / "tests" / "data" / study, folder / study)
    return folder


def command(folder: Path, *arguments: str, study: str = STUDY) -> list[str]:
    """Return the command of a workflow: of the copy in a folder, or of the project."""
    copy = folder / "Snakefile"
    snakefile = copy if copy.exists() else ROOT / "Snakefile"
    # Tests read output that the profile suppresses.
    output = ["--quiet", "host", "--cores", "2", "--snakefile", str(snakefile)]
    options = [*output, *arguments, "--configfile", study]
    return [sys.executable, "-m", "snakemake", *options]


def snakemake(tree: Path, *arguments: str, study: str = STUDY) -> CompletedProcess:
    """Run a workflow to its end in the present environment; return the process with its output.

    It runs in a fork of a server that has imported Snakemake.
    """
    _, _, _, *words = command(tree, *arguments, study=study)
    forks = multiprocessing.get_context("forkserver")
    forks.set_forkserver_preload(["tests.made.forked", __name__])
    with tempfile.TemporaryDirectory() as folder_of_output:
        outputs = [Path(folder_of_output) / name for name in ("stdout", "stderr")]
        process = forks.Process(target=_run, args=(tree, words, dict(os.environ), outputs))
        process.start()
        process.join()
        return CompletedProcess(words, process.exitcode, *(path.read_text() for path in outputs))


def _run(
    tree: Path, words: Sequence[str], environment: Mapping[str, str], outputs: Sequence[Path]
) -> None:
    """Become Snakemake in a folder; a copy of the project there imports its own package."""
    for number, path in enumerate(outputs, 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
    os.chdir(tree)
    os.environ.clear()
    os.environ.update(environment)
    if (tree / "sim").exists():
        for name in [name for name in sys.modules if name.partition(".")[0] == "sim"]:
            del sys.modules[name]
    sys.argv[:] = ["snakemake", *words]
    import snakemake.cli

    snakemake.cli.main(words)


def jobs(output: str) -> dict[str, int]:
    """Return the number of jobs of each rule in a workflow's output, without the targets."""
    table = output.partition("Job stats:")[2].partition("\n\n")[0]
    counts: Counter[str] = Counter()
    for name, count in re.findall(r"^(\w+) +(\d+)$", table, re.M):
        counts["batch" if name.startswith("batch_") else name] += int(count)
    targets = ("all", "default", "runs", "total")
    return {name: count for name, count in counts.items() if name not in targets}


def points(output: str) -> list[str]:
    """Return the points in a workflow's output, in their order."""
    rule = r"^(?:local)?rule (?:run|batch_\w+):\n.*\n +output: (.*)$"
    paths = [path for line in re.findall(rule, output, re.M) for path in line.split(", ")]
    return [Path(path.removesuffix(" (update)")).stem for path in paths]


def plan(tree: Path, *arguments: str, study: str = STUDY) -> str:
    """Return the output of a dry run."""
    dry = snakemake(tree, "-n", *arguments, study=study)
    assert dry.returncode == 0, dry.stderr
    return dry.stdout + dry.stderr


def planned_jobs(tree: Path, *arguments: str, study: str = STUDY) -> dict[str, int]:
    """Return the number of jobs of each rule in a dry run."""
    return jobs(plan(tree, *arguments, study=study))


def planned_points(tree: Path, *arguments: str, study: str = STUDY) -> set[str]:
    """Return the points in a dry run."""
    return set(points(plan(tree, *arguments, study=study)))
