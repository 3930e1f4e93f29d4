"""Tables of indices as CSV files, with a note of their checksum beside them.

A seal at the end would be a row to those who read a CSV file.
"""

import csv
import hashlib
import io
from pathlib import Path
from typing import TYPE_CHECKING

from sim.base.files import atomic_write, read_regular
from sim.base.seals import checked_read

#: Most parameters that a line names.
_MOST_NAMED = 3

if TYPE_CHECKING:
    import pandas as pd


def save(table: "pd.DataFrame", path: Path) -> None:
    """Write a table; the file appears complete or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.10g")
        # Until the table takes its place, the one before it is whole, too.
        whole = [temporary.read_bytes(), read(path) if path.is_file() else None]
        checksums = dict.fromkeys(_checksum(one) for one in whole if one is not None)
        with atomic_write(_note(path)) as note:
            note.write_text(" ".join(checksums), encoding="ascii")


def read(path: Path) -> bytes | None:
    """Return the bytes of a table, None where they are not those of its checksum."""
    content = read_regular(path)
    note = _note(path)
    is_whole = not note.is_file() or _checksum(content) in note.read_text("ascii", "replace")
    return content if is_whole else None


def load(path: Path) -> "pd.DataFrame":
    """Read a table; one of an earlier version has no checksum.

    Raises
    ------
    InputError
        When there is no such file, or it is damaged. In the results of a study it is then set
        aside, so that the study makes it again.
    """
    # Imported here, as most commands need none of it.
    import pandas as pd

    is_of_study = (path.parent.parent / "runs").is_dir()
    with checked_read(path, "sensitivity", replaceable=is_of_study):
        content = read(path)
        if content is None:
            raise ValueError("its checksum is wrong")
        words = {"other": object, "doubt": object}
        texts = {"keep_default_na": False, "na_values": [""], "dtype": words}
        table = pd.read_csv(io.BytesIO(content), **texts)
        if "doubt" not in table:
            raise ValueError("it is of an earlier version")
        return table.fillna({"other": "", "doubt": ""})


def summary_line(path: Path) -> str:
    """Return the parameters that matter most, with total index or mean effect and its interval.

    Empty where the file is damaged.
    """
    rows = csv.DictReader((read(path) or b"").decode("utf-8", "replace").splitlines())
    shown = [row for row in rows if row.get("index") in ("total", "mu_star") and row.get("value")]
    if not shown:
        return ""
    shown.sort(key=lambda row: -float(row["value"]))
    texts = (
        f"{row['parameter']} {float(row['value']):.2g}"
        + (f" ({float(row['low']):.2g} to {float(row['high']):.2g})" if row["low"] else "")
        for row in shown[:_MOST_NAMED]
    )
    index = "mean size of the effect" if shown[0]["index"] == "mu_star" else "total index"
    return f"{index} of {', '.join(texts)}"


def _note(path: Path) -> Path:
    return path.with_name(f".{path.name}.sha256")


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
