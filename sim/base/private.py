"""Folders that nobody else can write, for what is run or believed because it lies there."""

import os
import stat
import tempfile
from pathlib import Path


class Unfit(Exception):
    """A folder is not one's own alone; the message says why."""


def private_folder(path: Path) -> Path:
    """Make a folder, if need be, and return it if nobody else can write or replace it.

    Raises `Unfit` where somebody could, ``OSError`` where it takes no files.
    """
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    if _others_may_write(above := path.parent.stat()) and not above.st_mode & stat.S_ISVTX:
        raise Unfit(f"others can write {path.parent}")
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise Unfit(f"{path} is a link or no folder")
    if found.st_uid != os.geteuid():
        raise Unfit(f"{path} belongs to user {found.st_uid}")
    if _others_may_write(found):
        raise Unfit(f"others can write {path}")
    with tempfile.TemporaryFile(dir=path) as file:
        file.write(b"\0" * 4096)
    return path


def caches() -> Path:
    """Return the folder of the user's caches; raise ``RuntimeError`` where there is no home."""
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named)
    if os.environ.get("HOME") == "":
        raise RuntimeError("HOME is empty")
    return Path.home() / ".cache"


def own_temporary() -> Path:
    """Return the name of this user's folder under the system's temporary one."""
    return Path(tempfile.gettempdir()) / f"talus-{os.geteuid()}"


def _others_may_write(found: os.stat_result) -> bool:
    return bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
