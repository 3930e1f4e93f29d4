"""Folders in which workflows run, with a copy of the project or without, and what they say."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PARTS = ("sim", "workflow", "config", "Snakefile", "profiles", "pyproject.toml")
STUDY = "tiny.yaml"


def copy_tree(tree: Path) -> Path:
    """Copy what a workflow needs into a folder, and return that."""
    for part in PARTS:
        if (ROOT / part).is_dir() and not (ROOT / part).is_symlink():
            shutil.copytree(ROOT / part, tree / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / part, tree / part, follow_symlinks=False)
    return tree


def copy_project(tree: Path, study: str = STUDY) -> Path:
    """Copy the project and a study of ``tests/data`` into a folder; return the folder."""
    copy_tree(tree)
    shutil.copy(ROOT / "tests" / "data" / study, tree / study)
    return tree


def bare_folder(folder: Path, study: str) -> Path:
    """Copy a study of ``tests/data`` alone into a folder; return the folder.

    Workflows there are those of the project itself, whose engine other tests have compiled.
    """
    shutil.copy(ROOT / "tests" / "data" / study, folder / study)
    return folder


def snakefile(folder: Path) -> Path:
    """Return the Snakefile of the copy in a folder, or the project's."""
    copied = folder / "Snakefile"
    return copied if copied.exists() else ROOT / "Snakefile"


def command(*arguments: str, study: str = STUDY) -> list[str]:
    options = ["--cores", "2", *arguments, "--configfile", study]
    return [sys.executable, "-m", "snakemake", *options]


def snakemake(tree: Path, *arguments: str, study: str = STUDY) -> subprocess.CompletedProcess:
    arguments = ("--snakefile", str(snakefile(tree)), *arguments)
    return subprocess.run(
        command(*arguments, study=study), cwd=tree, capture_output=True, text=True, timeout=900
    )


def planned(tree: Path, *arguments: str, study: str = STUDY) -> dict[str, int]:
    """Return how many jobs of each rule a dry run announces."""
    dry = snakemake(tree, "-n", *arguments, study=study)
    assert dry.returncode == 0, dry.stderr
    table = dry.stdout.rpartition("Job stats:")[2].partition("Reasons:")[0]
    jobs = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", table, re.M)}
    return {name: count for name, count in jobs.items() if name not in ("default", "total")}


def planned_points(tree: Path, *arguments: str, study: str = STUDY) -> set[str]:
    dry = snakemake(tree, "-n", *arguments, study=study)
    return set(re.findall(r"wildcards: point=(\S+)", dry.stdout + dry.stderr))
