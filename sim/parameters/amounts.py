"""How much of a point is wanted, which is no part of what it is: a run only grows."""

from collections.abc import Mapping

from sim.parameters.common import Parameters
from sim.parameters.roles import amounts as amounts_of

#: Amounts of which the smaller one asks for more.
_FINER = ("target",)


#: Without effect under the published protocol, whose runs end after transient and average.
_OF_CONVERGED = ("limit",)


def amounts(parameters: Parameters) -> dict[str, float]:
    """Return the amounts of a point by parameter; one without effect is left out."""
    passed_over = _OF_CONVERGED if parameters.protocol == "published" else ()
    names = amounts_of(type(parameters))
    return {name: getattr(parameters, name) for name in names if name not in passed_over}


def covers(held: Mapping[str, float], wanted: Mapping[str, float]) -> bool:
    """Return whether amounts that are held have all that is wanted of the same point."""
    return all(_more(name, held[name], value) == held[name] for name, value in wanted.items())


def more(parameters: Parameters, held: Mapping[str, float]) -> Parameters:
    """Return a point with the larger of each amount: its own and one that is held, if any."""
    return parameters.model_copy(
        update={
            name: type(value)(_more(name, held.get(name, value), value))
            for name, value in amounts(parameters).items()
        }
    )


def _more(name: str, one: float, other: float) -> float:
    return min(one, other) if name in _FINER else max(one, other)
