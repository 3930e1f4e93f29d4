"""Folders that many tests need: filled once in a process, then copied."""

import shutil
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from tempfile import TemporaryDirectory

#: Fills a folder and returns the study file and the folder of results within it.
Maker = Callable[[Path], tuple[Path, Path]]


def once(make: Maker) -> Maker:
    """Return a maker whose folders are copies of the first that ``make`` has filled."""

    @cache
    def first() -> tuple[TemporaryDirectory, list[Path]]:
        folder = TemporaryDirectory(prefix="talus-made-")
        made = make(Path(folder.name))
        return folder, [path.relative_to(folder.name) for path in made]

    @wraps(make)
    def copied(folder: Path) -> tuple[Path, Path]:
        original, (study, results) = first()
        shutil.copytree(original.name, folder, dirs_exist_ok=True)
        return folder / study, folder / results

    return copied
