"""Checks of the values in a plug-in's declarations; each error is one clear line."""

import re
from collections.abc import Collection
from functools import cache
from inspect import signature
from math import isfinite
from numbers import Integral
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from sim.base.additions import AdditionError
from sim.base.errors import in_short, key_path
from sim.base.messages import near

_Dataclass = TypeVar("_Dataclass")

#: Largest number of letters in a text of a plug-in.
LONGEST = 200

#: Units that a plug-in may name, with a prefix of the SI where they have one.
_UNITS = "m g s A K mol cd rad degree Hz N Pa J W C V F ohm S T H degC percent min h day"
_UNIT = rf"(1|(da|[yzafpnuµmcdhkMGTPEZY])?({_UNITS.replace(' ', '|')})((\^|\*\*)?-?[1-9])?)"
_PRODUCT = re.compile(rf"{_UNIT}( ?[ ./*] ?{_UNIT})*")


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


def with_declared_types(what: str, one: _Dataclass) -> _Dataclass:
    """Return a dataclass whose values have the declared types; refuse what cannot have them."""
    model: Any = type(one)
    try:
        valid: _Dataclass = _adapter(model).validate_python(vars(one))
        return valid
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        allowed = (
            first["msg"].removeprefix("Input should be ").replace("Field required", "one more")
        )
        path = key_path(first["loc"])
        raise AdditionError(
            f"{what}.{path}: got {in_short(first['input'])}; allowed: {allowed}"
        ) from None


@cache
def _adapter(model: Any) -> TypeAdapter[Any]:
    return TypeAdapter(model)


def require_unit(what: str, unit: Any) -> None:
    """Refuse anything but a product of powers of units that UDUNITS reads."""
    require_line(what, unit)
    if not _PRODUCT.fullmatch(unit):
        units = ", ".join(_UNITS.split())
        raise AdditionError(
            f"{what} is 1 for a pure number, or a product of powers as kg m s-2, of {units}: "
            f"got {in_short(unit)}"
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
        options = near(str(value), choices)
        raise AdditionError(f"{what} is one of {options}: got {in_short(value)}")


def require_names(what: str, names: Any) -> None:
    """Raise `AdditionError` unless these are names, in a tuple or a list."""
    if not isinstance(names, tuple | list) or not all(isinstance(name, str) for name in names):
        raise AdditionError(f"{what} is a tuple of names: got {names!r}")


def require_number(what: str, value: Any) -> None:
    """Refuse anything but a finite number; booleans are refused."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise AdditionError(f"{what} is a finite number: got {in_short(value)}")


def require_switch(what: str, value: Any) -> None:
    """Refuse anything but True or False."""
    if not isinstance(value, bool):
        raise AdditionError(f"{what} is True or False: got {in_short(value)}")


def require_positive(what: str, value: Any) -> None:
    """Refuse anything but a number above 0, which may be infinite."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise AdditionError(f"{what} is a number > 0: got {in_short(value)}")


def require_count(what: str, value: Any, most: int) -> None:
    """Refuse anything but a whole number from 0 to ``most``."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= int(value) <= most:
        # A float keeps its decimal point, which is the mistake.
        got = repr(value) if isinstance(value, float) else in_short(value)
        raise AdditionError(f"{what} is a whole number from 0 to {most}: got {got}")
