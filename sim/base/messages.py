"""Pydantic errors as one line that names file, key, value and allowed range."""

import difflib
import re
import typing
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from math import pi
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, ValidationError

from sim.base.additions import plain_name
from sim.base.errors import Allowed, InputError, in_short, key_path
from sim.base.numbers import number

_UNKNOWN = {"extra_forbidden", "invalid_key"}
_TAG = "system"

#: Up to this length, the allowed values are named in addition to a hint.
SHORT = 60

#: Most names that a message lists, and fewest names like another that are listed in place of all.
MOST_NAMES, _FEWEST = 12, 3

#: Least ratio (`difflib`) of what may be typed for what.
_LIKE = 0.72

_QUOTED = re.compile(r"'([^']*)'")

#: A unit begins with no digit, but for 1/s.
_WITH_UNIT = re.compile(
    r"([-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)(?:\s*(?!\d)|\s+(?=1/))(\S.*)", re.ASCII
)

_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(\s*[^\d\s,].*)?")

_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


def allowed_values(field: FieldInfo) -> str:
    """Describe the values a field accepts: ``a number in (0, 1]``, ``one of kept, clipped``."""
    extra = field.json_schema_extra
    text = extra.get("allowed") if isinstance(extra, dict) else getattr(extra, "allowed", "")
    if text:
        return str(text)
    if typing.get_origin(field.annotation) is typing.Literal:
        choices = typing.get_args(field.annotation)
        return "one of " + ", ".join(choices) if len(choices) > 1 else str(choices[0])
    nouns: dict[Any, str] = {bool: "true or false", str: "text", int: "an integer"}
    nouns |= {float: "a number", list: "a list of at least one value"}
    kind = typing.get_origin(field.annotation) or field.annotation
    noun = nouns.get(kind, "a mapping of names to values")
    return f"{noun} {_interval(field.metadata)}".strip()


def _interval(metadata: Iterable[Any]) -> str:
    bounds = {
        name: getattr(constraint, name)
        for constraint in metadata
        for name in _SIGNS
        if getattr(constraint, name, None) is not None
    }
    texts = {
        name: str(bound) if isinstance(bound, int) else f"{bound:.12g}"
        for name, bound in sorted(bounds.items())
    }
    if len(texts) < 2:
        return "".join(f"{_SIGNS[name]} {text}" for name, text in texts.items())
    low, high = texts
    return f"in {'(['[low == 'ge']}{', '.join(texts.values())}{')]'[high == 'le']}"


def unknown_key(
    source: str, path: str, value: Any, known: Iterable[str], hint: str = ""
) -> InputError:
    """Return the error of an unknown last key of a path, with similar and known keys."""
    names, key = list(known), path.rpartition(".")[2]
    hint = hint or f"{did_you_mean(key, names)}allowed: {near(key, names)}"
    return InputError(f"{source}: {path}: unknown key, got {in_short(value)}; {hint}")


def input_error(
    error: ValidationError,
    model: type[BaseModel],
    source: str,
    paths: Mapping[str, str] | None = None,
    key_hint: Callable[[str], str] = lambda key: "",
) -> InputError:
    """Turn the error of validating ``model`` into the line shown to the user.

    Only one error is reported. An unknown key comes first, as it often explains a missing one;
    an unknown choice comes before it, as the key may belong to the choice.

    The fields of the model, and those of the models in it, give the allowed ranges. The values come
    from the file ``source``; ``paths`` has the full path in it of each key, where that is not the
    key itself. ``key_hint`` gives a hint on an unknown key, ``""`` without any; models with a
    method ``hint`` need none.
    """
    details = error.errors(include_url=False)
    choices = [detail for detail in details if detail["type"] == "literal_error"]
    unknown = [detail for detail in details if detail["type"] in _UNKNOWN]
    entry = (choices if unknown and choices else unknown or details)[0]
    location, owner = _resolve(model, entry["loc"])
    kind, name, got = entry["type"], _name(entry), entry["input"]
    rule = entry["ctx"] if kind == "rule" else {}
    path = key_path([*location, rule["key"]] if rule.get("key") else location)
    path = (paths or {}).get(path, path)
    match kind:
        case "rule":
            (got,) = rule["got"]
            return InputError.of_value(source, path, got, rule["allowed"])
        case "extra_forbidden" | "invalid_key":
            hint = _hint(owner, name, None) or key_hint(name)
            known = owner.model_fields | getattr(owner, "in_place", {})
            return unknown_key(source, path, got, known, hint)
        case "union_tag_invalid" | "union_tag_not_found":
            models, tag = _models_in(owner.model_fields[name].annotation), got.get(_TAG)
            every = one_of(tag, [one for model in models for one in _tags(model)])
            return InputError.of_value(source, f"{path}.{_TAG}", tag, every)
        case "missing":
            got = None
        case "int_type" if isinstance(got, float):
            # The value keeps its decimal point, which is the mistake.
            return InputError(f"{source}: {path}: got {got!r}; allowed: {_allowed(entry, owner)}")
    allowed, options = _allowed(entry, owner), _options(entry)
    if hint := _hint(owner, name, got):
        # A hint replaces what takes long to read, but not the few options of a choice.
        is_short = len(options) <= MOST_NAMES if options else len(allowed) < SHORT
        allowed = f"{allowed}; {hint}" if is_short else hint
    return InputError.of_value(source, path, got, allowed)


