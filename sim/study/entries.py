"""Keys of a study file, whatever their system: parameters, lists and ranges, overrides, names."""

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import floor
from typing import Annotated, Any, ClassVar, TypeVar
from unicodedata import category

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from sim.base.messages import input_error, number_and_unit
from sim.parameters import Parameters, canonical_number, hint_on_key
from sim.parameters.common import Real, Ruled, broken_rule
from sim.parameters.in_place import OF_UNIT_SIZE, plain_number
from sim.parameters.roles import Declaration

#: Unicode categories without letters, some of which move the cursor or reverse the line where a
#: title is shown; and the maximum lengths of a title and of a text in a paper's files.
_UNPRINTABLE = ("Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp")
_MAX_TITLE_LENGTH, _MAX_TEXT_LENGTH = 300, 2000


def require_printable(text: str, key: str = "title", max_length: int = _MAX_TITLE_LENGTH) -> None:
    """Raise the error of a validator unless a text is one line of printable letters."""
    if len(text) > max_length or any(category(letter) in _UNPRINTABLE for letter in text):
        allowed = f"one line of at most {max_length} letters, without control or direction marks"
        raise broken_rule(key, text, allowed)


def _one_line(text: str) -> str:
    require_printable(text.strip(), key="", max_length=_MAX_TEXT_LENGTH)
    return text.strip()


#: Text of a paper's files: a line, whose end may have been broken in the file.
Text = Annotated[str, AfterValidator(_one_line)]

NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"
ALLOWED_NAME: dict[str, Any] = {
    "allowed": "up to 60 letters, digits, '-' and '_', a letter or digit first"
}
Name = Annotated[str, Field(pattern=NAME, max_length=60, json_schema_extra=ALLOWED_NAME)]

#: A model of what a file says.
_Model = TypeVar("_Model", bound=BaseModel)


def read_into(model: type[_Model], contents: Any, source: str) -> _Model:
    """Return the model of the contents of a file; the first mistake is an ``InputError``."""
    try:
        return model.model_validate(contents)
    except ValidationError as error:
        raise input_error(error, model, source) from None


class Strict(Ruled):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def optional(
    description: str | None, json_schema: dict[str, Any] | None = None, **options: Any
) -> Any:
    """Declare an optional key: ``None`` if the file omits it, but null is not a valid value.

    ``json_schema`` holds further entries for the JSON schema.
    """

    def adapt_schema(schema: dict[str, Any]) -> None:
        schema.pop("default", None)
        schema.update(json_schema or {})

    adapt_schema.allowed = (json_schema or {}).get("allowed", "")  # type: ignore[attr-defined]
    return Field(None, description=description, json_schema_extra=adapt_schema, **options)


#: A function in place of values, as in the files of other programs.
_CALL = re.compile(r"\w+\(.*\)")


class Some(Strict):
    """Values of some parameters of a system; only those given are set."""

    parameters: ClassVar[type[Parameters]]
    #: Keys that stand in place of parameters, those of the system.
    in_place: ClassVar[dict[str, FieldInfo]]

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended value or key, empty if there is none."""
        if isinstance(value, list) and not issubclass(cls, Lists):
            if key in cls.parameters.pairs:
                return "or two, along and across the flow; a list of values belongs under grid"
            return "a list of values belongs under grid"
        if system_hint := getattr(cls.parameters, "hint", lambda key, value: "")(key, value):
            return str(system_hint)
        if isinstance(value, str) and _CALL.fullmatch(value):
            return "points spread over ranges belong under design (docs/designs.md)"
        return hint_on_key(key, cls.parameters.model_fields["system"].default)

    def explicit_values(self) -> dict[str, Any]:
        """Return the values that the file sets here, with numbers in canonical form."""
        names = (name for name in type(self).model_fields if name in self.model_fields_set)
        return {name: getattr(self, name) for name in names}


def number_or_text(given: Any, number: Callable[[Any], Any], row: Declaration) -> Any:
    """Return a number by its validator; a text stays one where the point gives the scale."""
    value = plain_number(given, row, {})
    is_text = isinstance(value, str) and value != plain_number(value, row, OF_UNIT_SIZE)
    return value if is_text else number(value)


def one_or_pair(given: Any, one: Callable[[Any], Any]) -> Any:
    """Return a number, or a list of two, by the validator of ``one``."""
    return [*map(one, given)] if isinstance(given, list) and len(given) == 2 else one(given)


class Lists(Some):
    """Lists of values of some parameters of a system, at least of one."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    def require_rules(self) -> None:
        if not self.model_fields_set:
            raise broken_rule("", {}, "at least one parameter with a list of values")


class Readings(Lists):
    """Lists of readings of the paper; of each the first is the one that figures show."""


class Override(Strict):
    """Parameters that change at the points where others have certain values."""

    when: Lists = Field(description="values that a point must have, each one of its list")
    set: Some = Field(description="parameters to set at those points")


def _shared_unit(range_: dict[str, Any]) -> str:
    """Return the unit of all numbers of a range, empty if they have none or several."""
    given = [number_and_unit(one) for key, one in range_.items() if key != "num"]
    units = {one[1] if one else "" for one in given}
    return units.pop() if len(units) == 1 else ""


