"""Reading of stored files: the error names a damaged file, which is renamed and made again."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree.ElementTree import ParseError

from sim.base.errors import InputError
from sim.base.files import is_damaged, set_aside

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

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        Kind of file expected, for messages.
    replaceable : bool
        Rename an unreadable file to ``<name>.damaged``, so that the workflow makes it again.
    sealed : bool
        Check the checksum at its end first.

    Raises
    ------
    InputError
        When there is no such file.
    DamagedError
        When it cannot be read.
    """
    if not os.path.lexists(path):
        raise InputError(f"{path}: no such {kind}; rerun the study to make it")
    try:
        if not path.is_file():
            raise ValueError("no file, or a link to none")
        if sealed and is_damaged(path):
            raise ValueError("its checksum is wrong or missing")
        yield
    except InputError:
        raise
    except UNREADABLE as error:
        message = f"{path}: damaged or not a {kind} ({error})"
        if replaceable:
            aside = set_aside(path).name
            message += f"; now {aside}: rerun the study, which makes what is missing"
        raise DamagedError(message) from None
