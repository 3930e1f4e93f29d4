"""Texts of a claim whose numbers are filled from its bounds, so that each number stands once."""

from collections.abc import Mapping, Sequence
from string import Formatter
from typing import Any

Number = int | float

#: What a bound may be: a number, a list of numbers, or a list of pairs.
Bound = Number | list[Number] | list[list[Number]]

#: Numbers written as words, by themselves and as factors.
_WORDS = {0.1: "a tenth", 0.5: "half", 1: "one", 2: "two", 5: "five"}
_FACTORS = {2: "twice"}


class _Text(Formatter):
    """Python's format syntax, with formats of its own.

    ``percent`` writes a share in percent, ``words`` a number as a word, ``times`` a factor. A list
    is written with commas, with ``and`` before its last item if that is its format.
    """

    def format_field(self, value: Any, spec: str) -> str:
        if isinstance(value, list):
            return _join(value, spec)
        match spec:
            case "percent":
                return f"{100 * value:g}"
            case "words":
                return _WORDS.get(value, f"{value:g}")
            case "times":
                return _FACTORS.get(value, f"{value:g} times")
        return format(value, spec or "g").replace("e-0", "e-")


def _join(items: Sequence[Any], spec: str) -> str:
    texts = [f"({_join(item, '')})" if isinstance(item, list) else f"{item:g}" for item in items]
    if spec == "and":
        return f"{', '.join(texts[:-1])} and {texts[-1]}"
    return ", ".join(texts)


def fill(text: str, bounds: Mapping[str, Any]) -> str:
    """Return a text with its bounds filled in.

    >>> fill("{share:percent} % at {angles:and} degrees", {"share": 0.1, "angles": [30, 45, 60]})
    '10 % at 30, 45 and 60 degrees'

    Raises
    ------
    ValueError
        When braces in the text name no bound, or a format does not fit it.
    """
    try:
        return _Text().vformat(text, (), bounds)
    except (LookupError, AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"one that fits each brace of {text!r}: {error}") from None
