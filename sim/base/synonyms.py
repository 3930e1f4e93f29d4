"""Other words for the names of Talus, by which errors find the name that was meant.

The rooms that know such words register them.
"""

import unicodedata
from collections.abc import Collection

#: Names by the words that may stand for them.
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
