"""Seals: checksums in files of results, which show damage before a library reads a file.

The end of a sealed file may hold a summary, a line of JSON, which is read without opening the file.
It follows the end that the file declares, and the seal follows it. JSON has its checksum as a key.
"""

import errno
import fcntl
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO
from xml.etree.ElementTree import ParseError
from zlib import crc32

from sim.base.errors import InputError
from sim.base.files import is_of_system, open_regular

#: Last bytes of a sealed file: the SHA-256 of all before them.
SEAL = b"\nSHA-256 %s\n"

#: Ending of a summary: its length in bytes and its checksum.
_END = b"\nsummary %012d %08x"

#: Bytes of this ending and of a seal.
_ENDING, _SEAL = len(_END % (0, 0)), len(SEAL % bytes(64))

#: Key of the checksum, which covers all other keys and values.
CHECKSUM = "sha256"

#: Errors that libraries raise on files with a hole or a flipped bit.
UNREADABLE = (
    OSError,
    RuntimeError,
    ValueError,
    LookupError,
    AttributeError,
    TypeError,
    ArithmeticError,
    ParseError,
)


class DamagedError(InputError):
    """A stored file cannot be read; the message gives its new name, if it was renamed."""


@contextmanager
def checked_read(path: Path, kind: str, replaceable: bool, sealed: bool = False) -> Iterator[None]:
    """Turn any error of a block that reads a file into an `InputError` of one line.

    ``kind`` is the kind of file expected, for messages. An unreadable file that is ``replaceable``
    is renamed to ``<name>.damaged``, so that the workflow makes it again. Of a ``sealed`` one, the
    checksum at its end is checked first. Raises `InputError` when there is no such file,
    `DamagedError` when its bytes are wrong, and `OSError` when the system does not give its bytes,
    as without permission; the file stays as it is.
    """
    missing = InputError(f"{path}: no such {kind}; rerun the study to make it")
    try:
        # Not `lexists`, which takes a file for none where a file system fails.
        path.lstat()
    except (FileNotFoundError, NotADirectoryError, ValueError):
        raise missing from None
    if path.suffix in (".yaml", ".yml"):
        raise InputError(
            f"{path}: a YAML file, where a {kind} (*.nc) is expected; talus points lists "
            "the points of a study"
        )
    try:
        try:
            open_regular(path).close()
        except OSError as error:
            has_no_target = isinstance(error, FileNotFoundError)
            if has_no_target and not path.is_symlink():
                raise missing from None  # removed in the meantime
            if has_no_target or not is_of_system(error):
                raise ValueError("no file, or a link to none") from None
            raise
        if sealed and is_damaged(path):
            raise ValueError("its checksum is wrong or missing")
        yield
    except InputError:
        raise
    except UNREADABLE as error:
        if is_of_system(error):
            raise
        if isinstance(error, (OSError, RuntimeError)) and path.is_file() and not is_damaged(path):
            # Of an error of the system, the library says "HDF error".
            reason = f"cannot be read, though its checksum is right ({_no_lock(path) or error})"
            raise OSError(errno.EIO, reason, str(path)) from None
        message = f"{path}: damaged or not a {kind} ({error})"
        if replaceable:
            aside, studies = set_aside(path)
            shared = f", as in {', '.join(studies)}, which shared it" if studies else ""
            message += f"; now {aside.name}{shared}: rerun the study, which makes what is missing"
        raise DamagedError(message) from None


def _no_lock(path: Path) -> str:
    """Return why HDF5 cannot lock a file, which it does where the user's settings have it."""
    with suppress(FileNotFoundError):
        try:
            with open_regular(path) as file:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError as error:
            is_taken = isinstance(error, BlockingIOError)
            reason = "another program has locked it" if is_taken else f"no lock: {error.strerror}"
            return f"{reason}; HDF5_USE_FILE_LOCKING=FALSE reads all the same"
    return ""


def seal(path: Path) -> None:
    """Append a checksum to a file, for `is_damaged`.

    HDF5 (netCDF-4) readers ignore bytes after the end that the file declares.
    """
    with path.open("r+b") as file:
        file.write(SEAL % checksum(file, path.stat().st_size))


