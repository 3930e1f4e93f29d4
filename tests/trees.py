"""Copies of the project, for workflows that are run, edited and killed."""

import shutil
from pathlib import Path

ROOT = Path(__file__).parents[1]
PARTS = ("sim", "workflow", "config", "Snakefile", "profiles", "pyproject.toml")


def copy_tree(target: Path) -> Path:
    """Copy what a workflow needs into an empty folder, and return that."""
    for part in PARTS:
        if (ROOT / part).is_dir() and not (ROOT / part).is_symlink():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / part, target / part, ignore=ignored)
        else:
            shutil.copy(ROOT / part, target / part, follow_symlinks=False)
    return target
