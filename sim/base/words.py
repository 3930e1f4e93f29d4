"""Text of quantities for people to read."""

from math import isfinite


def count_text(number: int, noun: str) -> str:
    """Return a number of things in words.

    >>> count_text(1, "point"), count_text(2000, "point")
    ('1 point', '2,000 points')
    """
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def upper_first(text: str) -> str:
    """Return a text that begins with a capital; the rest stays as it is.

    >>> upper_first("mean of V")
    'Mean of V'
    """
    return text[:1].upper() + text[1:]


def percent(share: float) -> str:
    """Write a share in percent, to two digits, or to three just below all; a dash if not known.

    >>> percent(0.5678), percent(12.3456), percent(0.998), percent(0.9999), percent(float("nan"))
    ('57 %', '1200 %', '99.8 %', '99.9 %', '–')
    """
    if not isfinite(share):
        return "–"
    if 0.99 < share < 1:
        return f"{min(99.9, 100 * share):.3g} %"
    return f"{float(f'{100 * share:.2g}'):.12g} %"


def duration(seconds: float) -> str:
    """Return a time in the unit that suits it: ``4.5 s``, ``3.1 min``, ``2.0 h``.

    >>> duration(90)
    '1.5 min'
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.1f} min" if seconds < 3600 else f"{seconds / 3600:.1f} h"


def printable(text: str) -> str:
    """Return a text whose control characters and direction marks are replaced by their codes.

    >>> printable("a\\x1b[2J")
    'a\\\\x1b[2J'
    """
    allowed = "\n\N{NO-BREAK SPACE}"
    return "".join(
        letter if letter.isprintable() or letter in allowed else ascii(letter)[1:-1]
        for letter in text
    )
