"""Folders in which workflows run, with or without a copy of the project, and their output."""

import re
import shutil
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from subprocess import CompletedProcess

from tests.made.processes import ROOT, fork

PARTS = ("sim", "workflow", "config", "Snakefile", "profiles", "pyproject.toml", "talus.py")
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
    """Return the command of a workflow: of the copy in a folder, or of the project.

    Without a study it is that of the default one.
    """
    copy = folder / "Snakefile"
    snakefile = copy if copy.exists() else ROOT / "Snakefile"
    # Tests read output that the profile suppresses.
    output = ["--quiet", "host", "--cores", "2", "--snakefile", str(snakefile)]
    options = [*output, *arguments, *(["--configfile", study] if study else [])]
    return [sys.executable, "-m", "snakemake", *options]


def snakemake(tree: Path, *arguments: str, study: str = STUDY) -> CompletedProcess:
    """Run a workflow to its end in a fork; return the finished process with its output."""
    _, _, _, *words = command(tree, *arguments, study=study)
    return fork(tree, _become_snakemake, words)


def _become_snakemake(words: Sequence[str]) -> None:
    """Run Snakemake; in a copy of the project it imports the package there."""
    if Path("sim").exists():
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
