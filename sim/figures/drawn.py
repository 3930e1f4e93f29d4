"""What figures were drawn from, and the checksums of their files, in a file beside them."""

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path

from pydantic import BaseModel, TypeAdapter, ValidationError

from sim.base.damage import checked_read
from sim.base.files import open_regular, read_regular, replacing
from sim.study.catalogue import FigureSpec

#: The file beside the figures.
DRAWN = ".drawn.json"

#: Bytes at the end of a dataset that tell it from others, its seal among them.
TAIL = 128


class Drawn(BaseModel):
    """A figure as it was drawn.

    Attributes
    ----------
    source : str
        Hash of dataset, entry of the catalogue and code.
    files : dict
        SHA-256 of each of its files, by suffix.
    """

    source: str
    files: dict[str, str]


_SEVERAL = TypeAdapter(dict[str, Drawn])


def read_drawn(folder: Path) -> dict[str, Drawn]:
    """Return the record of each figure drawn in a folder; empty where none can be read."""
    try:
        return _SEVERAL.validate_json(read_regular(folder / DRAWN))
    except (OSError, ValidationError):
        return {}


def write_drawn(folder: Path, drawn: dict[str, Drawn]) -> None:
    """Note what the figures in a folder were drawn from, for good or not at all."""
    with replacing(folder / DRAWN) as temporary:
        told = {name: one.model_dump() for name, one in drawn.items()}
        temporary.write_text(json.dumps(told, indent=1), encoding="utf-8")


def as_drawn(spec: FigureSpec, dataset_path: Path, folder: Path, code: str) -> Drawn | None:
    """Return a figure as it is now, drawn by this code; none without all of its files."""
    source = hashlib.sha256(f"{code} {spec!r}".encode())
    try:
        with open_regular(dataset_path) as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
            source.update(file.read())
        files = {suffix: _checksum(folder / f"{spec.name}{suffix}") for suffix in spec.suffixes}
    except OSError:
        return None
    return Drawn(source=source.hexdigest(), files=files)


def require_unchanged(specs: Iterable[FigureSpec], folder: Path) -> None:
    """Refuse figures whose files are not those that were drawn.

    Raises
    ------
    InputError
        Where a file is missing.
    DamagedError
        Naming the first file that has changed since or is not known, which is set aside.
    """
    drawn = read_drawn(folder)
    for spec in specs:
        known = drawn[spec.name].files if spec.name in drawn else {}
        for suffix in spec.suffixes:
            path = folder / f"{spec.name}{suffix}"
            with checked_read(path, "file of a figure", replaceable=True):
                if suffix not in known:
                    raise ValueError(f"{DRAWN} does not know it")
                if _checksum(path) != known[suffix]:
                    raise ValueError("the checksum is wrong")


def _checksum(path: Path) -> str:
    return hashlib.sha256(read_regular(path)).hexdigest()