def _hint(owner: type[BaseModel], key: str, value: Any) -> str:
    """Return a hint on a wrong value or, for None, on a wrong key; ``""`` without any."""
    if isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value):
        return "a number has a decimal point, not a comma"
    return str(getattr(owner, "hint", lambda key, value: "")(key, value))


def _resolve(
    model: type[BaseModel], location: Iterable[str | int]
) -> tuple[list[str | int], type[BaseModel]]:
    """Follow a location through nested models.

    Returns the location without pydantic's tags of tagged unions, and the model that has its last
    name as a field.
    """
    path: list[str | int] = []
    owner, candidates = model, [model]
    for part in location:
        holders = [candidate for candidate in candidates if part in candidate.model_fields]
        if isinstance(part, str) and not holders and len(candidates) > 1:
            candidates = [candidate for candidate in candidates if part in _tags(candidate)]
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


def _allowed(entry: ErrorDetails, owner: type[BaseModel]) -> str | Allowed:
    name = _name(entry)
    # In models with lists of values (grids), the ranges are those of the single values.
    fields = getattr(owner, "parameters", owner).model_fields | getattr(owner, "in_place", {})
    match entry["type"]:
        case "model_type" | "model_attributes_type" | "dict_type":
            return "a mapping of names to values"
        case "list_type" | "too_short":
            return allowed_values(owner.model_fields[name])
        case "literal_error":
            *first, last = options = _options(entry)
            if len(options) > MOST_NAMES:
                return one_of(entry["input"], options)
            return " or ".join(filter(None, (", ".join(map(repr, first)), repr(last))))
        case "string_pattern_mismatch" | "string_type" if isinstance(entry["loc"][-1], int):
            (item,) = typing.get_args(owner.model_fields[name].annotation)
            for constraint in getattr(item, "__metadata__", ()):
                return allowed_values(constraint)
    if name not in fields:
        return entry["msg"]
    allowed = allowed_number(fields[name], entry["input"])
    return f"finite, {allowed}" if entry["type"] == "finite_number" else allowed


def _options(entry: ErrorDetails) -> list[str]:
    """Return the options of a choice, those of plug-ins without their hash, as in files."""
    expected = entry["ctx"]["expected"] if entry["type"] == "literal_error" else ""
    return [plain_name(name) for name in _QUOTED.findall(expected)]


def allowed_number(field: FieldInfo, value: Any) -> str:
    """Describe the values a field accepts, with the unit of numbers, to who gave a ``value``."""
    extra, allowed = field.json_schema_extra, allowed_values(field)
    if not isinstance(value, int | float | str) or field.annotation not in (int, float):
        return allowed
    if isinstance(value, str):
        with suppress(ValueError):
            number(value)
            return f"{allowed}, without quotes"
    unit = getattr(extra, "scale", "") or getattr(extra, "unit_text", "").strip()
    if unit:
        return f"{allowed}, in {unit}" + ", or with a unit of its kind" * isinstance(value, str)
    most = max((one.le for one in field.metadata if hasattr(one, "le")), default=0)
    # What is little above 1 is no share in percent.
    if isinstance(value, int | float) and most <= 1 and 2 <= value <= 100 * most:
        return f"{allowed}; {value:g} % is {value / 100:g}"
    return allowed


def number_and_unit(text: Any) -> tuple[float, str] | None:
    """Return the two parts of a text such as ``2 mm``, None of anything else.

    >>> number_and_unit("2 mm"), number_and_unit("30 1/s"), number_and_unit("20")
    ((2.0, 'mm'), (30.0, '1/s'), None)
    """
    match = _WITH_UNIT.fullmatch(text.strip()) if isinstance(text, str) else None
    return (number(match[1]), match[2]) if match else None


def one_of(name: Any, options: Collection[str]) -> Allowed:
    """Return what is allowed in place of a name: all options if they are few, else the nearest.

    Anything but a text is near to no option.

    >>> one_of("hertzian", ["drag", "hertz"])
    Allowed(question='did you mean hertz? ', names='one of drag, hertz')
    """
    word = name if isinstance(name, str) else ""
    return Allowed(did_you_mean(word, options), f"one of {near(word, options)}")


def near(name: str, options: Collection[str], most: int = MOST_NAMES) -> str:
    """Return options separated by commas: all if they are few, else those most like a name.

    Where none is like it, the first ones stand for all; one or two, which `did_you_mean` names,
    are no list.

    >>> near("depth", ["friction", "fraction", "depth"], most=2)
    '3 names (talus job schema has all)'
    """
    if len(options) <= most:
        return ", ".join(options)
    similar = difflib.get_close_matches(name, options, n=most) or names_meant(name, options)
    if 0 < len(similar) < _FEWEST:
        return f"{len(options)} names (talus job schema has all)"
    named = similar or list(options)[: most - 2]
    return f"{', '.join(named)} and {len(options) - len(named)} more (talus job schema has all)"


