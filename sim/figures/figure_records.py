"""A file of records in the folder of figures: the source of each, and checksums of its files."""

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path

from pydantic import BaseModel, TypeAdapter, ValidationError

from sim.base.files import atomic_write, open_regular, read_regular
from sim.base.seals import checked_read
from sim.study.figure_spec import FigureSpec

#: Name of the file of records in the folder of the figures.
RECORD_FILE = ".drawn.json"

#: Bytes at the end of a dataset that identify it; its seal is among them.
TAIL = 128


class FigureRecord(BaseModel):
    """The hash of what a figure was drawn from, and the SHA-256 of its files by suffix."""

    source: str
    files: dict[str, str]


_RECORDS = TypeAdapter(dict[str, FigureRecord])


def read_records(folder: Path) -> dict[str, FigureRecord]:
    """Return the record of each figure drawn in a folder; empty where none can be read."""
    try:
        return _RECORDS.validate_json(read_regular(folder / RECORD_FILE))
    except (FileNotFoundError, ValidationError):
        return {}


def write_records(folder: Path, records: dict[str, FigureRecord]) -> None:
    """Write the records of the figures in a folder; the file appears complete or not at all."""
    with atomic_write(folder / RECORD_FILE) as temporary:
        entries = {name: record.model_dump() for name, record in records.items()}
        temporary.write_text(json.dumps(entries, indent=1), encoding="utf-8")


def current_record(
    spec: FigureSpec, dataset_path: Path, folder: Path, code: str
) -> FigureRecord | None:
    """Return the record of a figure as its files are now, or None where a file is missing.

    It was drawn by ``code`` from an entry of the catalogue, a dataset, and its answer, if any.
    """
    source = hashlib.sha256(f"{code} {spec!r}".encode())
    try:
        with open_regular(dataset_path) as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
            source.update(file.read())
        if spec.answer.file:
            source.update(read_regular(dataset_path.parent / spec.answer.file))
        files = {suffix: _checksum(folder / f"{spec.name}{suffix}") for suffix in spec.suffixes}
    except OSError:
        return None
    return FigureRecord(source=source.hexdigest(), files=files)


def require_unchanged(specs: Iterable[FigureSpec], folder: Path) -> None:
    """Raise an error unless the files of all figures are those that were drawn.

    It is ``InputError`` where a file is missing, and ``DamagedError`` for the first one that has
    changed or has no record, which is set aside.
    """
    records = read_records(folder)
    for spec in specs:
        checksums = records[spec.name].files if spec.name in records else {}
        for suffix in spec.suffixes:
            path = folder / f"{spec.name}{suffix}"
            with checked_read(path, "file of a figure", replaceable=True):
                if suffix not in checksums:
                    raise ValueError(f"{RECORD_FILE} does not know it")
                if _checksum(path) != checksums[suffix]:
                    raise ValueError("the checksum is wrong")


def _checksum(path: Path) -> str:
    return hashlib.sha256(read_regular(path)).hexdigest()