def is_damaged(path: Path) -> bool:
    """True where a sealed file, seal included, has changed since.

    Libraries may crash on a damaged file; this reads only bytes.
    """
    with open_regular(path) as file:
        length = max(0, file.seek(0, os.SEEK_END) - _SEAL)
        file.seek(length)
        ending = file.read()
        file.seek(0)
        return ending != SEAL % checksum(file, length)


def read_seal(path: Path) -> str:
    """Return the checksum in the seal of a file, ``""`` where it has no seal."""
    with open_regular(path) as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - _SEAL))
        ending = file.read()
    is_seal = len(ending) == _SEAL and ending.startswith(SEAL[:9])
    return ending[9:-1].decode("ascii", "replace") if is_seal else ""


def checksum(file: BinaryIO, length: int) -> bytes:
    """Return the SHA-256 of the next ``length`` bytes of a file, in hexadecimal."""
    digest = hashlib.sha256()
    while block := file.read(min(length, 1 << 20)):
        digest.update(block)
        length -= len(block)
    return digest.hexdigest().encode()


def _shared_names(path: Path) -> list[Path]:
    """Return the other names of a file in results: studies share run files."""
    path = path.absolute()
    if path.stat().st_nlink == 1:
        return []
    others = sorted(path.parents[2].glob(f"*/{path.parent.name}/{path.name}"))
    return [other for other in others if other != path and other.samefile(path)]


def set_aside(path: Path) -> tuple[Path, list[str]]:
    """Rename an unusable file to ``<name>.damaged``; return its path, and studies that share it.

    Where there is one already, the name ends in ``.damaged.2``, and so on. Other studies lose it,
    too: the first of them that runs again makes it, and the others take it from there.
    """
    others = _shared_names(path)
    for other in others:
        with suppress(OSError):
            _rename_damaged(other)
    return _rename_damaged(path), [other.parts[-3] for other in others]


def _rename_damaged(path: Path) -> Path:
    names = (f"{path.name}.damaged{ending}" for ending in ("", *(f".{n}" for n in range(2, 100))))
    free = (name for name in names if not os.path.lexists(path.with_name(name)))
    return path.replace(path.with_name(next(free, f"{path.name}.damaged")))


def append_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Append a summary of plain values or numbers of NumPy to a file that will be sealed."""
    text = json.dumps(summary, separators=(",", ":"), default=lambda number: number.item()).encode()
    with path.open("ab") as file:
        file.write(b"\n" + text + _END % (len(text), crc32(text)))


def read_summary(path: Path) -> dict[str, Any] | None:
    """Return the summary of a sealed file, None where it is missing or damaged.

    The rest of the file is not read and may be damaged.
    """
    with open_regular(path) as file:
        end = file.seek(0, os.SEEK_END) - _ENDING - _SEAL
        if end < 0:
            return None
        file.seek(end)
        ending = file.read(_ENDING + len(SEAL[:9]))
        words = ending.split()
        if len(words) != 4 or words[0] != b"summary":
            return None
        try:
            length = min(int(words[1]), end)
            file.seek(end - length)
            text = file.read(length)
            summary = json.loads(text) if ending.startswith(_END % (length, crc32(text))) else None
        except (ValueError, RecursionError):
            return None
        return summary if isinstance(summary, dict) else None


def to_sealed_json(mapping: dict[str, Any]) -> str:
    """Return a mapping with its checksum as JSON, a line for each key."""
    sealed = mapping | {CHECKSUM: _checksum(mapping)}
    lines = (f"{_text(key)}: {_text(value, (',', ':'))}" for key, value in sealed.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def parse_sealed_json(text: str) -> dict[str, Any]:
    """Return the mapping in a text of `to_sealed_json`; raise ``ValueError`` if it has changed."""
    mapping = json.loads(text)
    if not isinstance(mapping, dict) or mapping.pop(CHECKSUM, "") != _checksum(mapping):
        raise ValueError("the checksum is wrong")
    return mapping


def _checksum(mapping: dict[str, Any]) -> str:
    return hashlib.sha256(_text(mapping).encode()).hexdigest()


def _text(value: Any, separators: tuple[str, str] = (", ", ": ")) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=separators)
