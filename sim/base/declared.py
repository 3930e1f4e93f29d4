"""What plug-ins give where they declare something, checked: what is wrong is one clear line."""

from collections.abc import Collection
from inspect import signature
from math import isfinite
from numbers import Integral
from typing import Any

from sim.base.additions import Refused
from sim.base.errors import in_short

#: Most letters of a text of a plug-in.
LONGEST = 200


def require_line(what: str, text: Any, *, empty: bool = False, longest: int = LONGEST) -> None:
    """Refuse what is no line of letters, fit for terminals, pages and pictures.

    Control characters and marks that turn the direction of writing are no letters.
    """
    if not (isinstance(text, str) and (text or empty)):
        raise Refused(f"{what} is text{'' if empty else ', not empty'}: got {in_short(text)}")
    if not (text.isprintable() and len(text) <= longest):
        raise Refused(
            f"{what} is one line of text, at most {longest} letters, without control characters "
            f"or direction marks: got {in_short(text)}"
        )


def require_function(what: str, function: Any, takes: int) -> None:
    """Refuse what cannot be called with so many arguments."""
    if not callable(function):
        raise Refused(f"{what} is a function: got {in_short(function)}")
    try:
        known = signature(function)
    except ValueError:
        # Of what is written in C that may not be known.
        return
    try:
        known.bind(*range(takes))
    except TypeError:
        number = f"{takes} arguments" if takes > 1 else "1 argument"
        raise Refused(f"{what} takes {number}: got {in_short(str(known))}") from None


def require_one_of(what: str, value: Any, choices: Collection[str]) -> None:
    """Refuse what is none of the choices."""
    if not (isinstance(value, str) and value in choices):
        raise Refused(f"{what} is one of {', '.join(choices)}: got {in_short(value)}")


def require_number(what: str, value: Any) -> None:
    """Refuse what is no finite number; ``True`` and ``False`` are none."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise Refused(f"{what} is a finite number: got {in_short(value)}")


def require_count(what: str, value: Any, most: int) -> None:
    """Refuse what is no whole number from 0 to the most there may be."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= int(value) <= most:
        # With the point of one that is not whole, which is what is wrong with it.
        got = repr(value) if isinstance(value, float) else in_short(value)
        raise Refused(f"{what} is a whole number from 0 to {most}: got {got}")
