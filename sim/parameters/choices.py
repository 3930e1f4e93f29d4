"""Options that plug-ins add to a choice of a system, each with parameters of its own.

An option goes by its name and the hash of the plug-in that it is from (``hertz.1a2b3c4d``): what
points say, and so their ids and run files. An edited one is another one.
"""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from keyword import iskeyword
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, create_model, model_validator

from sim.base.additions import NAME, AdditionError, add, additions
from sim.base.errors import in_short
from sim.base.require import require_function, require_line, require_number
from sim.parameters.common import Parameters, Real, broken_rule
from sim.parameters.roles import Declaration, Role, declare
from sim.parameters.variables import reserved_names

_RANGE = {"gt": operator.gt, "ge": operator.ge, "lt": operator.lt, "le": operator.le}

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
    if unknown := interval.keys() - _RANGE.keys():
        raise AdditionError(f"parameter: no {sorted(unknown)[0]}; a range has gt, ge, lt, le")
    for what, value in ({"default": default} | interval).items():
        require_number(f"parameter: {what}", value)
    if not all(_RANGE[name](default, bound) for name, bound in interval.items()):
        raise AdditionError(f"parameter: default {default:g} is outside its own range")
    for what, text in (("unit", unit), ("description", description)):
        require_line(f"parameter: {what}", text)
    require_line("parameter: symbol", symbol, empty=True)
    return declare(
        float(default), unit=unit, description=description, symbol=symbol, added=True, **interval
    )


def own(kind: str) -> dict[str, Any]:
    """Return the options of a kind that plug-ins have added, by the names that points have."""
    return {f"{name}.{one.plugin.code}": one.value for name, one in additions(kind).items()}


def named(option: str) -> str:
    """Return the name of an option of a plug-in without the hash."""
    return option.rpartition(".")[0]


@dataclass(frozen=True)
class OwnOption:
    """An option of a plug-in: ``make`` gives the engine its numbers, ``parameters`` are its own."""

    make: Callable[..., Any]
    parameters: Mapping[str, Any]

    #: Its functions, and how many arguments they take.
    takes: ClassVar[Mapping[str, int]] = {"make": 1}


@dataclass(frozen=True)
class Choice:
    """A parameter of some systems to which plug-ins add options.

    Attributes
    ----------
    name : str
        The parameter, and the kind of the additions.
    models : tuple of type
        Parameters of these systems.
    usual : tuple of str
        Options of Talus, its default first.
    role : str
        Role of the parameter.
    kept : bool
        Whether what an option's parameters say is the same in a flow that goes on under others.
    """

    name: str
    models: tuple[type[Parameters], ...]
    usual: tuple[str, ...]
    role: Role
    kept: bool

    def add(self, name: str, option: OwnOption) -> None:
        """Add an option of the plug-in that is being loaded.

        Raises
        ------
        AdditionError
            When its functions are none, or its parameters not those that `parameter` makes.
        """
        what, parameters = f"{self.name} {name}", option.parameters
        for key, number in option.takes.items():
            require_function(f"{what}: {key}", getattr(option, key), number)
        if not isinstance(parameters, Mapping):
            allowed = "a mapping of names to what sim.parameter makes"
            raise AdditionError(f"{what}: parameters is {allowed}: got {in_short(parameters)}")
        for key, one in parameters.items():
            self._require_free(what, key)
            if not isinstance(getattr(one, "json_schema_extra", None), Declaration):
                allowed = "what sim.parameter makes"
                raise AdditionError(f"{what}: parameters.{key} is {allowed}: got {in_short(one)}")
        add(self.name, name, replace(option, parameters=dict(parameters)), self.usual)

    def _require_free(self, what: str, name: Any) -> None:
        """Refuse the name of a parameter that others have; ``what`` declares it."""
        if not (isinstance(name, str) and re.fullmatch(NAME, name)) or iskeyword(name):
            raise AdditionError(f"{what}: parameter {name!r}: a name has letters a-z, digits and _")
        taken = {*dir(WithOwn), *WithOwn.__class_vars__, *_ELSEWHERE} | reserved_names()
        if name in taken.union(*((*dir(one), *one.model_fields) for one in self.models)):
            raise AdditionError(f"{what}: parameter {name}: Talus has one of this name")
        for kind in ("law", "motion"):
            for other, one in own(kind).items():
                if name in one.parameters:
                    raise AdditionError(f"{what}: parameter {name}: {kind} {named(other)} has it")

    def is_own(self, option: str) -> bool:
        """Return whether an option is that of a plug-in, be it loaded or not."""
        return option not in (*self.usual, "")


