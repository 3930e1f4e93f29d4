"""Folders that nobody else can write, for files that are run or trusted because of their place."""

import os
import stat
import tempfile
from pathlib import Path


class NotPrivateError(Exception):
    """Others can write or replace a folder; the message says why."""


def private_folder(path: Path) -> Path:
    """Make a folder, if need be, and return it if nobody else can write or replace it.

    Raises `NotPrivateError` where somebody could, ``OSError`` where files cannot be created.
    """
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    if _others_may_write(above := path.parent.stat()) and not above.st_mode & stat.S_ISVTX:
        raise NotPrivateError(f"others can write {path.parent}")
    path.mkdir(mode=0o700, exist_ok=True)
    status = path.lstat()
    if not stat.S_ISDIR(status.st_mode):
        raise NotPrivateError(f"{path} is a link or no folder")
    if status.st_uid != os.geteuid():
        raise NotPrivateError(f"{path} belongs to user {status.st_uid}")
    if _others_may_write(status):
        raise NotPrivateError(f"others can write {path}")
    with tempfile.TemporaryFile(dir=path) as file:
        file.write(b"\0" * 4096)
    return path


def cache_folder() -> Path:
    """Return the user's cache folder; raise ``RuntimeError`` without a home."""
    if folder := os.environ.get("XDG_CACHE_HOME"):
        return Path(folder)
    if os.environ.get("HOME") == "":
        raise RuntimeError("HOME is empty")
    return Path.home() / ".cache"


def user_temporary_folder() -> Path:
    """Return the path of this user's folder within the system's temporary folder."""
    return Path(tempfile.gettempdir()) / f"talus-{os.geteuid()}"


def _others_may_write(status: os.stat_result) -> bool:
    return bool(status.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
