"""Folders that many tests need: filled once for all workers, then copied."""

import json
import shutil
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from filelock import FileLock

#: Fills a folder and returns the study file and the folder of results within it.
Maker = Callable[[Path], tuple[Path, Path]]


class Kept:
    """Where the first folder of each maker lies, the same for all workers; conftest.py sets it."""

    folder: Path


def once(make: Maker) -> Maker:
    """Return a maker whose folders are copies of the first that ``make`` has filled."""

    @wraps(make)
    def copied(folder: Path) -> tuple[Path, Path]:
        name = f"{make.__module__}.{make.__name__}"
        original, done = Kept.folder / name, Kept.folder / f"{name}.json"
        with FileLock(Kept.folder / f"{name}.lock"):
            if not done.exists():
                shutil.rmtree(original, ignore_errors=True)
                original.mkdir()
                made = [path.relative_to(original).as_posix() for path in make(original)]
                done.write_text(json.dumps(made))
        shutil.copytree(original, folder, dirs_exist_ok=True)
        study, results = json.loads(done.read_text())
        return folder / study, folder / results

    return copied