_ALLOWED_RANGE = "a list of values, {start, stop, num} or {start, stop, step}"

#: Maximum number of values of a range, and relative slack of the last one: steps of 0.1 need not
#: sum to 0.4.
MAX_VALUES, _SLACK = 10_000, 1e-9

#: Name of a range in the JSON schema, and its definition there.
RANGE = "Range"
RANGE_SCHEMA: dict[str, Any] = {
    "description": "evenly spaced values from start to stop, which counts as one of them",
    "type": "object",
    "properties": {
        "start": {"type": "number"},
        "stop": {"type": "number"},
        "num": {"type": "integer", "minimum": 2, "maximum": MAX_VALUES},
        "step": {"type": "number", "not": {"const": 0}},
    },
    "required": ["start", "stop"],
    "oneOf": [{"required": ["num"]}, {"required": ["step"]}],
    "additionalProperties": False,
}


def expand_range(value: Any, are_whole: bool = False) -> Any:
    """Return the values of a range; return any other value unchanged, for later validation.

    ``are_whole`` makes whole numbers integers.

    >>> expand_range({"start": 0.3, "stop": 0.6, "step": 0.1})
    [0.3, 0.4, 0.5, 0.6]
    >>> expand_range({"start": 1, "stop": 2, "num": 3})
    [1.0, 1.5, 2.0]
    """
    if not isinstance(value, dict):
        return value
    if unit := _shared_unit(value):
        parts = {key: number_and_unit(one) or (one,) for key, one in value.items()}
        plain = expand_range({key: one[0] for key, one in parts.items()})
        return [f"{one:.12g} {unit}" for one in plain]
    are_numbers = all(type(one) in (int, float) and abs(one) < 1e15 for one in value.values())
    if not are_numbers or set(value) not in ({"start", "stop", "num"}, {"start", "stop", "step"}):
        raise broken_rule("", value, _ALLOWED_RANGE)
    start, stop = value["start"], value["stop"]
    if "num" in value:
        count = value["num"]
        if type(count) is not int or not 2 <= count <= MAX_VALUES:
            raise broken_rule("num", count, f"an integer in [2, {MAX_VALUES}]")
        step = (stop - start) / (count - 1)
    else:
        step = value["step"]
        steps = (stop - start) / step if step else -1.0
        if not 0 <= steps <= MAX_VALUES - 1:
            allowed = f"a step from start to stop, of {MAX_VALUES} values at most"
            raise broken_rule("step", step, allowed)
        count = floor(steps * (1 + _SLACK) + _SLACK) + 1
    numbers = [canonical_number(start + number * step) for number in range(count)]
    return [int(one) if are_whole and float(one).is_integer() else one for one in numbers]


def ends_left_out(contents: Any, path: str = "") -> Iterator[str]:
    """Yield a warning for each range in the contents of a file whose steps do not reach its end."""
    if isinstance(contents, dict) and set(contents) == {"start", "stop", "step"}:
        with suppress(PydanticCustomError):
            last, stop = expand_range(contents)[-1], contents["stop"]
            if number_and_unit(last) != number_and_unit(stop) or last != canonical_number(stop):
                why = f"as {stop} is no whole number of steps from the start"
                yield f"{path}: ends at {last}, {why}"
    elif isinstance(contents, dict | list):
        pairs = contents.items() if isinstance(contents, dict) else enumerate(contents)
        for key, value in pairs:
            place = f"{path}[{key}]" if isinstance(key, int) else f"{path}.{key}".lstrip(".")
            yield from ends_left_out(value, place)


def allow_range_in_schema(schema: dict[str, Any]) -> None:
    """Change the JSON schema of a list so that it allows a range, too."""
    schema.pop("default", None)
    list_schema = {key: schema.pop(key) for key in ("type", "items", "minItems") if key in schema}
    schema["anyOf"] = [list_schema, {"$ref": f"#/$defs/{RANGE}"}]


#: What the key ``units: natural`` of a study or a paper stands for.
NATURAL = {"diameter": 1.0, "mass": 1.0, "gravity": 1.0}

#: Kind of the plug-in additions that judge claims.
JUDGE = "judge"


class DecideFile(Strict):
    """What is to be decided by more replicates and longer runs, added in rounds."""

    budget: Real = Field(description="core hours that all rounds may add", gt=0, le=1e6)
    claims: list[str] = optional(
        "claims of the papers to be decided, as G3; [all] for all that the study tests; under each "
        "of the study's readings",
        min_length=1,
    )
    precision: Real = optional(
        "half width of the 95 % interval of the mean velocity, relative to it, that is wanted of "
        "every steady flow",
        ge=0.001,
        le=0.5,
    )
    replicates: int = Field(100, description="most replicates of a point", ge=2, le=1000)
    longer: Real = Field(
        8, description="most times as long as the study has it that a run may become", ge=1, le=1000
    )

    def require_rules(self) -> None:
        self.require("claims", self.claims or self.precision, "claims, precision, or both")
