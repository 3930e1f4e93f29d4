"""Laws that plots fit to curves: names of those that ship, and the call that adds one."""

import math
from collections.abc import Callable, Mapping
from inspect import Parameter, Signature
from typing import Annotated, Any, TypeVar

from sim.base.additions import add, additions, attribute_errors_to
from sim.base.plugins import Declared, Words, allowed, declared, require_function

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: Kind of the additions that are laws to fit.
FIT = "fit"

#: Names of the laws that ship; `sim.figures.fit` has them.
SHIPPED = ("linear", "quadratic", "power", "exponential", "pouliquen", "mu_of_i")


def _are_numbers(start: Any) -> bool:
    return (
        isinstance(start, Mapping)
        and bool(start)
        and all(isinstance(name, str) and name.isidentifier() for name in start)
        and all(type(one) in (int, float) and math.isfinite(one) for one in start.values())
    )


class FitLaw(Declared):
    """A law of a plug-in: its ``formula`` in words, first values of its numbers by letter."""

    formula: Words
    start: Annotated[dict[str, float], allowed("a mapping of letters to numbers", _are_numbers)]
    function: Callable[..., Any]


def fit(name: str, *, formula: str, start: Mapping[str, float]) -> Callable[[_Function], _Function]:
    """Declare a law that plots of studies fit to curves: ``fit: name``.

    The decorated function gets the values along x, an array (n,), then the numbers of the law, each
    by its letter; it returns the values along y, (n,), in the units of the axes.

    Parameters
    ----------
    name : str
        What study files call it.
    formula : str
        The law, for captions: ``"y = a (1 - exp(-x/b))"``.
    start : mapping
        Letter of each number -> the value from which least squares begin.
    """
    what = f"fit {name}"

    def register(function: _Function) -> _Function:
        fields = {"formula": formula, "start": start, "function": function}
        law = declared(FitLaw, what, **fields)
        require_function(what, function, takes=1, named=law.start)

        def attributed(x: Any, **numbers: float) -> Any:
            with attribute_errors_to(FIT, name):
                return function(x, **numbers)

        # That of the function may be wider than what least squares call it with.
        names = ("x", *law.start)
        attributed.__signature__ = Signature(  # type: ignore[attr-defined]
            [Parameter(one, Parameter.POSITIONAL_OR_KEYWORD) for one in names]
        )
        add(FIT, name, law.model_copy(update={"function": attributed}), SHIPPED)
        return function

    return register


def fits() -> tuple[str, ...]:
    """Return the names of all laws: those that ship, then those of plug-ins."""
    return (*SHIPPED, *additions(FIT))
