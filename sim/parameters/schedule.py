"""The schedule of a point: parameters of its drive as functions of time.

Between two times a value is linear; before the first and after the last one it is constant. Of two
values at one time the later one holds from then on.
"""

import re
from collections.abc import Mapping
from math import isfinite
from typing import Annotated, Any

from pydantic import BeforeValidator, TypeAdapter, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

from sim.base.messages import allowed_values
from sim.parameters.common import Parameters, broken_rule, canonical_number

#: Times, in the unit of ``transient``, and values of a parameter.
Course = list[tuple[float, float]]

#: The canonical form.
_TEXT = re.compile(r"(\w+( [-+.\de]+:[-+.\de]+)+(; |$))+")

_PAIRS = "two [time, value] or more, times from 0 on in order, at most two of them equal"
_JSON = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}, "minItems": 2}


def courses(text: str) -> dict[str, Course]:
    """Return the courses of a canonical schedule by parameter.

    >>> courses("angle 0:30 200:22")
    {'angle': [(0.0, 30.0), (200.0, 22.0)]}
    """
    every: dict[str, Course] = {}
    for part in text.split("; ") if text else ():
        name, *pairs = part.split(" ")
        rows = (pair.split(":") for pair in pairs)
        every[name] = [(float(time), float(value)) for time, value in rows]
    return every


def canonical_schedule(value: Any) -> str:
    """Return a mapping, parameter → list of [time, value], as one text; a text of this form stays.

    >>> canonical_schedule({"angle": [[0, 30], [200, 22]]})
    'angle 0:30 200:22'
    """
    if value == "":
        return ""
    mapping = courses(value) if isinstance(value, str) and _TEXT.fullmatch(value) else value
    names = list(mapping) if isinstance(mapping, Mapping) else []
    if not names or not all(isinstance(name, str) and name.isidentifier() for name in names):
        raise broken_rule("", value, "a mapping such as {angle: [[0, 30], [200, 22]]}")
    parts = []
    for name, rows in sorted(mapping.items()):
        pairs = (f"{time:.12g}:{number:.12g}" for time, number in _checked(rows))
        parts.append(" ".join([name, *pairs]))
    return "; ".join(parts)


def _checked(rows: Any) -> Course:
    is_list = isinstance(rows, list) and len(rows) > 1
    if is_list and all(isinstance(row, list | tuple) and len(row) == 2 for row in rows):
        numbers = [canonical_number(number) for row in rows for number in row]
        if all(type(number) is float and isfinite(number) for number in numbers):
            times = numbers[::2]
            if times[0] >= 0 and times == sorted(times) and max(map(times.count, times)) < 3:
                return list(zip(times, numbers[1::2], strict=True))
    raise broken_rule("", rows, _PAIRS)


#: A schedule; its canonical form is a text.
Schedule = Annotated[
    str,
    BeforeValidator(canonical_schedule),
    WithJsonSchema({"type": ["object", "string"], "additionalProperties": _JSON}),
]


def with_ends(values: Any, driven: tuple[str, ...]) -> Any:
    """Return the values of a point, of parameters with a schedule the last one where omitted."""
    if not isinstance(values, Mapping) or not values.get("schedule"):
        return values
    try:
        every = courses(canonical_schedule(values["schedule"]))
    except PydanticCustomError:
        return values
    return {name: rows[-1][1] for name, rows in every.items() if name in driven} | dict(values)


def require_schedule(p: Parameters, text: str, driven: tuple[str, ...]) -> None:
    """Refuse what a drive cannot follow: other parameters and values, and changes after the start
    of the average.
    """
    for name, rows in courses(text).items():
        allowed = f"a schedule of {' and '.join(driven)} alone"
        p.require("schedule", name in driven, allowed)
        field = type(p).model_fields[name]
        check = TypeAdapter(Annotated[float, *field.metadata])
        for _, value in rows:
            try:
                check.validate_python(value)
            except ValidationError:
                allowed = f"for {name}, {allowed_values(field)}"
                raise broken_rule("schedule", text, allowed) from None
        time, last = rows[-1]
        allowed = f"{last:g}, with which its schedule ends, or omitted"
        p.require(name, getattr(p, name) == last, allowed)
        p.require("transient", p.transient >= time, f"at least {time:g}, when the schedule ends")
