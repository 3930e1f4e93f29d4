"""Ranges: evenly spaced values of a grid, given by their first and last value."""

from math import floor
from typing import Any

from sim.parameters import canonical_number
from sim.parameters.common import broken_rule

ALLOWED = "a list of values, {start, stop, num} or {start, stop, step}"

#: Maximum number of values of a range.
MAX_VALUES = 10_000

#: Relative slack of the last value: steps of 0.1 need not sum to 0.4.
_SLACK = 1e-9

#: Name of a range in the JSON schema, and its definition there.
NAME = "Range"
SCHEMA: dict[str, Any] = {
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


def expand_range(value: Any) -> Any:
    """Return the values of a range; return any other value unchanged, for later validation.

    >>> expand_range({"start": 0.3, "stop": 0.6, "step": 0.1})
    [0.3, 0.4, 0.5, 0.6]
    >>> expand_range({"start": 1, "stop": 2, "num": 3})
    [1.0, 1.5, 2.0]
    """
    if not isinstance(value, dict):
        return value
    are_numbers = all(
        type(number) in (int, float) and abs(number) < 1e15 for number in value.values()
    )
    if not are_numbers or set(value) not in ({"start", "stop", "num"}, {"start", "stop", "step"}):
        raise broken_rule("", value, ALLOWED)
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
            raise broken_rule(
                "step", step, f"a step from start to stop, of {MAX_VALUES} values at most"
            )
        count = floor(steps * (1 + _SLACK) + _SLACK) + 1
    return [canonical_number(start + number * step) for number in range(count)]


def expand_integer_range(value: Any) -> Any:
    """Return the values of a range as `expand_range` does, whole numbers as ``int``."""
    numbers = expand_range(value)
    if numbers is value:
        return value
    return [int(number) if float(number).is_integer() else number for number in numbers]


def allow_range_in_schema(schema: dict[str, Any]) -> None:
    """Change the JSON schema of a list so that it allows a range, too."""
    schema.pop("default", None)
    list_schema = {key: schema.pop(key) for key in ("type", "items", "minItems") if key in schema}
    schema["anyOf"] = [list_schema, {"$ref": f"#/$defs/{NAME}"}]
