"""Tables from elsewhere: CSV files beside a study or point, with units in their headings.

They hold what was measured, or the particles of an initial state.
"""

import csv
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from io import StringIO
from math import isfinite
from pathlib import Path
from typing import Any

from sim.base.errors import Allowed, InputError
from sim.base.messages import conversion, did_you_mean
from sim.base.numbers import number
from sim.base.yaml import read_text

#: Pattern of the name of such a file, and what is allowed, for messages: it is published with the
#: study, so it lies in the folder of the study file.
FILE, ALLOWED_FILE = r"^[^/\\]+\.csv$", "the name of a CSV file in the folder of the study file"

#: Largest number of rows, and of bytes; and unit of pure numbers, which a heading may leave out.
MAX_ROWS, MAX_BYTES, PURE = 10_000, 10**8, "1"

#: First line by which spreadsheets say what stands between values, up to the end of the line.
_SEPARATOR = re.compile(r'"?sep=([,;\t])"?[,;\t ]*(?=\r?\n)', re.IGNORECASE)

_DECIMAL_POINT = re.compile(r"[-+]?[0-9,]*\.[0-9]+.*")
_DECIMAL_COMMA = re.compile(r"^([-+]?[0-9]*),([0-9]+(?:[eE][-+]?[0-9]+)?)$")

#: Heading and values of a column that numbers the rows, as pandas writes and names it.
_NAMELESS, _WHOLE = re.compile(r"(Unnamed: 0)?"), re.compile(r"[0-9]+")

_HEADING = re.compile(r"\s*([^()\[\]]*[^()\[\]\s])\s*(?:[(\[]([^()\[\]]*(?:\([^()]*\))?)[)\]])?\s*")


@dataclass(frozen=True)
class MeasuredTable:
    """The file ``path``: the line of each row, and by column its texts and the unit of its heading.

    The unit is empty where the heading has none.
    """

    path: Path
    lines: tuple[int, ...]
    texts: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str]

    def require_column(self, name: str, what: str) -> None:
        """Raise ``InputError`` unless there is a column; ``what`` says what it should hold."""
        if name not in self.texts:
            allowed = f"a column {name}, {what}; the file has {', '.join(self.texts)}"
            # The errors of a column are no other spelling of it.
            others = [one for one in self.texts if not name.startswith(f"{one}_")]
            answer = Allowed(did_you_mean(name, others), allowed)
            raise InputError.of_value(self.path, f"column {name}", None, answer)

    def error(self, row: int, column: str, value: Any, allowed: str) -> InputError:
        """Return the error of a value in a row (from 0) of a column."""
        place = f"line {self.lines[row]}, column {column}"
        return InputError.of_value(self.path, place, value, allowed)

    def numbers(
        self, column: str, to: str, *, unit: str = "", low: float, high: float, allowed: str = ""
    ) -> tuple[float, ...]:
        """Return the numbers of a column, in the unit ``to`` as UDUNITS reads it.

        ``unit`` is that of the column where its heading has none; without both it is ``to``.
        ``low`` and ``high`` are the least and the largest number allowed, in the unit ``to``, which
        ``allowed`` has in words (omitted: the range). Raises ``InputError`` for a text that is no
        number, a number out of range, and a unit that is unknown or of another kind.
        """
        factor = self._factor(column, to, unit)
        allowed = allowed or f"a number in [{low:g}, {high:g}]" + (f" {to}" if to != PURE else "")
        values = []
        for row, text in enumerate(self.texts[column]):
            try:
                value = factor * number(text)
            except ValueError:
                comma = re.fullmatch(r"[-+]?\d+,\d+", text)
                hint = "; a number has a decimal point, not a comma" if comma else ""
                raise self.error(row, column, text or None, f"{allowed}{hint}") from None
            if not isfinite(value) or not low <= value <= high:
                raise self.error(row, column, text, allowed)
            values.append(value)
        return tuple(values)

    def _factor(self, column: str, to: str, unit: str) -> float:
        own = self.units[column]
        if own and unit and conversion(own, unit) != 1:
            allowed = f"{own}, as in its heading, or no unit there"
            raise InputError.of_value(self.path, f"unit of column {column}", unit, allowed)
        factor = conversion(own or unit or to, to)
        if factor is None:
            allowed = "no unit, as it is a pure number" if to == PURE else f"a unit such as {to}"
            raise InputError.of_value(self.path, f"unit of column {column}", own or unit, allowed)
        return factor