def did_you_mean(name: str, known: Collection[str]) -> str:
    """Return a question with the known names that ``name`` stands for or that are closest to it.

    It is ``""`` without any.

    >>> did_you_mean("frction", ["friction", "friction_cap", "depth"])
    'did you mean friction? '
    """
    close = names_meant(name, known) or _typed(name, known)
    return f"did you mean {' or '.join(close)}? " if close else ""


def _typed(name: str, known: Collection[str]) -> list[str]:
    """Return the known name that ``name`` is but for a slip, if there is one.

    Each of its words is then like one: ``fill_height`` is no slip of ``slice_height``.
    """
    words = {one: one.lower().split("_") for one in known}
    given = name.lower().split("_")
    close = difflib.get_close_matches(
        "".join(given), {"".join(each): None for each in words.values()}, n=1, cutoff=_LIKE
    )
    return [
        one
        for one, each in words.items()
        if "".join(each) in close and (len(each) != len(given) or all(map(_is_like, given, each)))
    ][:1]


def _is_like(word: str, other: str) -> bool:
    return difflib.SequenceMatcher(None, word, other).ratio() >= _LIKE


#: Names of Talus by other words that may stand for them; the rooms that know such words add them.
_NAMES: dict[str, dict[str, None]] = {}


def add_synonym(word: str, name: str) -> None:
    """Register a word or a symbol for a name; it may stand for several."""
    _NAMES.setdefault(_spelled(word), {})[name] = None


def names_meant(word: str, known: Collection[str]) -> list[str]:
    """Return the known names for which a word or symbol stands, however it is spelled.

    >>> add_synonym("μ", "friction")
    >>> names_meant("mu", ["friction", "depth"])
    ['friction']
    """
    names = _NAMES.get(_spelled(word)) or _NAMES.get(_spelled(word).lower(), {})
    return [name for name in names if name in known]


def _spelled(word: str) -> str:
    """Return a word with the names of Greek letters, without brackets and signs."""
    letters = unicodedata.normalize("NFKC", word)
    return "".join(
        unicodedata.name(letter).split()[-1].lower() if "Ͱ" <= letter <= "Ͽ" else letter
        for letter in letters
        if letter.isalnum() or letter in "_/"
    )


#: Size in SI units, and powers of metre, kilogram, second and radian.
_Unit = tuple[float, tuple[int, ...]]

_PURE, _DEGREE, _MINUTE = (0, 0, 0, 0), (pi / 180, (0, 0, 0, 1)), (60, (0, 0, 1, 0))

_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}

#: Units that take a prefix, with their powers; a gram is a thousandth of the unit.
_PREFIXED = {"m": (1, 0, 0, 0), "g": (0, 1, 0, 0), "s": (0, 0, 1, 0), "rad": (0, 0, 0, 1)}
_PREFIXED |= {"Hz": (0, 0, -1, 0), "N": (1, 1, -2, 0), "J": (2, 1, -2, 0), "W": (2, 1, -3, 0)}
_PREFIXED |= {"Pa": (-1, 1, -2, 0)}

_UNITS: dict[str, _Unit] = {
    prefix + name: (scale * (1e-3 if name == "g" else 1), powers)
    for prefix, scale in {**_PREFIXES, "": 1}.items()
    for name, powers in _PREFIXED.items()
}
_UNITS |= {"1": (1, _PURE), "-": (1, _PURE), "%": (0.01, _PURE), "min": _MINUTE}
_UNITS |= {"h": (3600, _MINUTE[1]), "rpm": (1 / 60, (0, 0, -1, 0))}
_UNITS |= dict.fromkeys(("°", "deg", "degree", "degrees"), _DEGREE)

#: Other spellings of the same letters.
_SPELLINGS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻\N{MINUS SIGN}μ·*", "0123456789--µ  ")

_FACTOR = re.compile(r"([A-Za-zµ°%]+|1|-)(?:\^?(-?[0-9]))?")


def conversion(unit: str, to: str) -> float | None:
    """Return how many of one unit another makes, ``None`` if one is unknown or of another kind.

    >>> conversion("mm/s", "m s-1"), conversion("kg", "m")
    (0.001, None)
    """
    one, other = _parse(unit), _parse(to)
    if one is None or other is None or one[1] != other[1]:
        return None
    return one[0] / other[0]


def _parse(text: str) -> _Unit | None:
    """Return the size and the powers of a unit, ``None`` if it is unknown."""
    size, powers = 1.0, list(_PURE)
    above, *below = text.translate(_SPELLINGS).split("/")
    parts = [(factor, 1) for factor in above.split()]
    parts += [(factor, -1) for part in below for factor in part.strip().strip("()").split()]
    for factor, sign in parts:
        match = _FACTOR.fullmatch(factor)
        if match is None or match[1] not in _UNITS:
            return None
        exponent = sign * int(match[2] or 1)
        factor_size, factor_powers = _UNITS[match[1]]
        size *= factor_size**exponent
        powers = [power + exponent * own for power, own in zip(powers, factor_powers, strict=True)]
    return (size, tuple(powers)) if parts else None
