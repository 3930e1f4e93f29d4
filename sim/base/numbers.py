"""Numbers as people give them: in texts, and as NumPy has them."""

import re
from collections.abc import Mapping
from math import isfinite
from typing import Any

_INTEGER = re.compile(r"\s*[-+]?[0-9]+\s*")
_NUMBER = re.compile(r"\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?\s*")


def number(text: str, or_beyond: bool = False) -> float:
    """Return the finite decimal number that a text is; raise ``ValueError`` for other texts.

    Python would also read ``2_12``, ``nan``, and the digits of all alphabets. With ``or_beyond`` a
    number larger than Python has is infinite.
    """
    if not (_NUMBER.fullmatch(text) and (or_beyond or isfinite(float(text)))):
        raise ValueError("not a decimal number")
    return float(text)


def integer(text: str) -> int:
    """Return the whole number that a text is; raise ``ValueError`` for any other text."""
    if not _INTEGER.fullmatch(text):
        raise ValueError("not a whole number")
    return int(text)


def plain(value: Any) -> Any:
    """Return numbers, words and switches of NumPy as those of Python, also within a mapping.

    A number of single precision is the shortest decimal that it stands for: 0.4, not
    0.4000000059604645. Arrays become lists.
    """
    if isinstance(value, Mapping):
        return {plain(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return type(value)([plain(one) for one in value])
    if not hasattr(value, "dtype"):
        return value
    if value.shape:
        return [plain(one) for one in value]
    if value.dtype.kind == "f" and value.dtype.itemsize != 8:
        return float(str(getattr(value, "values", value)[()]))
    return value.item()
