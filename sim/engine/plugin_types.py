"""Laws and motions of plug-ins: named tuples of numbers, whose type selects compiled functions."""

from collections.abc import Callable
from numbers import Real
from typing import Any, NamedTuple

from numba import types
from numba.core.errors import TypingError
from numba.core.ir import Loc

from sim.base.additions import attribute_errors_to, codes, plain_name, plugin_options
from sim.base.errors import InputError, in_short
from sim.engine.cache import COMPILED_KINDS
from sim.engine.compile import PLUGIN_CODES
from sim.parameters.choices import Choice

#: The types registered so far.
adopted_types: set[type] = set()


def adopt_type(kind: type, has_plugin: bool = True) -> bool:
    """Register a type, of a plug-in or of Talus; return True where it is new.

    Raises
    ------
    InputError
        When the engine was loaded before the plug-in: code compiled with the plug-in would be
        stored in the cache folder of processes without it.
    """
    if kind in adopted_types:
        return False
    if has_plugin and codes(*COMPILED_KINDS) != PLUGIN_CODES:
        raise InputError(
            "a plug-in with a law or a motion is loaded before the first flow of a process, and "
            "imports nothing of sim.engine; start another process"
        )
    adopted_types.add(kind)
    return True


def make_numbers(
    choice: Choice, option: str, register: Callable[[type, Any], None], *arguments: Any
) -> NamedTuple:
    """Return the numbers of a plug-in's option and register its functions for their type.

    The option's ``make`` computes the numbers from the ``arguments``.
    """
    addition = plugin_options(choice.name)[option]
    with attribute_errors_to(choice.name, plain_name(option)):
        numbers = addition.make(*arguments)
        is_named = isinstance(numbers, tuple) and hasattr(numbers, "_fields")
        if not is_named or not all(isinstance(number, Real) for number in numbers):
            raise TypeError(f"make returns a NamedTuple of numbers: got {in_short(numbers)}")
        register(type(numbers), addition)
    return numbers


def typing_error(function: Callable[..., Any], message: str) -> TypingError:
    """Return the error of a compiled function of a plug-in, with its file and line."""
    code = function.__code__
    return TypingError(message, Loc(code.co_filename, code.co_firstlineno))


def require_numbers(
    function: Callable[..., Any], label: str, returned: Any, count: int, kind: type = types.Number
) -> None:
    """Raise a typing error unless a compiled function returns a tuple of ``count`` numbers.

    ``label`` names the value in the message; ``returned`` holds its types.
    """
    is_tuple = isinstance(returned, tuple | types.BaseTuple) and len(returned) == count
    if not is_tuple or not all(isinstance(types.unliteral(part), kind) for part in returned):
        noun = "floats" if kind is types.Float else "numbers"
        raise typing_error(function, f"{label} is no tuple of {count} {noun}: got {returned}")
