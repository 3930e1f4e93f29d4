"""Words of figures: units and labels; captions with counts, and details with parameters."""

import re
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import pandas as pd

from sim.base.errors import count_text
from sim.figures.data import FigureData, Quantity, is_undecided, quantities
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import quantity, setting
from sim.study.figure_spec import DataSet
from sim.study.plot_contents import name_in_words, parameter_phrase

#: Most values of a parameter that a caption lists.
MOST_VALUES = 12

#: What counts call flows that may be steady.
SHORT = "too short to tell"


def caption(data: FigureData, notes: Sequence[str]) -> str:
    """Return the caption and, after an empty line, the details, a line each.

    The caption has what is shown, what the paper says of it, the first of the ``notes`` of a kind,
    and how many points are in which state. Parameters, caveats and failures are details.
    """
    rows, spec = data.rows, data.spec
    first, *others = notes or [""]
    sentences = (
        f"{spec.paper}. {spec.lead}" if spec.paper else spec.lead,
        spec.says,
        first,
        counts_line(rows),
    )
    details = (
        spec.details,
        *others,
        foreign_sentence(spec.foreign),
        answer_sentence(data),
        protocol_sentence(rows, spec.system),
        caveat_sentence(rows),
        failure_sentence(rows),
        *parameter_lines(rows, spec.system, spec.named),
    )
    short, lines = " ".join(filter(None, sentences)), "\n".join(filter(None, details))
    return f"{short}\n\n{lines}".strip()


def parted(text: str) -> tuple[str, list[str]]:
    """Return the caption in a file of it, and the details.

    >>> parted("Velocity. Points: steady 3.\\n\\nCaveat.\\nrestitution: e = 0.9\\n")
    ('Velocity. Points: steady 3.', ['Caveat.', 'restitution: e = 0.9'])
    """
    short, _, details = text.strip().partition("\n\n")
    return short, details.splitlines()


def counts_line(rows: pd.DataFrame) -> str:
    """Count the points in each state, and those with a caveat, the most frequent of which is named.

    Empty where no point has a state.
    """
    states = rows["regime"].mask(is_undecided(rows), SHORT).where(rows["completed"] > 0, "failed")
    text = counted(states)
    caveats = rows["caveat"][rows["caveat"] != ""].value_counts()
    if len(caveats):
        mostly = "mostly: " if len(caveats) > 1 else ""
        text += f"; with a caveat {caveats.sum()} ({mostly}{first_clause(caveats.index[0])})"
    return f"Points: {text}." if text else ""


def counted(states: pd.Series) -> str:
    """Return how many points are in each state, those that are steady first.

    >>> counted(pd.Series(["failed", "steady", "failed"]))
    'steady 1, failed 2'
    """
    counts = states.value_counts().to_dict()
    order = sorted(counts, key=lambda state: (state != "steady", state == "failed", -counts[state]))
    return ", ".join(f"{state} {counts[state]}" for state in order)


def first_clause(caveat: str) -> str:
    """Return what a caveat warns of, without its reasons and cures."""
    return re.split("[,;]", caveat)[0]


def point_notes(data: FigureData, shown: Sequence[Quantity] | None = None) -> list[str]:
    """Return the sentence on intervals of quantities, and one on points that are not steady.

    By default, the quantities are the measures of a figure or its velocities, which alone have
    intervals within the run.
    """
    rows = data.rows[data.rows["completed"] > 0]
    each = quantities(data) if shown is None else shown
    is_within = (rows["interval"] == "within run") & any(one.name == "velocity" for one in each)
    text = ""
    if any(one.half_width[rows.index].notna().any() for one in each):
        text = "Intervals: 95 %, of the mean over replicates (Student); they may go beyond the axes"
        if is_within.any():
            text += "; of one replicate within the run, without how much initial states differ"
        text += "."
    is_mean = (rows["regime"] != "steady") | is_undecided(rows)
    line = "a thin line" if data.spec.joins_open else "no line"
    mean = (
        f"Pale and open markers, too, are means over the averaging window; {line} joins open ones."
    )
    return [text, mean if is_mean.any() else ""]


def velocity_text(row: Mapping[str, Any]) -> str:
    """Write the mean velocity of a point with its 95 % interval, if there is one."""
    interval = f" ± {row['half_width']:.2g}" if isfinite(row["half_width"]) else ""
    return f"{row['velocity']:.3g}{interval} m/s"


