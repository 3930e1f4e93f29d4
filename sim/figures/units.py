"""Units of plots: SI, or natural ones of diameter, mass and gravity of a point."""

import pandas as pd

from sim.parameters import SYSTEMS, field_info

#: Natural unit by SI unit: powers of diameter, gravity and mass, and how it is written.
_NATURAL = {
    "m": ((1, 0, 0), "d"),
    "s": ((0.5, -0.5, 0), "√(d/g)"),
    "m s-1": ((0.5, 0.5, 0), "√(gd)"),
    "m s-2": ((0, 1, 0), "g"),
    "m2 s-2": ((1, 1, 0), "gd"),
    "m-2": ((-2, 0, 0), "1/d²"),
    "s-1": ((-0.5, 0.5, 0), "√(g/d)"),
    "N": ((0, 1, 1), "mg"),
    "J": ((1, 1, 1), "mgd"),
    "W": ((0.5, 1.5, 1), "mg√(gd)"),
    "Pa": ((-2, 1, 1), "mg/d²"),
    "kg s-1": ((-0.5, 0.5, 1), "m√(g/d)"),
    "kg m-1 s-1": ((-1.5, 0.5, 1), "m√(g/d)/d"),
}

#: SI units as axes show them.
_AXIS_UNITS = {
    "m s-1": "m/s",
    "m s-2": "m/s²",
    "m2 s-2": "m²/s²",
    "m-2": "1/m²",
    "s-1": "1/s",
    "kg s-1": "kg/s",
    "kg m-1 s-1": "kg/(m s)",
}


def unit_of(unit: str, units: str, system: str) -> str:
    """Return a unit as axes show it, empty for pure numbers.

    >>> unit_of("m s-1", "si", "chute"), unit_of("m s-1", "natural", "chute")
    ('m/s', '√(gσ)')
    """
    if unit == "1":
        return ""
    if units == "natural" and unit in _NATURAL:
        return _NATURAL[unit][1].replace("d", _diameter(system))
    return _AXIS_UNITS.get(unit, unit)


def _diameter(system: str) -> str:
    """Return the symbol of the diameter."""
    return field_info(SYSTEMS[system])["diameter"].symbol


def scale_of(unit: str, units: str, rows: pd.DataFrame) -> pd.Series:
    """Return the divisor of values in an SI unit, for each point; 1 for units ``"si"``."""
    powers = _NATURAL[unit][0] if units == "natural" and unit in _NATURAL else (0, 0, 0)
    length, gravity, mass = powers
    scale = rows["diameter"] ** length * rows["gravity"] ** gravity * rows["mass"] ** mass
    return pd.Series(scale, rows.index, dtype=float)


def label_with_unit(text: str, unit: str) -> str:
    """Return a label with its unit, if any: ``velocity (m/s)``, with a no-break space."""
    return f"{text}\N{NO-BREAK SPACE}({unit})" if unit else text
