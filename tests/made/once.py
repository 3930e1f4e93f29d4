"""Folders that many tests need: filled once for all workers, then copied."""

import json
import shutil
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from filelock import FileLock

#: Fills a folder and returns the study file and the folder of results within it.
Maker = Callable[[Path], tuple[Path, Path]]


class SharedFolder:
    """Folder with the first results of each maker, shared by all workers; conftest.py sets it."""

    folder: Path


def once(make: Maker) -> Maker:
    """Return a maker that runs ``make`` once and copies its folder afterwards."""

    @wraps(make)
    def copied(folder: Path) -> tuple[Path, Path]:
        name = f"{make.__module__}.{make.__name__}"
        original, done = SharedFolder.folder / name, SharedFolder.folder / f"{name}.json"
        with FileLock(SharedFolder.folder / f"{name}.lock"):
            if not done.exists():
                shutil.rmtree(original, ignore_errors=True)
                original.mkdir()
                paths = [path.relative_to(original).as_posix() for path in make(original)]
                done.write_text(json.dumps(paths))
        shutil.copytree(original, folder, dirs_exist_ok=True)
        study, results = json.loads(done.read_text())
        return folder / study, folder / results

    return copied
