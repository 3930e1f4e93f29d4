"""The one exception that users of Talus see, and the short form of values in its message."""

import reprlib
from collections.abc import Callable, Container, Iterable, Sequence
from inspect import signature
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, Self


class Allowed(NamedTuple):
    """What is allowed in place of a name: the names, in words, after a question for one of them.

    The question is "did you mean friction? ", or empty.
    """

    question: str
    names: str


class InputError(Exception):
    """A file, key, value or folder from the user is not usable.

    The message is a single line fit to be printed as it is. The command line prints it to
    standard error and exits with code 2, before anything has been computed.
    """

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else " " for c in message))

    @classmethod
    def of_value(cls, source: str | Path, key: str, value: Any, allowed: str | Allowed) -> Self:
        """Build the message ``FILE: KEY: got VALUE; allowed: ALLOWED``.

        ``source`` is the file, or other origin, that holds the value, ``key`` the full path of the
        key (``series[0].grid.depth[1]``), ``""`` for the file as a whole. Long values are
        shortened. ``allowed`` are the accepted values, in words.
        """
        where = f"{source}: {key}" if key else f"{source}"
        question, values = allowed if isinstance(allowed, Allowed) else ("", allowed)
        return cls(f"{where}: got {in_short(value)}; {question}allowed: {values}")

    @classmethod
    def of_several(cls, messages: Sequence[str]) -> Self:
        """Build the first of several messages, with the number of the others."""
        others = f" (and {len(messages) - 1} more)" if len(messages) > 1 else ""
        return cls(f"{messages[0]}{others}")


class _Short(reprlib.Repr):
    """Bounded ``repr``: a hostile or merely huge value must not flood the message."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel, self.maxdict, self.maxlist = 2, 4, 6
        self.maxstring = self.maxlong = self.maxother = 60

    def repr_float(self, value: float, level: int) -> str:
        return f"{value:.12g}"

    def repr_int(self, value: int, level: int) -> str:
        # Python refuses to write out integers of more than some thousand digits.
        bits = value.bit_length()
        return super().repr_int(value, level) if bits < 2000 else f"an integer of {bits} bits"

    def repr_bool(self, value: bool, level: int) -> str:
        return "true" if value else "false"

    def repr_function(self, value: Callable[..., Any], level: int) -> str:
        return f"{value.__name__}{signature(value)}"

    def repr_NoneType(self, value: None, level: int) -> str:  # noqa: N802 (name set by reprlib)
        return "nothing"


def in_short(value: Any) -> str:
    """Return ``value`` as one short line, spelled as in YAML where the two languages differ."""
    return " ".join(_Short().repr(value).split())


def key_path(location: Iterable[str | int]) -> str:
    """Join a location to a path: ``("series", 0, "grid")`` gives ``series[0].grid``."""
    path = ""
    for part in location:
        if isinstance(part, int):
            path += f"[{part}]"
        else:
            name = (
                part if part.isprintable() and len(part) <= _Short().maxstring else in_short(part)
            )
            path += f".{name}" if path else name
    return path


def count_text(number: int, noun: str) -> str:
    """Return a number of things in words.

    >>> count_text(1, "point"), count_text(2000, "point")
    ('1 point', '2,000 points')
    """
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def upper_first(text: str) -> str:
    """Return a text that begins with a capital; the rest stays as it is.

    >>> upper_first("mean of V")
    'Mean of V'
    """
    return text[:1].upper() + text[1:]


def percent(share: float) -> str:
    """Write a share in percent, to two digits, or to three just below all; a dash if not known.

    >>> percent(0.5678), percent(12.3456), percent(0.998), percent(0.9999), percent(float("nan"))
    ('57 %', '1200 %', '99.8 %', '99.9 %', '–')
    """
    if not isfinite(share):
        return "–"
    if 0.99 < share < 1:
        return f"{min(99.9, 100 * share):.3g} %"
    return f"{float(f'{100 * share:.2g}'):.12g} %"


def duration(seconds: float) -> str:
    """Return a time in the unit that suits it: ``4.5 s``, ``3.1 min``, ``2.0 h``.

    >>> duration(90)
    '1.5 min'
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.1f} min" if seconds < 3600 else f"{seconds / 3600:.1f} h"


def printable(text: str) -> str:
    """Return a text whose control characters and direction marks are replaced by their codes.

    >>> printable("a\\x1b[2J")
    'a\\\\x1b[2J'
    """
    allowed = "\n\N{NO-BREAK SPACE}"
    return "".join(
        letter if letter.isprintable() or letter in allowed else ascii(letter)[1:-1]
        for letter in text
    )


def align_table(
    headings: Sequence[str], rows: Sequence[tuple[str, ...]], right: Container[str]
) -> list[str]:
    """Return a table as lines; the columns with headings in ``right`` are right-aligned."""
    # Imported here, as few commands print tables.
    from tabulate import tabulate

    sides = ["right" if heading in right else "left" for heading in headings]
    table = tabulate(rows, headings, "plain", colalign=sides, disable_numparse=True)
    return [line.rstrip() for line in table.splitlines()]
