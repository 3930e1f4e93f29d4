"""Folders in which workflows run, with a copy of the project or without, and what they say."""

import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

from tests.made.forked import snakemake_in
from tests.made.processes import ROOT

PARTS = ("sim", "workflow", "config", "Snakefile", "profiles", "pyproject.toml")
STUDY = "tiny.yaml"


def copy_tree(tree: Path) -> Path:
    """Copy what a workflow needs into a folder, and return that.

    Only for tests that edit the project: a copy compiles the engine anew.
    """
    for part in PARTS:
        if (ROOT / part).is_dir() and not (ROOT / part).is_symlink():
            shutil.copytree(ROOT / part, tree / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / part, tree / part, follow_symlinks=False)
    return tree


def bare_folder(folder: Path, study: str = STUDY) -> Path:
    """Copy a study of ``tests/data`` alone into a folder; return the folder.

    Workflows there are those of the project itself, whose engine other tests have compiled.
    """
    shutil.copy(ROOT / "tests" / "data" / study, folder / study)
    return folder


def command(folder: Path, *arguments: str, study: str = STUDY) -> list[str]:
    """Return the command of a workflow: of the copy in a folder, or of the project."""
    copied = folder / "Snakefile"
    snakefile = copied if copied.exists() else ROOT / "Snakefile"
    # What the profile keeps quiet about is what tests look at.
    spoken = ["--quiet", "host", "--cores", "2", "--snakefile", str(snakefile)]
    options = [*spoken, *arguments, "--configfile", study]
    return [sys.executable, "-m", "snakemake", *options]


def snakemake(tree: Path, *arguments: str, study: str = STUDY) -> subprocess.CompletedProcess:
    """Let a workflow run to its end and return what it said."""
    _, _, _, *words = command(tree, *arguments, study=study)
    return snakemake_in(tree, words)


def jobs(said: str) -> dict[str, int]:
    """Return how many jobs of each rule a workflow announces, the targets left out."""
    table = said.partition("Job stats:")[2].partition("\n\n")[0]
    found: Counter[str] = Counter()
    for name, count in re.findall(r"^(\w+) +(\d+)$", table, re.M):
        found["batch" if name.startswith("batch_") else name] += int(count)
    targets = ("all", "default", "runs", "total")
    return {name: count for name, count in found.items() if name not in targets}


def points(said: str) -> list[str]:
    """Return the points that a workflow announces or runs, in its order."""
    rule = r"^(?:local)?rule (?:run|batch_\w+):\n.*\n +output: (.*)$"
    outputs = [path for output in re.findall(rule, said, re.M) for path in output.split(", ")]
    return [Path(path.removesuffix(" (update)")).stem for path in outputs]


def plan(tree: Path, *arguments: str, study: str = STUDY) -> str:
    """Return what a dry run says."""
    dry = snakemake(tree, "-n", *arguments, study=study)
    assert dry.returncode == 0, dry.stderr
    return dry.stdout + dry.stderr


def planned(tree: Path, *arguments: str, study: str = STUDY) -> dict[str, int]:
    """Return how many jobs of each rule a dry run announces."""
    return jobs(plan(tree, *arguments, study=study))


def planned_points(tree: Path, *arguments: str, study: str = STUDY) -> set[str]:
    """Return the points that a dry run announces."""
    return set(points(plan(tree, *arguments, study=study)))
