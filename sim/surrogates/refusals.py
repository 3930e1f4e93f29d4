"""Questions that the runs cannot answer: the reason stands in the file of the answer."""

import csv
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.seals import append_summary, is_damaged, read_summary, seal
from sim.surrogates import tables

#: Key of the reason, and heading of its column in a table.
_KEY = "refusal"

#: Most letters of a reason: a file from elsewhere may have a million.
_LONGEST = 2000


class Refusal(InputError):
    """The runs cannot answer a question; the message says why, and what may help."""


def save_refusal(refusal: Refusal, path: Path) -> None:
    """Write a refusal where the answer would stand; the file appears complete or not at all."""
    # Imported here: reading refusals needs none of it.
    import pandas as pd
    import xarray as xr

    text = str(refusal)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".csv":
        tables.save(pd.DataFrame({_KEY: [text]}), path)
        return
    with atomic_write(path) as temporary:
        xr.Dataset(attrs={_KEY: text}).to_netcdf(temporary, engine="netcdf4")
        append_summary(temporary, {"line": text, _KEY: text})
        seal(temporary)


def refusal_in(path: Path) -> str:
    """Return the refusal in a file of an answer, a line.

    It is empty where there is no refusal or no file, or the file is damaged.
    """
    if not path.is_file():
        return ""
    if path.suffix != ".csv":
        text = (read_summary(path) or {}).get(_KEY, "")
        text = text if isinstance(text, str) and not (text and is_damaged(path)) else ""
    else:
        start = (tables.read(path) or b"")[: 4 * _LONGEST].decode("utf-8", "replace")
        heading, *rows = csv.reader(start.splitlines() or [""])
        text = " ".join(row[0] for row in rows if row) if heading == [_KEY] else ""
    return str(Refusal(text))[:_LONGEST]


def require_answer(path: Path) -> None:
    """Raise `Refusal` where a file has a refusal in place of an answer."""
    if text := refusal_in(path):
        raise Refusal(text)
