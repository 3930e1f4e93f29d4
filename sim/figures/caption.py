"""The caption of a figure, and its sentences on parameters, intervals, regimes and gaps."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import Any

import pandas as pd

from sim.figures.data import FigureData
from sim.figures.quantity import Quantity, measures
from sim.figures.style import undecided
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import quantity, setting

_REGIMES = {
    "accelerating": "still accelerating",
    "arrested": "at rest",
    "undetermined": "slowing, or with a trend that is not clear",
    "mixed": "with replicates in different regimes",
}


def caption(data: FigureData, notes: Sequence[str]) -> str:
    """Return the caption: what is drawn, parameters, notes of its kind, what is missing.

    It ends with what the paper says that the figure shows.
    """
    rows, spec = data.rows, data.spec
    sentences = (
        f"{spec.paper}. {spec.lead}" if spec.paper else spec.lead,
        parameters_sentence(rows, spec.system, spec.named),
        protocol_sentence(rows, spec.system),
        *notes,
        caveat_sentence(rows),
        failure_sentence(rows),
        spec.says,
    )
    return " ".join(sentence for sentence in sentences if sentence)


def velocity_notes(data: FigureData) -> list[str]:
    """Return what a caption says of error bars and markers of velocities."""
    return [interval_sentence(data.rows), regime_sentence(data.rows)]


def measure_notes(data: FigureData) -> list[str]:
    """Return what a caption says of error bars and markers of measures."""
    return quantity_notes(data, measures(data))


def quantity_notes(data: FigureData, quantities: Sequence[Quantity]) -> list[str]:
    """Return what a caption says of error bars and markers of quantities, where they are known."""
    known = pd.concat([each.value.notna() for each in quantities], axis=1)
    bars = pd.concat([each.half_width.notna() for each in quantities], axis=1) & known
    sentence = "Error bars: Student's 95 % interval of the mean over replicates"
    if bars.sum().sum() < known.sum().sum():
        sentence += ", none where only one"
    drawn = [f"{sentence}."] if bars.any().any() else []
    return [*drawn, regime_sentence(data.rows[known.any(axis=1)])]


def velocity_text(row: Mapping[str, Any]) -> str:
    """Write the mean velocity of a point with its 95 % interval, if there is one."""
    interval = f" ± {row['half_width']:.2g}" if isfinite(row["half_width"]) else ""
    return f"{row['velocity']:.3g}{interval} m/s"


def parameters_sentence(rows: pd.DataFrame, system: str, names: Sequence[str]) -> str:
    """Write the parameters that the points of a figure share, or the values they take."""
    parts = [
        quantity(system, name, rows[name])
        if field_info(SYSTEMS[system])[name].unit
        else " and ".join(setting(system, name, one) for one in sorted(set(rows[name])))
        for name in names
    ]
    return "Parameters: " + "; ".join(parts) + "."


def protocol_sentence(rows: pd.DataFrame, system: str) -> str:
    """Say how long runs of the converged protocol go on; empty where all are published ones."""
    converged = rows[rows["protocol"] == "converged"]
    if converged.empty:
        return ""
    limit, targets = quantity(system, "limit", converged["limit"]), sorted(set(converged["target"]))
    wanted = ", ".join(f"{100 * target:g}" for target in targets)
    cut = int(converged["stopped"].str.contains("limit").sum())
    return (
        f"Converged protocol ({points_text(len(converged))}): runs go on until the mean is known "
        f"to {wanted} % and no drift is left, {limit} at most, which stopped runs of {cut} of "
        "these points before that; averaged is what the transient leaves."
    )


def interval_sentence(rows: pd.DataFrame) -> str:
    """Say what the error bars are, for how many points of which number of replicates."""
    shown = rows[rows["completed"] > 0]
    over = shown[shown["interval"] == "replicates"]
    within = shown[shown["interval"] == "within run"]
    parts = []
    if len(over):
        numbers = counted(over["completed"])
        parts.append(f"Student's 95 % interval of the mean over {numbers} replicates")
    if len(within):
        which = f" for the {points_text(len(within))} with one replicate" if len(over) else ""
        parts.append(
            f"95 % interval within the run, its correlations counted{which}, which leaves out how "
            "much one initial state differs from another"
        )
    if not parts:
        return ""
    return "Error bars: " + ", ".join(parts) + "."


def regime_sentence(rows: pd.DataFrame) -> str:
    """Explain the markers there are, with the number of points of each; empty if all are steady."""
    shown = rows[rows["completed"] > 0]
    unknown = undecided(shown)
    steady = (shown["regime"] == "steady") & ~unknown
    named = _unsteady(shown[~unknown])
    parts = ["filled markers are steady flows"] if steady.any() else []
    if unknown.any():
        which = "pale ones may be" if parts else "pale markers are flows that may be steady"
        parts.append(
            f"{which}, their runs are too short to tell ({points_text(unknown.sum())}), "
            "and their error bars may be too small"
        )
    if named:
        which = "open ones are" if parts else "open markers are flows"
        parts.append(f"{which} not shown to be{'' if parts else ' steady'}: " + ", ".join(named))
    if not (unknown.any() or named):
        return ""
    text = "; ".join(parts)
    value = "their value is the mean over the averaging window all the same"
    return f"{text[0].upper()}{text[1:]}; {value}."


def _unsteady(rows: pd.DataFrame) -> list[str]:
    """Return how many points are in each regime that is not steady, in words."""
    counts = rows[rows["regime"].isin(_REGIMES)]["regime"].value_counts()
    return [f"{points_text(count)} {_REGIMES[regime]}" for regime, count in counts.items()]


def unsteady_sentence(rows: pd.DataFrame) -> str:
    """Name the flows that are not shown to be steady, where no mark tells; empty if all are."""
    shown = rows[rows["completed"] > 0]
    unknown = undecided(shown)
    named = _unsteady(shown[~unknown])
    if unknown.any():
        named.append(f"{points_text(unknown.sum())} whose runs are too short to tell")
    return f"Not shown to be steady, and drawn all the same: {', '.join(named)}." if named else ""


def caveat_sentence(rows: pd.DataFrame) -> str:
    """Give the caveats of the points and how many carry each; empty if there is none."""
    counts = rows[rows["caveat"] != ""]["caveat"].value_counts()
    return " ".join(f"Caveat for {points_text(count)}: {text}." for text, count in counts.items())


def failure_sentence(rows: pd.DataFrame) -> str:
    """Name the points left out because their run failed, and those that lost replicates."""
    gone = rows[rows["completed"] == 0]
    hurt = rows[(rows["completed"] > 0) & (rows["completed"] < rows["replicates"])]
    sentences = []
    if len(gone):
        named = "; ".join(f"{row.point} ({row.reason})" for row in gone.itertuples())
        sentences.append(f"Left out because the run failed: {named}.")
    if len(hurt):
        named = "; ".join(
            f"{row.point} ({row.completed:g} of {row.replicates:g} replicates left: {row.reason})"
            for row in hurt.itertuples()
        )
        sentences.append(f"Replicates lost: {named}.")
    return " ".join(sentences)


def counted(counts: Iterable[int]) -> str:
    """Write a number that all share, or the range of them: ``3`` or ``3 to 5``."""
    least, most = min(counts), max(counts)
    return f"{least}" if least == most else f"{least} to {most}"


def points_text(count: int) -> str:
    """Write ``1 point`` or ``2 points``."""
    return f"{count} point" + ("" if count == 1 else "s")
