"""Files that appear complete or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from glob import escape
from pathlib import Path


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary name beside ``path`` to write to; rename it when the block succeeds.

    After an error ``path`` is as it was and nothing else stays behind. What a process that was
    killed has left of an earlier attempt is removed.
    """
    for left in path.parent.glob(f".{escape(path.name)}.*.part"):
        if not _is_alive(left.name.split(".")[-2]):
            left.unlink(missing_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


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
    """Put a file on the disk: after a power cut a name must not stand for missing contents."""
    with path.open("rb") as file:
        os.fsync(file.fileno())
