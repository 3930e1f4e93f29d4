"""Checks of the values in a plug-in's declarations; each error is one clear line."""

from collections.abc import Collection
from inspect import signature
from math import isfinite
from numbers import Integral
from typing import Any

from sim.base.additions import AdditionError
from sim.base.errors import in_short

#: Largest number of letters in a text of a plug-in.
LONGEST = 200


def require_line(what: str, text: Any, *, empty: bool = False, longest: int = LONGEST) -> None:
    """Refuse anything but one printable line of text, at most ``longest`` letters.

    Control characters and marks that change the direction of writing are refused.
    """
    if not (isinstance(text, str) and (text or empty)):
        raise AdditionError(f"{what} is text{'' if empty else ', not empty'}: got {in_short(text)}")
    if not (text.isprintable() and len(text) <= longest):
        raise AdditionError(
            f"{what} is one line of text, at most {longest} letters, without control characters "
            f"or direction marks: got {in_short(text)}"
        )


def require_function(what: str, function: Any, takes: int, named: Collection[str] = ()) -> None:
    """Refuse anything that cannot be called with ``takes`` arguments and those of some names."""
    if not callable(function):
        raise AdditionError(f"{what} is a function: got {in_short(function)}")
    try:
        parameters = signature(function)
    except ValueError:
        # A function written in C may have no signature.
        return
    try:
        parameters.bind(*range(takes), **dict.fromkeys(named))
    except TypeError:
        number = f"{takes} arguments" if takes > 1 else "1 argument"
        names = ", ".join([number, *named])
        raise AdditionError(f"{what} takes {names}: got {in_short(str(parameters))}") from None


def require_one_of(what: str, value: Any, choices: Collection[str]) -> None:
    """Refuse anything but one of the choices."""
    if not (isinstance(value, str) and value in choices):
        raise AdditionError(f"{what} is one of {', '.join(choices)}: got {in_short(value)}")


def require_names(what: str, names: Any) -> None:
    """Raise `AdditionError` unless these are names, in a tuple or a list."""
    if not isinstance(names, tuple | list) or not all(isinstance(name, str) for name in names):
        raise AdditionError(f"{what} is a tuple of names: got {names!r}")


def require_number(what: str, value: Any) -> None:
    """Refuse anything but a finite number; booleans are refused."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise AdditionError(f"{what} is a finite number: got {in_short(value)}")


def require_count(what: str, value: Any, most: int) -> None:
    """Refuse anything but a whole number from 0 to ``most``."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= int(value) <= most:
        # A float keeps its decimal point, which is the mistake.
        got = repr(value) if isinstance(value, float) else in_short(value)
        raise AdditionError(f"{what} is a whole number from 0 to {most}: got {got}")