class WithOwn(Parameters):
    """Parameters of a system with the options, by choice, that plug-ins have ``offered``."""

    offered: ClassVar[Mapping[Choice, Mapping[str, Any]]]

    def own_option(self, choice: Choice) -> Any:
        """Return what a plug-in offers that this point has chosen, None where nothing is."""
        return self.offered.get(choice, {}).get(getattr(self, choice.name, ""))

    @model_validator(mode="after")
    def _with_parameters_of_its_options(self) -> Self:
        for choice, offered in self.offered.items():
            for option, one in offered.items():
                for name in one.parameters if option != getattr(self, choice.name) else ():
                    require_usual(self, name, f"{choice.name} is {named(option)}, whose it is")
        return self


def require_usual(parameters: Parameters, name: str, unless: str) -> None:
    """Refuse another value of a parameter than its default, ``unless`` something is."""
    value, usual = getattr(parameters, name), type(parameters).model_fields[name].default
    if value != usual:
        raise broken_rule(name, value, f"{usual:g} unless {unless}")


def extended(base: type[WithOwn], *choices: Choice) -> type[Parameters]:
    """Return the parameters of a system with what plug-ins offer for choices.

    Parameters
    ----------
    base : type
        Stands for the parameters of Talus, its last base, where there is an offer.
    *choices : Choice
        What plug-ins may offer.
    """
    options = {choice: tuple(own(choice.name)) for choice in choices}
    offers = tuple((choice, names) for choice, names in options.items() if names)
    return _extended(base, offers) if offers else base.__bases__[-1]


@cache
def _extended(
    base: type[WithOwn], offers: tuple[tuple[Choice, tuple[str, ...]], ...]
) -> type[Parameters]:
    usual: Any = base.__bases__[-1]
    # Of a field that several bases declare pydantic takes that of the first, not of the system.
    fields: dict[str, Any] = {
        name: (field.annotation, field) for name, field in usual.model_fields.items()
    }
    kept, offered = [*base.fixed_parameters], {choice: own(choice.name) for choice, _ in offers}
    for choice, options in offers:
        fields[choice.name] = _field(base, choice, options)
        for one in offered[choice].values():
            fields |= {name: (Real, field) for name, field in one.parameters.items()}
            kept += one.parameters if choice.kept else ()
    made: Any = create_model(usual.__name__, __base__=base, **fields)
    made.fixed_parameters, made.offered = tuple(kept), offered
    return made


def _field(base: type[WithOwn], choice: Choice, options: tuple[str, ...]) -> tuple[Any, Any]:
    """Return type and declaration of a choice with more options."""
    known = {named(option): option for option in options}

    def coded(value: Any) -> Any:
        return known.get(value, value) if isinstance(value, str) else value

    if held := base.model_fields.get(choice.name):
        extra = held.json_schema_extra
        said = Field(held.default, description=held.description, json_schema_extra=extra)
    else:
        usual = choice.usual[0]
        text = f"{choice.name}: {usual}, or one of a plug-in"
        said = declare(usual, description=text, role=choice.role, compiled=True, added=True)
    allowed: Any = Literal[(*choice.usual, *options)]
    return Annotated[allowed, BeforeValidator(coded)], said
