"""Files: atomic writes, regular files, locks, and private folders."""

import errno
import logging
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from filelock import FileLock, Timeout

from sim.base.errors import InputError

log = logging.getLogger("talus")

_DAY = 86400


@contextmanager
def atomic_write(path: Path, durable: bool = True) -> Iterator[Path]:
    """Yield a temporary path to write to; the file is renamed to ``path`` when the block succeeds.

    After an error ``path`` is unchanged, and the temporary file gone.

    An existing file is replaced; so is a link, which is not followed. A ``durable`` file is on the
    disk before it is renamed, safe from a power cut. ``OSError`` names ``path``.
    """
    with temporary_folder(path) as folder:
        temporary = folder / path.name
        try:
            yield temporary
            if durable:
                _flush(temporary)
            temporary.replace(path)
            if durable:
                _flush(path.parent)
        except OSError as error:
            # Users do not know the temporary name.
            if error.errno and error.filename in (None, str(temporary)):
                raise OSError(error.errno, error.strerror, str(path)) from error
            raise


@contextmanager
def temporary_folder(path: Path) -> Iterator[Path]:
    """Yield a new, empty folder beside ``path``, which nobody else can write; it is removed after.

    All files that appear whole are written in such a folder, see `part_folder`.

    Raises ``OSError`` where a library cannot write; it says so where the disk is full.
    """
    try:
        folder = part_folder(path)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    try:
        yield folder
    except (OSError, RuntimeError) as error:
        # Of a full disk, libraries say "HDF error" or "permission denied".
        if number := _shortage(folder):
            raise OSError(number, os.strerror(number), str(path)) from error
        if isinstance(error, RuntimeError) and "NetCDF" in str(error):
            raise OSError(errno.EIO, f"cannot be written ({error})", str(path)) from error
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def part_folder(path: Path) -> Path:
    """Make a new, empty folder beside ``path``, which nobody else can write.

    Its name cannot be foretold, so nobody can have put a link in the place of what is written.
    Folders that killed processes have left for the same ``path`` are removed first.
    """
    remove_leftovers(path)
    return Path(tempfile.mkdtemp(".part", f".{path.name}.{os.getpid()}.", path.parent))


def file_version(path: Path) -> tuple[int, ...]:
    """Return inode, size and time of change of a file, which tell its versions apart.

    Empty if there is none.
    """
    try:
        status = path.stat()
    except FileNotFoundError:
        return ()
    return status.st_ino, status.st_size, status.st_mtime_ns


def remove_leftovers(path: Path) -> None:
    """Remove what killed processes have left of writing ``path``, and empty folders of others."""
    pattern = re.compile(rf"\.{re.escape(path.name)}\.(\d{{1,9}})\.\w+\.part")
    with os.scandir(path.parent) as entries:
        parts = [entry for entry in entries if entry.name.endswith(".part")]
    if parts:
        # Imported here: it takes a while, and parts are rare.
        from psutil import pid_exists
    for entry in parts:
        match = pattern.fullmatch(entry.name)
        if match and not pid_exists(int(match[1])):
            shutil.rmtree(entry.path, ignore_errors=True)
            continue
        # Perhaps of a process of another machine: a day later it has no use for an empty one.
        with suppress(OSError):
            if entry.stat(follow_symlinks=False).st_mtime < time.time() - _DAY:
                Path(entry.path).rmdir()


