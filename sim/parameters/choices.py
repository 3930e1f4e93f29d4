"""Options that plug-ins add to a choice of a system, each with parameters of its own.

An option goes by its name and the hash of the plug-in that it is from (``hertz.1a2b3c4d``): what
points say, and so their ids and run files. An edited one is another one.
"""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from keyword import iskeyword
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, create_model, model_validator

from sim.base.additions import NAME, Refused, additions
from sim.parameters.common import Parameters, Real, broken_rule
from sim.parameters.observables import ASKED_FOR, MEASURES, PROFILES, SCALARS, SERIES
from sim.parameters.roles import Role, declare

_RANGE = {"gt", "ge", "lt", "le"}

#: Names in files of runs and studies that are neither parameters nor observed.
_ELSEWHERE = {"system", "study", "point", "series", "name", "figures", "caveat", "replicate"}


def parameter(
    default: float, *, unit: str, description: str, symbol: str = "", **interval: Any
) -> Any:
    """Declare a parameter of a law or a motion: a number, whose default stands where it is omitted.

    Parameters
    ----------
    default : float
        Value when omitted.
    unit : str
        As UDUNITS reads it; ``"1"`` for pure numbers.
    description, symbol : str
        Meaning, one sentence without full stop, and the symbol, if any.
    **interval
        Any of ``gt``, ``ge``, ``lt``, ``le``.
    """
    if unknown := interval.keys() - _RANGE:
        raise Refused(f"parameter: no {sorted(unknown)[0]}; a range has gt, ge, lt, le")
    return declare(
        float(default), unit=unit, description=description, symbol=symbol, added=True, **interval
    )


def own(kind: str) -> dict[str, Any]:
    """Return the options of a kind that plug-ins have added, by the names that points have."""
    return {f"{name}.{one.plugin.code}": one.value for name, one in additions(kind).items()}


def named(option: str) -> str:
    """Return the name of an option of a plug-in without the hash."""
    return option.rpartition(".")[0]


def require_free(model: type[Parameters], what: str, names: Iterable[str]) -> None:
    """Refuse names of parameters that others have; ``what`` declares them."""
    observed = (SCALARS, MEASURES, PROFILES, ASKED_FOR, *SERIES.values())
    taken = {*dir(WithOwn), *WithOwn.__class_vars__, *dir(model), *model.model_fields, *_ELSEWHERE}
    taken |= {one for each in observed for one in each}
    for name in names:
        if not re.fullmatch(NAME, name) or iskeyword(name):
            raise Refused(f"{what}: parameter {name!r}: a name has letters a-z, digits and _")
        if name in taken:
            raise Refused(f"{what}: parameter {name}: Talus has one of this name")
        for kind in ("law", "motion"):
            for other, one in own(kind).items():
                if name in one.parameters:
                    raise Refused(f"{what}: parameter {name}: {kind} {named(other)} has it")


class WithOwn(Parameters):
    """Parameters of a system of which plug-ins offer options, the ``offered``, for a ``choice``."""

    choice: ClassVar[str]
    offered: ClassVar[Mapping[str, Any]]

    @model_validator(mode="after")
    def _with_parameters_of_its_option(self) -> Self:
        for option, one in self.offered.items():
            for name in one.parameters if option != getattr(self, self.choice) else ():
                usual = type(self).model_fields[name].default
                if getattr(self, name) != usual:
                    allowed = f"{usual:g} unless {self.choice} is {named(option)}, whose it is"
                    raise broken_rule(name, getattr(self, name), allowed)
        return self


def extended(
    model: type[Parameters], base: type[WithOwn], choice: str, usual: Iterable[str], role: Role
) -> type[Parameters]:
    """Return the parameters of a system with what plug-ins offer for a choice.

    Parameters
    ----------
    model : type
        The parameters of Talus, which are returned where there is no offer.
    base : type
        What stands for them where there is one.
    choice : str
        The parameter that names an option, and kind of the additions.
    usual : iterable of str
        Options of Talus, its default first.
    role : str
        Role of the choice.
    """
    offered = own(choice)
    return _extended(base, choice, tuple(usual), tuple(offered), role) if offered else model


@cache
def _extended(
    base: type[WithOwn], choice: str, usual: tuple[str, ...], options: tuple[str, ...], role: Role
) -> type[Parameters]:
    offered = own(choice)
    known = {named(option): option for option in options}

    def coded(value: Any) -> Any:
        return known.get(value, value) if isinstance(value, str) else value

    if held := base.model_fields.get(choice):
        extra = held.json_schema_extra
        said = Field(held.default, description=held.description, json_schema_extra=extra)
    else:
        text = f"{choice}: {usual[0]}, or one of a plug-in"
        said = declare(usual[0], description=text, role=role, compiled=True, added=True)
    fields: dict[str, Any] = {
        choice: (Annotated[Literal[(*usual, *options)], BeforeValidator(coded)], said)
    }
    for one in offered.values():
        fields |= {name: (Real, field) for name, field in one.parameters.items()}
    (system,) = base.__bases__[1:]
    made: Any = create_model(system.__name__, __base__=base, **fields)
    made.kept = (*base.kept, *(name for one in offered.values() for name in one.parameters))
    made.offered = offered
    return made
