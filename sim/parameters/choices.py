"""Choices of a system, the contact law and the motion, and the options that plug-ins add to them.

An option goes by its name and the hash of the plug-in that it is from (``hertz.1a2b3c4d``): what
points say, and so their ids and run files. An edited one is another one.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from keyword import iskeyword
from math import inf
from typing import Annotated, Any, Literal, Self, get_args

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
from sim.base.plugins import Declared, Line, Names, Unit, Words, allowed, declared
from sim.parameters.common import CHOICES, Parameters, Real, Ruled
from sim.parameters.roles import Declaration, Role, declare
from sim.parameters.variables import reserved_names

#: Names in files of runs and studies that are neither parameters nor observed.
_ELSEWHERE = {"system", "study", "point", "series", "name", "figures", "caveat", "replicate"}

#: What an option adds as a parameter.
_MADE = allowed(
    "what talus.parameter makes",
    lambda one: isinstance(getattr(one, "json_schema_extra", None), Declaration),
)


class _Parameter(Declared, Ruled):
    default: float = Field(allow_inf_nan=False)
    unit: Unit
    description: Words
    symbol: Line
    gt: float = -inf
    ge: float = -inf
    lt: float = inf
    le: float = inf

    def require_rules(self) -> None:
        is_within = self.gt < self.default < self.lt and self.ge <= self.default <= self.le
        self.require("default", is_within, "a number in its own range")


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
    given = {"default": default, "unit": unit, "description": description, "symbol": symbol}
    one = declared(_Parameter, "parameter", **given, **interval)
    return declare(**one.model_dump(exclude_unset=True), added=True)


def _said(field: Any) -> tuple[Any, ...]:
    """Return what a parameter of an option is, but for what its choice makes of it."""
    extra = replace(field.json_schema_extra, fixed=False)
    return field.default, field.metadata, field.description, extra


class Option(Declared, Ruled):
    """An option of a choice.

    ``description`` says what it is, in a few words. ``make`` gives the engine its numbers;
    ``parameters`` are its own, and ``owns`` names those of Talus that have an effect with it alone.
    """

    description: Line = ""
    make: Callable[..., Any]
    parameters: dict[str, Annotated[Any, _MADE]] = {}
    owns: Names = ()

    @property
    def compiled_by_hand(self) -> tuple[str, ...]:
        """Functions that are missing because the type that ``make`` returns has compiled bodies."""
        return tuple(name for name, value in vars(self).items() if value is None)

    def has_functions(self, kind: type) -> bool:
        """Return whether functions, not compiled bodies, belong to a type that ``make`` returns."""
        return not self.compiled_by_hand


@dataclass(frozen=True)
class Choice:
    """A parameter of the systems ``models`` to which plug-ins add options.

    ``name`` is the parameter and the kind of the additions, ``usual`` are the options of Talus, its
    default first. Where it is ``kept``, what an option's parameters say is the same in a flow that
    goes on under others. Where it ``shares`` them, several options may have a parameter that they
    declare alike.
    """

    name: str
    meaning: str
    models: tuple[type[Parameters], ...]
    usual: tuple[str, ...]
    role: Role
    kept: bool
    shares: bool = False

    @classmethod
    def declared(cls, name: str, *models: type[Parameters]) -> Self:
        """Return the choice that systems declare, all with the options that ship."""
        field: Any = models[0].model_fields[name]
        said, usual = field.json_schema_extra, get_args(field.annotation)
        return cls(name, field.description, models, usual, said.role, said.fixed)

    def add(self, name: str, kind: type[Option], **fields: Any) -> None:
        """Add an option of the plug-in that is being loaded.

        What ships has a description, and alone may have functions that are compiled by hand.
        """
        what = f"{self.name} {name}"
        option = declared(kind, what, **fields)
        if is_of_talus() and not option.description:
            raise AdditionError(f"{what}: description: got ''; allowed: text, not empty")
        if missing := () if is_of_talus() else option.compiled_by_hand:
            raise AdditionError(f"{what}: {missing[0]}: got nothing; allowed: a function")
        for key, field in option.parameters.items():
            self._require_free(what, key, field)
        add(self.name, name, option, self.usual)

    def _require_free(self, what: str, name: str, field: Any) -> None:
        if not re.fullmatch(NAME, name) or iskeyword(name):
            raise AdditionError(f"{what}: parameter {name!r}: a name has letters a-z, digits and _")
        taken = {*dir(Parameters), *Parameters.__class_vars__, *_ELSEWHERE} | reserved_names()
        if name in taken.union(*((*dir(one), *one.model_fields) for one in self.models)):
            raise AdditionError(f"{what}: parameter {name}: Talus has one of this name")
        for kind in CHOICES:
            for other, one in plugin_options(kind).items():
                if name not in one.parameters:
                    continue
                is_shared = self.shares and kind == self.name
                if not is_shared or _said(one.parameters[name]) != _said(field):
                    owner = f"{kind} {plain_name(other)}"
                    raise AdditionError(f"{what}: parameter {name}: {owner} has it")

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
    offers = tuple((choice, tuple(_undeclared(base, choice))) for choice in choices)
    has_more = any(names or _parameters(base, choice) for choice, names in offers)
    return _extended(base, offers) if has_more else base


def _undeclared(base: type[Parameters], choice: Choice) -> dict[str, Any]:
    names = () if choice.name in base.model_fields else choice.usual[1:]
    return {name: shipped(choice.name)[name] for name in names} | plugin_options(choice.name)


def _parameters(base: type[Parameters], choice: Choice) -> dict[str, Any]:
    """Return the parameters that options add to a system, those that ship among them, by name."""
    options = {**shipped(choice.name), **_undeclared(base, choice)}
    return {name: field for one in options.values() for name, field in one.parameters.items()}


@cache
def _extended(
    base: type[Parameters], offers: tuple[tuple[Choice, tuple[str, ...]], ...]
) -> type[Parameters]:
    fields: dict[str, Any] = {}
    offered = {}
    for choice, names in offers:
        if names:
            fields[choice.name] = _field(base, choice, names)
        offered[choice.name] = plugin_options(choice.name)
        for name, field in _parameters(base, choice).items():
            field.json_schema_extra = replace(field.json_schema_extra, fixed=choice.kept)
            fields[name] = Real, field
    model: Any = create_model(base.__name__, __base__=base, **fields)
    model.offered = offered
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
    names: Any = Literal[tuple(dict.fromkeys((*choice.usual, *options)))]
    return Annotated[names, BeforeValidator(coded)], said
