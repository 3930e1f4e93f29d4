"""Evenly spaced values of a grid, given by where they start and stop."""

from math import floor
from typing import Any

from sim.parameters import canonical_number
from sim.parameters.common import broken_rule

ALLOWED = "a list of values, {start, stop, num} or {start, stop, step}"

#: Values of a range at most.
MOST = 10_000

#: Relative slack of the last value: steps of 0.1 need not sum to 0.4.
_SLACK = 1e-9

#: How a range stands in the JSON schema, and under which name.
NAME = "Range"
SCHEMA: dict[str, Any] = {
    "description": "evenly spaced values from start to stop, which counts as one of them",
    "type": "object",
    "properties": {
        "start": {"type": "number"},
        "stop": {"type": "number"},
        "num": {"type": "integer", "minimum": 2, "maximum": MOST},
        "step": {"type": "number", "not": {"const": 0}},
    },
    "required": ["start", "stop"],
    "oneOf": [{"required": ["num"]}, {"required": ["step"]}],
    "additionalProperties": False,
}


def expanded(value: Any) -> Any:
    """Return the values of a range; anything else as it is, for validation to look at.

    >>> expanded({"start": 0.3, "stop": 0.6, "step": 0.1})
    [0.3, 0.4, 0.5, 0.6]
    >>> expanded({"start": 1, "stop": 2, "num": 3})
    [1.0, 1.5, 2.0]
    """
    if not isinstance(value, dict):
        return value
    numbers = all(type(one) in (int, float) and abs(one) < 1e15 for one in value.values())
    if not numbers or set(value) not in ({"start", "stop", "num"}, {"start", "stop", "step"}):
        raise broken_rule("", value, ALLOWED)
    start, stop = value["start"], value["stop"]
    if "num" in value:
        count = value["num"]
        if type(count) is not int or not 2 <= count <= MOST:
            raise broken_rule("num", count, f"an integer in [2, {MOST}]")
        step = (stop - start) / (count - 1)
    else:
        step = value["step"]
        steps = (stop - start) / step if step else -1.0
        if not 0 <= steps <= MOST - 1:
            raise broken_rule("step", step, f"a step from start to stop, of {MOST} values at most")
        count = floor(steps * (1 + _SLACK) + _SLACK) + 1
    return [canonical_number(start + number * step) for number in range(count)]


def expanded_integers(value: Any) -> Any:
    """Return the values of a range of whole numbers as `expanded` does."""
    found = expanded(value)
    if found is value:
        return value
    return [int(one) if float(one).is_integer() else one for one in found]


def with_ranges(schema: dict[str, Any]) -> None:
    """Say in the JSON schema of a list that it may be a range instead."""
    schema.pop("default", None)
    kept = {key: schema.pop(key) for key in ("type", "items", "minItems") if key in schema}
    schema["anyOf"] = [kept, {"$ref": f"#/$defs/{NAME}"}]
