"""Amounts of a point: how much of it is run. They are no part of its id, so runs can grow."""

from collections.abc import Mapping

from sim.parameters.common import Parameters
from sim.parameters.roles import amount_parameters as amounts_of

#: Amounts whose smaller value asks for more.
_FINER = ("target",)


#: Amounts without effect under the published protocol, whose runs end after transient and average.
_CONVERGED_ONLY = ("limit",)


def amounts(parameters: Parameters) -> dict[str, float]:
    """Return the amounts of a point that have an effect, by parameter."""
    excluded = _CONVERGED_ONLY if parameters.protocol == "published" else ()
    names = amounts_of(type(parameters))
    return {name: getattr(parameters, name) for name in names if name not in excluded}


def covers(available: Mapping[str, float], needed: Mapping[str, float]) -> bool:
    """True where the available amounts of a point are at least the needed ones."""
    return all(
        _larger(name, available[name], value) == available[name] for name, value in needed.items()
    )


def with_larger_amounts(parameters: Parameters, available: Mapping[str, float]) -> Parameters:
    """Return a point with the larger of its own and the available value of each amount."""
    return parameters.model_copy(
        update={
            name: type(value)(_larger(name, available.get(name, value), value))
            for name, value in amounts(parameters).items()
        }
    )


def _larger(name: str, first: float, second: float) -> float:
    """Return the value of an amount that asks for more."""
    return min(first, second) if name in _FINER else max(first, second)
