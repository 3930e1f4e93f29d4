"""Roles of a parameter: declared once, with the parameter, and derived from there by all others."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, cast

from pydantic import BaseModel, Field

#: What a parameter is for. ``physics``: which flow it is. ``reading``: how an open place of the
#: paper is understood. ``numerics``: how the flow is computed. ``amount``: how much is run, which
#: no id of a point depends on: runs grow.
Role = Literal["physics", "reading", "numerics", "amount"]

#: How people write the units of numbers; all others as UDUNITS does.
_WRITTEN = {"1": "", "degree": "°", "N m-1": " N/m", "m s-2": " m/s²"}


@dataclass(frozen=True)
class Declaration:
    """What is declared of a parameter besides its type, range, default and meaning.

    See `declare` for the attributes. As pydantic's ``json_schema_extra`` it adds to the schema what
    a reader of study files wants to know.
    """

    symbol: str
    unit: str
    scale: str
    equation: str
    role: Role
    id_part: str
    compiled: bool
    changes_start: bool
    added: bool
    allowed: str

    def __call__(self, schema: dict[str, Any]) -> None:
        """Add symbol, unit, scale and equation to the JSON schema of the parameter."""
        shown = ("symbol", "unit", "scale", "equation")
        schema.update({name: getattr(self, name) for name in shown})

    @property
    def unit_text(self) -> str:
        """Unit as people write it behind a number, with the space before it, if any."""
        return _WRITTEN.get(self.unit, f" {self.unit}")


def declare(
    default: Any = ...,
    *,
    description: str,
    symbol: str = "",
    unit: str = "",
    scale: str = "",
    equation: str = "",
    role: Role = "physics",
    id_part: str = "",
    compiled: bool = False,
    changes_start: bool = False,
    added: bool = False,
    allowed: str = "",
    **options: Any,
) -> Any:
    """Declare one parameter.

    Parameters
    ----------
    default : object
        Value when omitted; leave out when ``default_factory`` is among the options.
    description : str
        Meaning, one sentence without full stop; also the long name in output files.
    symbol : str
        Symbol of the parameter in the paper.
    unit : str
        Unit of the stored number as UDUNITS (CF) reads it; ``"1"`` for pure numbers and ``""``
        for choices and switches.
    scale : str
        For pure numbers, the quantity they are multiples of (``"⟨d⟩"``, ``"g"``).
    equation : str
        Where it enters: equation or section of the source.
    role : str
        What it is for, see `Role`. Names of points, curves of figures and places of claims leave
        ``numerics`` and ``amount`` out; verdicts are given for each ``reading``.
    id_part : str
        Label in the names of all points, for the parameters that figures vary most; others are
        named where they differ from the paper.
    compiled : bool
        Whether its value chooses what is compiled; all others only change numbers.
    changes_start : bool
        Whether an answer may depend on it although it is numerical, because flows start otherwise:
        unless a claim names it, runs with its default come first.
    added : bool
        Whether there are points from before it: where it has its default, their canonical form, id
        and run file know nothing of it, and neither do those of new points.
    allowed : str
        What is allowed, in words, where type and range do not say it.
    **options
        Ranges and defaults as pydantic's ``Field`` takes them.
    """
    declaration = Declaration(
        symbol, unit, scale, equation, role, id_part, compiled, changes_start, added, allowed
    )
    if "default_factory" not in options:
        options["default"] = default
    return Field(description=description, json_schema_extra=declaration, **options)


def declarations(model: type[BaseModel]) -> dict[str, Declaration]:
    """Return the declaration of each parameter of a system, by name."""
    return {
        name: cast(Declaration, field.json_schema_extra)
        for name, field in model.model_fields.items()
    }


def numerical(model: type[BaseModel]) -> frozenset[str]:
    """Return the parameters that set how a flow is computed rather than which one it is."""
    return frozenset(_names(model, lambda one: one.role in ("numerics", "amount")))


def amounts(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the parameters that set how much of a flow is run."""
    return _names(model, lambda one: one.role == "amount")


def readings(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the parameters that tell readings of a paper apart, choices before numbers."""
    declared = declarations(model)
    names = _names(model, lambda one: one.role == "reading")
    return tuple(sorted(names, key=lambda name: bool(declared[name].unit)))


def compiled(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the parameters whose values choose what is compiled."""
    return _names(model, lambda one: one.compiled)


def added(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the parameters that there are points from before of, see `declare`."""
    return _names(model, lambda one: one.added)


def changing_start(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the numerical parameters that an answer may depend on after all."""
    return _names(model, lambda one: one.changes_start)


def id_parts(model: type[BaseModel]) -> dict[str, str]:
    """Return the labels in the names of all points, by parameter."""
    return {name: one.id_part for name, one in declarations(model).items() if one.id_part}


def _names(model: type[BaseModel], wanted: Callable[[Declaration], bool]) -> tuple[str, ...]:
    return tuple(name for name, one in declarations(model).items() if wanted(one))
