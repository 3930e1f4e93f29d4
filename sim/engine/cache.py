"""Where compiled code is kept: a folder of its own that nobody else can write.

What lies there is run, so whoever could put a file into it would have code of his run.
"""

import atexit
import logging
import os
import shutil
import stat
import tempfile
from functools import cache
from pathlib import Path

from sim.base.errors import InputError
from sim.engine.identity import COMPILED, source_hash

log = logging.getLogger("talus")

_NAME = "TALUS_CACHE_DIR"


def cache_directory() -> Path:
    """Return the folder of compiled code for the present sources.

    ``TALUS_CACHE_DIR`` overrides the default ``~/.cache/talus`` (``XDG_CACHE_HOME`` is honoured);
    where the default cannot serve, a folder of this user under the system's temporary one does, and
    where that cannot either, one that is removed in the end.

    Raises
    ------
    InputError
        When the folder that is named is of somebody else, or others can write it.
    """
    name = source_hash(COMPILED)
    if named := os.environ.get(_NAME):
        try:
            return _private(Path(named) / name)
        except _Unfit as error:
            allowed = "a folder of your own that only you can write"
            raise InputError(f"environment: {_NAME}: {error}; allowed: {allowed}") from None
        except OSError as error:
            return _temporary(name, f"{named}: {error.strerror or error}")
    try:
        home = os.environ.get("XDG_CACHE_HOME") or _home() / ".cache"
        return _private(Path(home) / "talus" / name)
    except (OSError, RuntimeError, _Unfit) as error:
        return _temporary(name, str(error))


def _home() -> Path:
    """Return the user's home; raise ``RuntimeError`` where there is none."""
    if os.environ.get("HOME") == "":
        raise RuntimeError("HOME is empty")
    return Path.home()


class _Unfit(Exception):
    """A folder is not one's own alone; the message says why."""


def _private(path: Path) -> Path:
    """Make a folder, if need be, and return it if it is fit to hold what will be run."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    if _others_may_write(above := path.parent.stat()) and not above.st_mode & stat.S_ISVTX:
        raise _Unfit(f"others can write {path.parent}")
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise _Unfit(f"{path} is a link or no folder")
    if found.st_uid != os.geteuid():
        raise _Unfit(f"{path} belongs to user {found.st_uid}")
    if _others_may_write(found):
        raise _Unfit(f"others can write {path}")
    with tempfile.TemporaryFile(dir=path) as file:
        file.write(b"\0" * 4096)
    return path


def _others_may_write(found: os.stat_result) -> bool:
    return bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


@cache
def _temporary(name: str, why: str) -> Path:
    """Return a folder under the system's temporary one, and warn once of what that means."""
    base = Path(tempfile.gettempdir()) / f"talus-{os.geteuid()}"
    try:
        _private(base)
        path = _private(base / name)
    except (OSError, _Unfit):
        path = Path(tempfile.mkdtemp(prefix="talus-"))
        atexit.register(shutil.rmtree, path, ignore_errors=True)
    log.warning("compiled code is kept in %s: %s", path, why)
    return path
