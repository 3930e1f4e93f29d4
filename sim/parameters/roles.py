"""Declarations of parameters, and the roles of parameters that follow from them."""

import csv
import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, cast

from pydantic import BaseModel, Field

#: Role of a parameter. ``physics``: which flow it is. ``reading``: how an open passage of the paper
#: is understood. ``numerics``: how the flow is computed. ``amount``: how much is run; ids of points
#: do not depend on it, so runs can grow.
Role = Literal["physics", "reading", "numerics", "amount"]

#: Units as people write them behind a number; all others are written as in UDUNITS.
_WRITTEN = {"1": "", "degree": "°", "N m-1": " N/m", "m s-2": " m/s²", "kg m-3": " kg/m³"}


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """Declaration of a parameter besides its type, range, default and meaning.

    As pydantic's ``json_schema_extra`` it adds symbol, unit, scale and equation to the JSON schema.

    ``symbol`` is that in the paper, ``unit`` that of the stored number as UDUNITS (CF) reads it,
    for pure numbers ``scale`` the quantity of which they are multiples (``"⟨d⟩"``, ``"g"``), and
    ``equation`` the equation or section of the source in which it enters. For its `Role`: ids of
    points, curves of figures and places of claims omit ``numerics`` and ``amount``; each
    ``reading`` has its own verdicts. ``id_part`` is its label in the ids of all points, for the
    parameters that figures vary most; others are in an id where they differ from the paper.

    A ``compiled`` one selects the code to compile; others only change numbers. A numerical one that
    ``changes_start`` may change answers: unless a claim names it, its runs have one value or their
    defaults. A ``fixed`` one cannot change during a flow: it is equal in a run and the run it
    starts from. An ``added`` one came after points were published: where it has its default, the
    canonical form, id and run file of old and new points omit it. ``allowed`` are the allowed
    values in words, where type and range are not enough, ``synonyms`` other words, for hints, and
    ``follows`` other quantities by which people say it, each with a formula: ``radius: 2 radius``.
    """

    symbol: str = ""
    unit: str
    scale: str = ""
    equation: str = ""
    role: Role = "physics"
    id_part: str = ""
    compiled: bool = False
    changes_start: bool = False
    fixed: bool = False
    added: bool = False
    allowed: str = ""
    synonyms: str = ""
    follows: str = ""

    def __call__(self, schema: dict[str, Any]) -> None:
        """Add symbol, unit, scale and equation to the JSON schema of the parameter."""
        shown = ("symbol", "unit", "scale", "equation")
        schema.update({name: getattr(self, name) for name in shown})

    @property
    def unit_text(self) -> str:
        """Unit as people write it behind a number, with the space before it, if any."""
        return _WRITTEN.get(self.unit, f" {self.unit}")


def declare(default: Any = ..., *, description: str, unit: str = "", **options: Any) -> Any:
    """Declare one parameter.

    The ``default`` is left out when ``default_factory`` is among the ``options``: other attributes
    of `Declaration`, ranges and defaults for pydantic's ``Field``. The ``description`` is one
    sentence without full stop; also the long name in output files. A ``unit`` that is omitted is
    ``"1"``, that of pure numbers, and ``""`` for choices and switches.
    """
    own = {one.name: options.pop(one.name) for one in fields(Declaration) if one.name in options}
    is_pure = "scale" in own or type(default) in (int, float)
    declaration = Declaration(unit=unit or ("1" if is_pure else ""), **own)
    if "default_factory" not in options:
        options["default"] = default
    return Field(description=description, json_schema_extra=declaration, **options)


#: Declarations of the parameters of all systems: a row each. Columns are those of `declare` and
#: `Declaration`, ``range`` (``> 0``, ``[0, 90)``) and ``is`` (flags); an empty cell stands for the
#: usual value. ``of`` says whose parameter it is. Rows of ``several`` have what some systems share.
TABLE = Path(__file__).with_name("parameters.csv")

#: A range in the table: a lower bound, or both with brackets, of which round ones exclude.
_RANGE = re.compile(r"(>=?) (\S+)|([(\[])(\S+), (\S+)([\])])")


@cache
def _table() -> dict[tuple[str, str], dict[str, str]]:
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = {(row.pop("of"), row.pop("name")): row for row in csv.DictReader(file)}
    return {key: {name: cell for name, cell in row.items() if cell} for key, row in rows.items()}


def rows_of(table: str) -> Callable[..., Any]:
    """Return a function: the name of a parameter → its declaration in rows of the table.

    Further arguments are those of `declare`, such as a default that depends on other parameters.
    """

    def row(name: str, **options: Any) -> Any:
        cells = _table().get(("several", name), {}) | _table()[table, name]
        options = {flag: True for flag in cells.pop("is", "").split()} | options
        if limits := cells.pop("range", ""):
            options = _bounds(limits) | options
        if default := cells.pop("default", ""):
            options = {"default": _value(default)} | options
        return declare(**cells, **options)

    return row


def _value(text: str) -> Any:
    """Return a number, a switch or a word."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def _bounds(text: str) -> dict[str, float]:
    """Return a range as pydantic's ``Field`` takes it.

    >>> _bounds("> 0"), _bounds("[0, 90)")
    ({'gt': 0}, {'ge': 0, 'lt': 90})
    """
    match = _RANGE.fullmatch(text)
    assert match, f"{TABLE}: {text}: a range is written as > 0 or as [0, 90)"
    sign, least, left, low, high, right = match.groups()
    if sign:
        return {"gt" if sign == ">" else "ge": json.loads(least)}
    ends = {"gt" if left == "(" else "ge": low, "lt" if right == ")" else "le": high}
    return {name: json.loads(end) for name, end in ends.items()}


# Studies of 10,000 points ask each of these for every point; a plug-in makes another model.
@cache
def declarations(model: type[BaseModel]) -> Mapping[str, Declaration]:
    """Return the declaration of each parameter of a system, by name."""
    extras = {name: field.json_schema_extra for name, field in model.model_fields.items()}
    return MappingProxyType(cast(dict[str, Declaration], extras))


def _named(selects: Callable[[Declaration], bool]) -> Callable[[type[BaseModel]], tuple[str, ...]]:
    """Return a function: a system → its parameters whose declaration is selected."""

    @cache
    def names(model: type[BaseModel]) -> tuple[str, ...]:
        return tuple(name for name, row in declarations(model).items() if selects(row))

    return names


#: Parameters by what their `Declaration` says: how much of a flow is run; what selects the code to
#: compile; what came after points were published; what cannot change during a flow; and numerical
#: ones that change the start of flows.
amount_parameters = _named(lambda row: row.role == "amount")
compiled_parameters = _named(lambda row: row.compiled)
added_parameters = _named(lambda row: row.added)
fixed_parameters = _named(lambda row: row.fixed)
start_parameters = _named(lambda row: row.changes_start)
_numerical = _named(lambda row: row.role in ("numerics", "amount"))
_readings = _named(lambda row: row.role == "reading")


@cache
def numerical_parameters(model: type[BaseModel]) -> frozenset[str]:
    """Return the parameters that set how a flow is computed, not which flow it is."""
    return frozenset(_numerical(model))


@cache
def reading_parameters(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the parameters that distinguish readings of a paper, choices before numbers."""
    declared = declarations(model)
    return tuple(sorted(_readings(model), key=lambda name: bool(declared[name].unit)))


@cache
def id_parts(model: type[BaseModel]) -> Mapping[str, str]:
    """Return the labels in the ids of all points, by parameter."""
    parts = {name: row.id_part for name, row in declarations(model).items() if row.id_part}
    return MappingProxyType(parts)