def parameter_lines(rows: pd.DataFrame, system: str, names: Sequence[str]) -> list[str]:
    """Return a line for each parameter: its name, and the values of the points."""
    declared = field_info(SYSTEMS[system])
    return [
        f"{name_in_words(name)}: {values_text(system, name, rows[name])}"
        if declared[name].unit
        else " and ".join(setting(system, name, value) for value in sorted(set(rows[name])))
        for name in names
    ]


def values_text(system: str, name: str, values: pd.Series) -> str:
    """Write the values of a parameter, or the ends and the number of many."""
    number = values.nunique()
    if number <= MOST_VALUES:
        return quantity(system, name, values)
    ends = quantity(system, name, [values.min(), values.max()]).replace(", ", " to ")
    return f"{ends} ({number} values)"


def protocol_sentence(rows: pd.DataFrame, system: str) -> str:
    """Write how long runs of the converged protocol last; empty where no point has it."""
    converged = rows[rows["protocol"] == "converged"]
    if converged.empty:
        return ""
    limit, targets = quantity(system, "limit", converged["limit"]), sorted(set(converged["target"]))
    precisions = ", ".join(f"{100 * target:g}" for target in targets)
    limited = count_text(converged["stopped"].str.contains("limit").sum(), "point")
    return (
        f"Converged protocol ({count_text(len(converged), 'point')}): until the mean is known to "
        f"{precisions} % without a drift, at most {limit}, which {limited} reached."
    )


def answer_sentence(data: FigureData) -> str:
    """Count the flows that an answer counts in and leaves out; empty for other figures."""
    if not data.spec.answer.file or not (data.rows["completed"] > 0).any():
        return ""
    rows = data.flows_of_answer
    counted_in = rows["regime"].mask(is_undecided(rows), SHORT)[rows["is_counted"]]
    left_out = rows["regime"].where(rows["has_value"], "without a value")[~rows["is_counted"]]
    texts = {"In the answer": counted_in, "left out of it": left_out}
    parts = [f"{what}: {counted(one)}" for what, one in texts.items() if len(one)]
    return "; ".join(parts) + "."


def foreign_sentence(foreign: Sequence[DataSet]) -> str:
    """Name the data that are not of the study; empty without any."""
    labels = [
        f"{label} ({'line' if joined else 'markers'}{', bars: its errors' * (len(points[0]) > 2)})"
        for label, points, joined in foreign
    ]
    return f"In grey, from elsewhere and not simulated here: {'; '.join(labels)}." if labels else ""


def caveat_sentence(rows: pd.DataFrame) -> str:
    """Write each caveat with the number of its points; empty if there is none."""
    counts = rows[rows["caveat"] != ""]["caveat"].value_counts().items()
    return " ".join(f"Caveat for {count_text(count, 'point')}: {text}." for text, count in counts)


def failure_sentence(rows: pd.DataFrame) -> str:
    """Name the points whose run failed, and those that lost replicates; empty if there are none."""
    failed: list[str] = []
    incomplete: list[str] = []
    for row in rows[rows["completed"] < rows["replicates"]].itertuples():
        if row.completed:
            left = f"{row.completed:g} of {row.replicates:g} replicates left"
            incomplete.append(f"{row.point} ({left}: {row.reason})")
        else:
            failed.append(f"{row.point} ({row.reason})")
    texts = {"Left out because the run failed": failed, "Replicates lost": incomplete}
    return " ".join(f"{what}: {'; '.join(points)}." for what, points in texts.items() if points)


def not_drawn(count: int, why: str) -> list[str]:
    """Return the note on what a picture leaves out, and why; empty where it leaves out nothing."""
    return [f"Not drawn, {why}: {count:,}."] if count else []


# Units of parameters and observables, and how axes and headings write them.

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
        return _NATURAL[unit][1].replace("d", field_info(SYSTEMS[system])["diameter"].symbol)
    return _AXIS_UNITS.get(unit, unit)


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
    row = field_info(SYSTEMS[system])[name]
    is_natural = units == "natural" and row.unit in _NATURAL
    unit = unit_of(row.unit, units, system) if is_natural else row.unit_text.strip()
    return label_with_unit(parameter_phrase(system, name), row.scale or unit)


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
