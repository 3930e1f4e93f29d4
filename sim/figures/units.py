"""Units of parameters and observables, and how axes and headings write them."""

import re

import pandas as pd

from sim.parameters import SYSTEMS, field_info
from sim.study.plot_contents import name_in_words, parameter_phrase

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
    "kg": ((0, 0, 1), "m"),
    "N m-1": ((-1, 1, 1), "mg/d"),
    "kg s-1": ((-0.5, 0.5, 1), "m√(g/d)"),
    "kg m-1 s-1": ((-1.5, 0.5, 1), "m√(g/d)/d"),
}

#: What natural units have, and those by which a label can be divided without brackets.
_NATURAL_UNIT, _ONE_FACTOR = re.compile("[σ⟨]|^m?g$"), re.compile(r"⟨d⟩|\w|√\([^()]*\)")

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
    return field_info(SYSTEMS[system])["diameter"].symbol


def scale_of(unit: str, units: str, rows: pd.DataFrame) -> pd.Series:
    """Return the divisor of values in an SI unit, for each point; 1 for units ``"si"``."""
    powers = _NATURAL[unit][0] if units == "natural" and unit in _NATURAL else (0, 0, 0)
    length, gravity, mass = powers
    scale = rows["diameter"] ** length * rows["gravity"] ** gravity * rows["mass"] ** mass
    return pd.Series(scale, rows.index, dtype=float)


def parameter_text(system: str, name: str, units: str = "si") -> str:
    """Return the label of a parameter, in the unit of study files.

    >>> parameter_text("belt", "amplitude"), parameter_text("chute", "stiffness", "natural")
    ('amplitude A_z/⟨d⟩', 'stiffness K1/(mg/σ)')
    """
    return label_with_unit(parameter_phrase(system, name), parameter_unit_text(system, name, units))


def parameter_unit_text(system: str, name: str, units: str) -> str:
    """Return the unit of a parameter as people write it, in a study with these units."""
    row = field_info(SYSTEMS[system])[name]
    if units == "natural" and row.unit in _NATURAL:
        return row.scale or unit_of(row.unit, units, system)
    return row.scale or row.unit_text.strip()


def observable_text(name: str, unit: str, units: str, system: str) -> str:
    """Return the label of an observable in an SI unit: its name and its unit, as of `unit_of`."""
    return label_with_unit(name_in_words(name), unit_of(unit, units, system))


def label_with_unit(text: str, unit: str) -> str:
    """Return a label with its unit, if any; a quantity is divided by a natural unit.

    The space before a unit in brackets does not break.

    >>> label_with_unit("height z", "⟨d⟩"), label_with_unit("stress", "mg/σ²")
    ('height z/⟨d⟩', 'stress/(mg/σ²)')
    >>> label_with_unit("height z", "m") == "height z\N{NO-BREAK SPACE}(m)"
    True
    """
    if not unit:
        return text
    if not _NATURAL_UNIT.search(unit):
        return f"{text}\N{NO-BREAK SPACE}({unit})"
    return f"{text}/{unit if _ONE_FACTOR.fullmatch(unit) else f'({unit})'}"


def parameter_unit(system: str, name: str) -> str:
    """Return the unit of a parameter in study files, as in headings; empty for a choice."""
    row = field_info(SYSTEMS[system])[name]
    return row.scale or row.unit or ""


def parameter_heading(system: str, name: str) -> str:
    """Return the heading of a column with a parameter."""
    unit = parameter_unit(system, name)
    return f"{name} [{unit}]" if unit else name
