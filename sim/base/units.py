"""Units of measurement as people write them: ``mm/s``, ``kg m-3``, ``1/s²``, ``deg``."""

import re
from math import pi

#: Size in SI units, and powers of metre, kilogram, second and radian.
_Unit = tuple[float, tuple[int, ...]]

#: Units that take a prefix.
_PREFIXED: dict[str, _Unit] = {
    "m": (1, (1, 0, 0, 0)),
    "g": (1e-3, (0, 1, 0, 0)),
    "s": (1, (0, 0, 1, 0)),
    "rad": (1, (0, 0, 0, 1)),
    "Hz": (1, (0, 0, -1, 0)),
    "N": (1, (1, 1, -2, 0)),
    "J": (1, (2, 1, -2, 0)),
    "W": (1, (2, 1, -3, 0)),
    "Pa": (1, (-1, 1, -2, 0)),
}

_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}

_PURE, _DEGREE, _MINUTE = (0, 0, 0, 0), (pi / 180, (0, 0, 0, 1)), (60, (0, 0, 1, 0))

_UNITS: dict[str, _Unit] = {
    **{
        prefix + name: (scale * size, powers)
        for prefix, scale in _PREFIXES.items()
        for name, (size, powers) in _PREFIXED.items()
    },
    **_PREFIXED,
    "1": (1, _PURE),
    "-": (1, _PURE),
    "%": (0.01, _PURE),
    "°": _DEGREE,
    "deg": _DEGREE,
    "degree": _DEGREE,
    "degrees": _DEGREE,
    "min": _MINUTE,
    "h": (3600, (0, 0, 1, 0)),
}

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
