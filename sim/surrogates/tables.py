"""Tables of indices as CSV files, with a note of their checksum beside them."""

import hashlib
import io
from pathlib import Path

import pandas as pd

from sim.base.files import atomic_write, read_regular
from sim.base.seals import checked_read


def save(table: pd.DataFrame, path: Path) -> None:
    """Write a table; the file appears complete or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.10g")
        with atomic_write(_note(path)) as note:
            note.write_text(_checksum(temporary.read_bytes()), encoding="ascii")


def load(path: Path) -> pd.DataFrame:
    """Read a table; one of an earlier version has no checksum.

    Raises
    ------
    InputError
        When there is no such file, or it is damaged. In the results of a study it is then set
        aside, so that the study makes it again.
    """
    is_of_study = (path.parent.parent / "runs").is_dir()
    with checked_read(path, "sensitivity", replaceable=is_of_study):
        content = read_regular(path)
        if _note(path).is_file() and read_regular(_note(path)) != _checksum(content).encode():
            raise ValueError("its checksum is wrong")
        texts = {"keep_default_na": False, "na_values": [""], "dtype": {"other": str}}
        return pd.read_csv(io.BytesIO(content), **texts)


def _note(path: Path) -> Path:
    return path.with_name(f".{path.name}.sha256")


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