def read_measured(path: Path) -> MeasuredTable:
    """Read a CSV file, as `parse_table` does; raise ``InputError`` also for one that is missing."""
    text = read_text(path, "CSV file", MAX_BYTES)
    if path.resolve().parent != path.parent.resolve():
        raise InputError(f"{path}: a link to elsewhere; allowed: {ALLOWED_FILE}")
    return parse_table(text, path)


def parse_table(text: str, path: Path) -> MeasuredTable:
    """Return a table: a heading per column, as ``velocity (m/s)``, and a row per measurement.

    Empty lines, those that begin with ``#``, and columns without heading and values are left out,
    as is a first column of whole numbers without heading. Between values stand commas, semicolons
    or tabs; in place of decimal points may stand commas unless they part values. Raises
    ``InputError``, which names ``path``, for a text that is empty, longer than allowed or no table.
    """
    delimiter, text = _delimiter(text)
    lines = StringIO(text, newline="")
    reader = csv.reader(lines, delimiter=delimiter, strict=True, skipinitialspace=True)
    rows = []
    try:
        for row in reader:
            texts = [text.strip() for text in row]
            if any(texts) and not texts[0].startswith("#"):
                rows.append((reader.line_num, texts))
            if len(rows) > MAX_ROWS + 1:
                raise InputError(f"{path}: more than {MAX_ROWS:,} rows")
    except csv.Error as error:
        raise InputError(f"{path}: line {reader.line_num}: not readable as CSV: {error}") from None
    if len(rows) < 2:
        found = "the file is empty" if not rows else "the file has headings alone"
        raise InputError(f"{path}: {found}; allowed: a line of headings, and a row for each value")
    (heading_line, headings), *rest = rows
    cells = []
    for line, texts in rest:
        if len(texts) < len(headings) or any(texts[len(headings) :]):
            allowed = f"{len(headings)} values, as there are headings"
            allowed += "; between decimal commas belong semicolons" * (delimiter == ",")
            raise InputError.of_value(path, f"line {line}", ", ".join(texts), allowed)
        cells.append(texts[: len(headings)])
    if delimiter != "," and not any(_DECIMAL_POINT.fullmatch(one) for row in cells for one in row):
        cells = [[_DECIMAL_COMMA.sub(r"\1.\2", one) for one in row] for row in cells]
    columns, units = dict[str, tuple[str, ...]](), dict[str, str]()
    for place, (heading, column) in enumerate(zip(headings, zip(*cells, strict=True), strict=True)):
        if _NAMELESS.fullmatch(heading) and (place == 0 and all(map(_WHOLE.fullmatch, column))):
            continue
        if heading or any(column):
            name, unit = _read_heading(path, heading_line, heading, columns)
            columns[name], units[name] = column, unit
    return MeasuredTable(path, tuple(line for line, _ in rest), columns, units)


def read_heading(text: str) -> tuple[str, str] | None:
    """Return name and unit of a heading, the unit empty where it has none; None if it is none.

    >>> read_heading("velocity (m/s)"), read_heading("point"), read_heading("velocity (m")
    (('velocity', 'm/s'), ('point', ''), None)
    """
    match = _HEADING.fullmatch(text)
    return (match[1], (match[2] or "").strip()) if match else None


def _delimiter(text: str) -> tuple[str, str]:
    """Return what stands between values, and the text without a first line that only says so."""
    if match := _SEPARATOR.match(text):
        return match[1], text[match.end() :]
    lines = (line for line in text.splitlines() if line.strip(" ,;\t") and line[0] != "#")
    first = next(lines, "")
    return max(";,\t", key=first.count), text


def _read_heading(path: Path, line: int, heading: str, known: Collection[str]) -> tuple[str, str]:
    found = read_heading(heading)
    if found is None:
        allowed = "headings such as velocity (m/s), one for each column that has values"
        raise InputError.of_value(path, f"line {line}", heading or None, allowed)
    if found[0] in known:
        allowed = "a heading that no other column has"
        raise InputError.of_value(path, f"line {line}", heading, allowed)
    return found
