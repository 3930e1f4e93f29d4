"""Choices of a system, the contact law and the motion, and the options that plug-ins add to them.

An option goes by its name and the hash of the plug-in that it is from (``hertz.1a2b3c4d``): what
points say, and so their ids and run files. An edited one is another one.
"""

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from keyword import iskeyword
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import BeforeValidator, Field, create_model

from sim.base.additions import (
    NAME,
    AdditionError,
    add,
    is_of_talus,
    plain_name,
    plugin_options,
    shipped,
)
from sim.base.errors import in_short
from sim.base.plugins import (
    require_function,
    require_line,
    require_names,
    require_number,
    require_unit,
)
from sim.parameters.common import CHOICES, Parameters, Real
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
    require_unit("parameter: unit", unit)
    require_line("parameter: description", description)
    require_line("parameter: symbol", symbol, empty=True)
    return declare(
        float(default), unit=unit, description=description, symbol=symbol, added=True, **interval
    )


@dataclass(frozen=True)
class Option:
    """An option of a choice.

    ``description`` says what it is, in a few words. ``make`` gives the engine its numbers;
    ``parameters`` are its own, and ``owns`` names those of Talus that have an effect with it alone.
    """

    description: str
    make: Callable[..., Any]
    parameters: Mapping[str, Any]
    owns: tuple[str, ...]

    #: Number of arguments of each of its functions.
    argument_counts: ClassVar[Mapping[str, int]] = {"make": 1}

    @property
    def compiled_by_hand(self) -> tuple[str, ...]:
        """Functions that are missing because the type that ``make`` returns has compiled bodies."""
        return ()


@dataclass(frozen=True)
class Choice:
    """A parameter of some systems to which plug-ins add options.

    Attributes
    ----------
    name : str
        The parameter, and the kind of the additions.
    meaning : str
        What the parameter is.
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
    meaning: str
    models: tuple[type[Parameters], ...]
    usual: tuple[str, ...]
    role: Role
    kept: bool

    @classmethod
    def declared(cls, name: str, *models: type[Parameters]) -> Self:
        """Return the choice that systems declare, all with the options that ship."""
        field: Any = models[0].model_fields[name]
        role, kept = field.json_schema_extra.role, name in models[0].fixed_parameters
        return cls(name, field.description, models, get_args(field.annotation), role, kept)

    def add(self, name: str, option: Option) -> None:
        """Add an option of the plug-in that is being loaded.

        Raises
        ------
        AdditionError
            When its functions are none, or its parameters not those that `parameter` makes. What
            ships has a description, and alone may have functions that are compiled by hand.
        """
        what, parameters = f"{self.name} {name}", option.parameters
        require_line(f"{what}: description", option.description, empty=not is_of_talus())
        require_names(f"{what}: owns", option.owns)
        for key, number in option.argument_counts.items():
            if not (is_of_talus() and key in option.compiled_by_hand):
                require_function(f"{what}: {key}", getattr(option, key), number)
        if not isinstance(parameters, Mapping):
            allowed = "a mapping of names to what talus.parameter makes"
            raise AdditionError(f"{what}: parameters is {allowed}: got {in_short(parameters)}")
        for key, one in parameters.items():
            self._require_free(what, key)
            if not isinstance(getattr(one, "json_schema_extra", None), Declaration):
                allowed = "what talus.parameter makes"
                raise AdditionError(f"{what}: parameters.{key} is {allowed}: got {in_short(one)}")
        option = replace(option, parameters=dict(parameters), owns=tuple(option.owns))
        add(self.name, name, option, self.usual)

    def _require_free(self, what: str, name: Any) -> None:
        if not (isinstance(name, str) and re.fullmatch(NAME, name)) or iskeyword(name):
            raise AdditionError(f"{what}: parameter {name!r}: a name has letters a-z, digits and _")
        taken = {*dir(Parameters), *Parameters.__class_vars__, *_ELSEWHERE} | reserved_names()
        if name in taken.union(*((*dir(one), *one.model_fields) for one in self.models)):
            raise AdditionError(f"{what}: parameter {name}: Talus has one of this name")
        for kind in CHOICES:
            for other, one in plugin_options(kind).items():
                if name in one.parameters:
                    raise AdditionError(
                        f"{what}: parameter {name}: {kind} {plain_name(other)} has it"
                    )

    def describe(self) -> None:
        """Write what the options that ship are into the declarations of the systems."""
        for model in self.models:
            if self.name in model.model_fields:
                model.model_fields[self.name].description = self.description
                model.model_rebuild(force=True)

    @property
    def description(self) -> str:
        """What the parameter is, with all options and what each of them says of itself."""
        options = {name: shipped(self.name)[name] for name in self.usual}
        texts = (
            plain_name(name) + (f" ({one.description})" if one.description else "")
            for name, one in (options | plugin_options(self.name)).items()
        )
        return f"{self.meaning}: {', '.join(texts)}"

    def is_own(self, option: str) -> bool:
        """Return whether an option is that of a plug-in, be it loaded or not."""
        return option not in (*self.usual, "")


def extended(base: type[Parameters], *choices: Choice) -> type[Parameters]:
    """Return the parameters of a system with the options that its declaration does not have.

    These are those of plug-ins; and where it has no such parameter, those of Talus but the default.
    """
    options = {choice: tuple(_undeclared(base, choice)) for choice in choices}
    offers = tuple((choice, names) for choice, names in options.items() if names)
    return _extended(base, offers) if offers else base


def _undeclared(base: type[Parameters], choice: Choice) -> dict[str, Any]:
    names = () if choice.name in base.model_fields else choice.usual[1:]
    return {name: shipped(choice.name)[name] for name in names} | plugin_options(choice.name)


@cache
def _extended(
    base: type[Parameters], offers: tuple[tuple[Choice, tuple[str, ...]], ...]
) -> type[Parameters]:
    fields: dict[str, Any] = {}
    fixed, offered = [*base.fixed_parameters], {}
    for choice, names in offers:
        fields[choice.name] = _field(base, choice, names)
        offered[choice.name] = plugin_options(choice.name)
        for option in _undeclared(base, choice).values():
            fields |= {name: (Real, field) for name, field in option.parameters.items()}
            fixed += option.parameters if choice.kept else ()
    model: Any = create_model(base.__name__, __base__=base, **fields)
    model.fixed_parameters, model.offered = tuple(fixed), offered
    return model


def _field(base: type[Parameters], choice: Choice, options: tuple[str, ...]) -> tuple[Any, Any]:
    options_by_name = {plain_name(option): option for option in options}

    def coded(value: Any) -> Any:
        return options_by_name.get(value, value) if isinstance(value, str) else value

    text = choice.description
    if held := base.model_fields.get(choice.name):
        said = Field(held.default, description=text, json_schema_extra=held.json_schema_extra)
    else:
        usual = choice.usual[0]
        said = declare(usual, description=text, role=choice.role, compiled=True, added=True)
    allowed: Any = Literal[tuple(dict.fromkeys((*choice.usual, *options)))]
    return Annotated[allowed, BeforeValidator(coded)], said