def _shortage(folder: Path) -> int:
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            os.posix_fallocate(file.fileno(), 0, 1 << 20)
    except OSError as error:
        return error.errno if error.errno in (errno.ENOSPC, errno.EDQUOT) else 0
    return 0


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading bytes.

    Raises ``OSError`` for anything else: a pipe or a device may never end.
    """
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "not a regular file", str(path))
    return os.fdopen(number, "rb")


def is_of_system(error: BaseException) -> bool:
    """True for an error of the system that says nothing of the bytes of a file: no permission, EIO.

    Libraries raise ``OSError`` with a negative number, or none, for bytes that they cannot use, and
    `open_regular` EINVAL for what is no file.
    """
    number = error.errno if isinstance(error, OSError) else None
    return bool(number and number > 0 and number not in (errno.EINVAL, errno.ENXIO))


def read_regular(path: Path) -> bytes:
    """Return the contents of a regular file; raise ``OSError`` otherwise, see `open_regular`."""
    with open_regular(path) as file:
        return file.read()


def lock_of(path: Path) -> FileLock:
    """Return the lock, not yet acquired, that a file is; the kernel releases it with its process.

    Raises ``OSError`` where the file cannot be written, which is no lack of locks.
    """
    if path.is_symlink():
        path.unlink()
    # A link that appears now is not followed, and a pipe keeps nobody waiting.
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    os.close(os.open(path, flags, 0o666))
    return FileLock(path, fallback_to_soft=False)


@contextmanager
def file_lock(path: Path, wait: bool = True) -> Iterator[bool]:
    """Lock ``path`` for one process at a time; yield True after waiting for another process.

    Where it shall not ``wait``, raise ``Timeout``, an ``OSError``, while another one has the lock.
    The kernel releases the lock when the process ends. On a file system without locks nobody waits.
    """
    name = path.with_name(f".{path.name}.lock")
    lock, has_waited = lock_of(name), False
    try:
        has_waited = _wait_for(lock, wait)
    except Timeout:
        raise
    except OSError:
        pass  # no locks on this file system
    try:
        yield has_waited
    finally:
        # Before the release, so that the next holder sees that the file is gone.
        name.unlink(missing_ok=True)
        lock.release()


def _wait_for(lock: FileLock, wait: bool) -> bool:
    try:
        lock.acquire(blocking=False)
    except Timeout:
        if not wait:
            raise
        log.warning("%s: waiting for another process that makes the same file", lock.lock_file)
        lock.acquire()
        return True
    return False


def _flush(path: Path) -> None:
    """Write a file, or the names in a folder, to the disk, safe from a power cut.

    Without it a new name could outlive its contents. Some file systems refuse it for folders.
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
    """Raise `InputError` unless files can be created in ``folder``, which is not made itself.

    The folder and its parents need not exist; then it is the nearest that does. ``key`` is the
    option or setting that named it, for the message.
    """
    nearest = folder.absolute()
    while not (nearest.exists() or nearest.is_symlink()) and nearest != nearest.parent:
        nearest = nearest.parent
    try:
        # Permission bits are not enough: root ignores them, and file systems may be full or
        # read-only.
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except NotADirectoryError:
        reason = f"{nearest} is not a folder"
    except OSError as error:
        reason = f"{nearest}: {error.strerror or error}"
    else:
        return
    raise InputError.of_value(key, "", str(folder), f"a folder that can be written ({reason})")


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


#: A time (s) before all others.
OLD = 86400.0

#: A time (s) before all runs; and the shift (s) that dates a run file back to before that time.
YEAR_2000 = 946684800.0
FIFTY_YEARS = 50 * 365.25 * 86400

#: Outputs of the workflow in the folder of a study that are made of many run files.
READERS = ("rounds/*.json", "dataset.nc")


def write_start(path: Path) -> None:
    """Write a file that is older than all runs, with fresh content each time; see `age`.

    Snakemake reruns a job if an input is newer than its output and has changed since the output was
    made. This holds whatever Snakemake has recorded of a failed job.
    """
    path.parent.mkdir(exist_ok=True)
    with atomic_write(path, durable=False) as temporary:
        temporary.write_text(str(time.time_ns()), encoding="utf-8")
        os.utime(temporary, (YEAR_2000, YEAR_2000))


def age(path: Path, is_old: bool) -> None:
    """Date an output before the file of `write_start`, or restore its time.

    Where the file has other names, as in other studies, those keep their time: it is copied first.
    """
    with suppress(OSError):
        status = path.stat()
        if is_old != (status.st_mtime < YEAR_2000):
            if status.st_nlink > 1:
                with atomic_write(path) as temporary:
                    shutil.copyfile(path, temporary)
            time_modified = status.st_mtime + (-FIFTY_YEARS if is_old else FIFTY_YEARS)
            os.utime(path, (time_modified, time_modified))


def date_back_readers(results: Path) -> None:
    """Date what is made of run files before them, where some have come with times of their own.

    Snakemake then makes those anew whose inputs have changed, as their checksums show.
    """
    for path in (path for pattern in READERS for path in results.glob(pattern)):
        with suppress(OSError):
            os.utime(path, (OLD, OLD), follow_symlinks=False)
