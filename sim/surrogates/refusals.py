"""Questions that the runs cannot answer: the reason stands in the file of the answer."""

import csv
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.seals import append_summary, read_summary, seal

#: Key of the reason, and heading of its column in a table.
_KEY = "refusal"


class Refusal(InputError):
    """The runs cannot answer a question; the message says why, and what may help."""


def save_refusal(refusal: Refusal, path: Path) -> None:
    """Write a refusal where the answer would stand; the file appears complete or not at all."""
    # Imported here: reading refusals needs none of it.
    import xarray as xr

    text = str(refusal)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        if path.suffix == ".csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows([[_KEY], [text]])
        else:
            xr.Dataset(attrs={_KEY: text}).to_netcdf(temporary, engine="netcdf4")
            append_summary(temporary, {"line": text, _KEY: text})
            seal(temporary)


def refusal_in(path: Path) -> str:
    """Return the refusal in a file of an answer; empty where there is none, or no file."""
    if not path.is_file():
        return ""
    if path.suffix != ".csv":
        return str((read_summary(path) or {}).get(_KEY, ""))
    with path.open(encoding="utf-8", newline="") as file:
        rows = csv.reader(file)
        return next(rows)[0] if next(rows, None) == [_KEY] else ""


def require_answer(path: Path) -> None:
    """Raise `Refusal` where a file has a refusal in place of an answer."""
    if text := refusal_in(path):
        raise Refusal(text)
