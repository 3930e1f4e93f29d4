"""From a pydantic error to one line that names file, key, value and allowed range."""

import difflib
import re
import typing
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, ValidationError

from sim.base.errors import InputError, in_short, key_path

_UNKNOWN = {"extra_forbidden", "invalid_key"}
_TAG = "system"

#: Characters up to which what is allowed is said although it is known what was meant.
SHORT = 60

_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")


def allowed_values(field: FieldInfo) -> str:
    """Describe the values a field accepts: ``a number in (0, 1]``, ``one of kept, clipped``."""
    extra = field.json_schema_extra
    said = extra.get("allowed") if isinstance(extra, dict) else getattr(extra, "allowed", "")
    if said:
        return str(said)
    if typing.get_origin(field.annotation) is typing.Literal:
        choices = typing.get_args(field.annotation)
        return "one of " + ", ".join(choices) if len(choices) > 1 else str(choices[0])
    if typing.get_origin(field.annotation) is list:
        return "a list of at least one value"
    nouns = {bool: "true or false", str: "text", int: "an integer", float: "a number"}
    kind = field.annotation
    noun = nouns.get(kind) if isinstance(kind, type) else None
    noun = noun or "a mapping of names to values"
    return f"{noun} {_interval(field.metadata)}".strip()


def _interval(metadata: Iterable[Any]) -> str:
    """Write the range constraints of a field as an interval or an inequality."""
    low: tuple[str, str, Any] | None = None
    high: tuple[str, str, Any] | None = None
    for constraint in metadata:
        match constraint:
            case annotated_types.Gt(gt=bound):
                low = (">", "(", bound)
            case annotated_types.Ge(ge=bound):
                low = (">=", "[", bound)
            case annotated_types.Lt(lt=bound):
                high = ("<", ")", bound)
            case annotated_types.Le(le=bound):
                high = ("<=", "]", bound)
    if low and high:
        return f"in {low[1]}{_number(low[2])}, {_number(high[2])}{high[1]}"
    return " ".join(f"{bound[0]} {_number(bound[2])}" for bound in (low, high) if bound)


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.12g}"


def unknown_key(
    source: str, path: str, value: Any, known: Iterable[str], hint: str = ""
) -> InputError:
    """Say that the last key of a path is not known, which may be meant, and which there are."""
    if hint:
        return InputError(f"{source}: {path}: unknown key, got {in_short(value)}; {hint}")
    names = list(known)
    question = did_you_mean(path.rpartition(".")[2], names)
    message = f"unknown key, got {in_short(value)}; {question}allowed: {', '.join(names)}"
    return InputError(f"{source}: {path}: {message}")


def input_error(
    error: ValidationError,
    model: type[BaseModel],
    source: str,
    paths: Mapping[str, str] | None = None,
) -> InputError:
    """Turn the error of validating ``model`` into the line shown to the user.

    Of several errors the first is reported, an unknown key before all others: it often explains
    a missing one; but an unknown choice before it, which may be what the key belongs to.

    Parameters
    ----------
    error : pydantic.ValidationError
        Raised when an instance of ``model`` was built.
    model : type
        Its fields, and those of the models in it, give the allowed ranges.
    source : str
        The file the values come from.
    paths : mapping, optional
        Full path in the file of each key, where that is not the key itself.
    """
    details = error.errors(include_url=False)
    choices = [one for one in details if one["type"] == "literal_error"]
    unknown = [one for one in details if one["type"] in _UNKNOWN]
    entry = (choices if unknown and choices else unknown or details)[0]
    location, owner = _resolve(model, entry["loc"])
    rule = entry["ctx"] if entry["type"] == "rule" else {}
    path = key_path([*location, rule["key"]] if rule.get("key") else location)
    path = (paths or {}).get(path, path)
    if rule:
        return InputError.of_value(source, path, rule["got"], rule["allowed"])
    if entry["type"] in _UNKNOWN:
        hint = _hint(owner, _name(entry), None)
        return unknown_key(source, path, entry["input"], owner.model_fields, hint)
    got = None if entry["type"] == "missing" else entry["input"]
    if entry["type"].startswith("union_tag"):
        kinds = _models_in(owner.model_fields[_name(entry)].annotation)
        allowed = "one of " + ", ".join(tag for kind in kinds for tag in _tags(kind))
        return InputError.of_value(source, f"{path}.{_TAG}", entry["input"].get(_TAG), allowed)
    allowed = _allowed(entry, owner)
    if entry["type"] == "int_type" and isinstance(got, float):
        # With its point, which is what is wrong with it.
        return InputError(f"{source}: {path}: got {got!r}; allowed: {allowed}")
    if hint := _hint(owner, _name(entry), got):
        allowed = f"{allowed}; {hint}" if len(allowed) < SHORT else hint
    return InputError.of_value(source, path, got, allowed)


def _hint(owner: type[BaseModel], key: str, value: Any) -> str:
    """Say what may have been meant by a value, or by a key with none."""
    if isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value):
        return "a number has a decimal point, not a comma"
    return str(getattr(owner, "hint", lambda key, value: "")(key, value))


def _resolve(
    model: type[BaseModel], location: Iterable[str | int]
) -> tuple[list[str | int], type[BaseModel]]:
    """Follow a location through nested models.

    Returns the location without the tags that pydantic puts after a tagged union, and the model
    whose field its last name is.
    """
    path: list[str | int] = []
    owner, candidates = model, [model]
    for part in location:
        holders = [one for one in candidates if part in one.model_fields]
        if isinstance(part, str) and not holders and len(candidates) > 1:
            candidates = [one for one in candidates if part in _tags(one)]
            owner = candidates[0]
            continue
        path.append(part)
        if isinstance(part, str):
            owner = (holders or candidates or [owner])[0]
            candidates = list(_models_in(owner.model_fields[part].annotation)) if holders else []
    return path, owner


def _tags(model: type[BaseModel]) -> tuple[Any, ...]:
    return typing.get_args(model.model_fields[_TAG].annotation)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _models_in(argument)


def _name(entry: ErrorDetails) -> str:
    return next((part for part in reversed(entry["loc"]) if isinstance(part, str)), "")


def _allowed(entry: ErrorDetails, owner: type[BaseModel]) -> str:
    """Say what would have been accepted in place of an entry's input."""
    name = _name(entry)
    # Models of some of the parameters hold lists of values; the ranges are those of the values.
    fields = getattr(owner, "parameters", owner).model_fields
    match entry["type"]:
        case "model_type" | "model_attributes_type" | "dict_type":
            return "a mapping of names to values"
        case "list_type" | "too_short":
            return allowed_values(owner.model_fields[name])
        case "literal_error":
            return entry["ctx"]["expected"]
        case "string_pattern_mismatch" | "string_type" if isinstance(entry["loc"][-1], int):
            (item,) = typing.get_args(owner.model_fields[name].annotation)
            for said in getattr(item, "__metadata__", ()):
                return allowed_values(said)
    allowed = allowed_values(fields[name]) if name in fields else entry["msg"]
    return f"finite, {allowed}" if entry["type"] == "finite_number" else allowed


def did_you_mean(name: str, known: Collection[str]) -> str:
    """Return a question with the names closest to an unknown one, empty without any.

    >>> did_you_mean("frction", ["friction", "depth"])
    'did you mean friction? '
    """
    close = difflib.get_close_matches(name, known, n=3)
    return f"did you mean {' or '.join(close)}? " if close else ""
