"""Laws and motions of plug-ins: numbers, by whose type numba picks their functions."""

from collections.abc import Callable
from numbers import Real
from typing import Any, NamedTuple

from numba import types
from numba.core.errors import TypingError
from numba.core.ir import Loc

from sim.base.additions import blamed, codes
from sim.base.errors import InputError, in_short
from sim.engine.cache import CODED_KINDS
from sim.engine.compile import PLUGGED
from sim.parameters.choices import Choice, named, own

#: Those known so far.
adopted: set[type] = set()


def adopt(kind: type) -> bool:
    """Make a type known; return whether it was not before.

    Raises
    ------
    InputError
        Where the engine was loaded before the plug-in: code compiled with it would be kept where
        processes look that have not loaded it.
    """
    if kind in adopted:
        return False
    if codes(*CODED_KINDS) != PLUGGED:
        raise InputError(
            "a plug-in with a law or a motion is loaded before the first flow of a process, and "
            "imports nothing of sim.engine; start another process"
        )
    adopted.add(kind)
    return True


def made(
    choice: Choice, option: str, register: Callable[[type, Any], None], *given: Any
) -> NamedTuple:
    """Return the numbers of an option of a plug-in, whose functions are registered for their type.

    That is what its ``make`` returns of what is ``given``.
    """
    one = own(choice.name)[option]
    with blamed(choice.name, named(option)):
        numbers = one.make(*given)
        is_named = isinstance(numbers, tuple) and hasattr(numbers, "_fields")
        if not is_named or not all(isinstance(number, Real) for number in numbers):
            raise TypeError(f"make returns a NamedTuple of numbers: got {in_short(numbers)}")
        register(type(numbers), one)
    return numbers


def refused(function: Callable[..., Any], said: str) -> TypingError:
    """Return the error of a compiled function of a plug-in, with its place."""
    code = function.__code__
    return TypingError(said, Loc(code.co_filename, code.co_firstlineno))


def require_numbers(
    function: Callable[..., Any], what: str, given: Any, count: int, kind: type = types.Number
) -> None:
    """Refuse types, of what a compiled function gives, that are no tuple of so many numbers."""
    is_tuple = isinstance(given, tuple | types.BaseTuple) and len(given) == count
    if not is_tuple or not all(isinstance(types.unliteral(one), kind) for one in given):
        noun = "floats" if kind is types.Float else "numbers"
        raise refused(function, f"{what} is no tuple of {count} {noun}: got {given}")
