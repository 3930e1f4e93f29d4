"""Files that appear complete or not at all, and that only one process makes."""

import errno
import hashlib
import logging
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path
from typing import BinaryIO

from filelock import FileLock, Timeout

from sim.base.errors import InputError

log = logging.getLogger("talus")

#: The end of a sealed file.
SEAL = b"\nSHA-256 %s\n"


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary name beside ``path`` to write to; rename it when the block succeeds.

    After an error ``path`` is as it was and nothing else stays behind; an `OSError` names it. What
    a process that was killed has left of an earlier attempt is removed.
    """
    remove_left(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(path)
        _flush(path.parent)
    except OSError as error:
        # A full disk does not say whose it is, and nobody knows the temporary name.
        if error.errno and error.filename in (None, str(temporary)):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def remove_left(path: Path) -> None:
    """Remove what processes that were killed while they wrote ``path`` have left."""
    for left in path.parent.glob(f".{escape(path.name)}.*.part"):
        if not _is_alive(left.name.split(".")[-2]):
            left.unlink(missing_ok=True)


def seal(path: Path) -> None:
    """Append a checksum to a file, for `is_damaged`.

    Readers of HDF5 (netCDF-4) do not look behind the end that the file itself declares.
    """
    with path.open("r+b") as file:
        file.write(SEAL % checksum(file, path.stat().st_size))


def open_regular(path: Path) -> BinaryIO:
    """Open a file for reading bytes, if it is one: a pipe or a device may never end.

    Raises ``OSError`` for all else.
    """
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "not a regular file", str(path))
    return os.fdopen(number, "rb")


def read_regular(path: Path) -> bytes:
    """Return what a file holds; raise ``OSError`` where it is none, see `open_regular`."""
    with open_regular(path) as file:
        return file.read()


def is_damaged(path: Path) -> bool:
    """Return whether a file that was sealed has changed since, its seal included.

    Libraries may crash on a file that is damaged; this reads bytes and nothing else.
    """
    with open_regular(path) as file:
        length = max(0, file.seek(0, os.SEEK_END) - len(SEAL % bytes(64)))
        file.seek(length)
        found = file.read()
        file.seek(0)
        return found != SEAL % checksum(file, length)


def read_seal(path: Path) -> str:
    """Return the checksum that a file says it has, ``""`` where it has no seal."""
    length = len(SEAL % bytes(64))
    with open_regular(path) as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - length))
        found = file.read()
    is_seal = len(found) == length and found.startswith(SEAL[:9])
    return found[9:-1].decode("ascii", "replace") if is_seal else ""


def checksum(file: BinaryIO, length: int) -> bytes:
    """Return the SHA-256 of the next bytes of a file, in hexadecimal."""
    digest = hashlib.sha256()
    while block := file.read(min(length, 1 << 20)):
        digest.update(block)
        length -= len(block)
    return digest.hexdigest().encode()


def set_aside(path: Path) -> Path:
    """Rename a file that cannot be used to ``<name>.damaged``, and return that."""
    return path.replace(path.with_name(f"{path.name}.damaged"))


@contextmanager
def alone(path: Path) -> Iterator[bool]:
    """Let one process at a time make ``path``; yield whether another one had to be waited for.

    The kernel drops the lock with the process. Where the file system knows no locks, nobody waits.
    """
    name = path.with_name(f".{path.name}.lock")
    # A folder that takes no files says so here: that is no lack of locks. A link that somebody has
    # put there would have what it leads to emptied.
    if name.is_symlink():
        name.unlink()
    name.touch()
    lock, waited = FileLock(name, fallback_to_soft=False), False
    with suppress(OSError):
        waited = _wait_for(lock)
    try:
        yield waited
    finally:
        # Before the lock is dropped: whoever gets it afterwards sees that the file has gone.
        name.unlink(missing_ok=True)
        lock.release()


def _wait_for(lock: FileLock) -> bool:
    """Get the lock; return whether another process had it."""
    try:
        lock.acquire(blocking=False)
    except Timeout:
        log.warning("%s: waiting for another process that makes the same file", lock.lock_file)
        lock.acquire()
        return True
    return False


def _is_alive(number: str) -> bool:
    """Return whether a process of this machine has this number."""
    try:
        os.kill(int(number), 0)
    except (ProcessLookupError, ValueError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _flush(path: Path) -> None:
    """Put a file, or the names in a folder, on the disk, where a power cut leaves them alone.

    After it a name must not stand for missing contents. Some file systems refuse it for folders.
    """
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    except OSError:
        if not path.is_dir():
            raise
    finally:
        os.close(number)


def require_writable(folder: Path, key: str) -> None:
    """Make sure that files can be created in ``folder``, now or once it has been made.

    Nothing stays behind: the folder itself is not made.

    Parameters
    ----------
    folder : Path
        The folder; it and its parents need not exist.
    key : str
        What named it, for the message.

    Raises
    ------
    InputError
        When it, or the nearest of its parents that exists, is no folder or refuses a file.
    """
    nearest = folder.absolute()
    while not (nearest.exists() or nearest.is_symlink()) and nearest != nearest.parent:
        nearest = nearest.parent
    try:
        # Permission bits do not tell: root ignores them, read-only and full file systems too.
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except NotADirectoryError:
        reason = f"{nearest} is not a folder"
    except OSError as error:
        reason = f"{nearest}: {error.strerror or error}"
    else:
        return
    raise InputError.of_value(key, "", str(folder), f"a folder that can be written ({reason})")
