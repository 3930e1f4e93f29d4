"""Caption and details of a figure: sentences on parameters, intervals, regimes and gaps."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np
import pandas as pd

from sim.dataset.replicates import answering_regime, replicate_values
from sim.figures.data import FigureData, Quantity, quantities
from sim.figures.style import is_undecided
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import quantity, setting
from sim.study.plot_contents import in_words, name_in_words
from sim.study.plot_kinds import REGIME
from sim.study.plottable import numbers
from sim.study.surrogate import SLOWING

#: How captions name the regimes that are not steady.
_REGIMES = {
    "accelerating": "still accelerating",
    "arrested": "at rest",
    "undetermined": "slowing, or with a trend that is not clear",
    "mixed": "with replicates in different regimes",
    SLOWING: "surely slowing down",
}


#: Most values of a parameter that a caption lists.
MOST_VALUES = 12


def caption(data: FigureData, notes: Sequence[str]) -> str:
    """Return the caption and, after an empty line, the details, a line each.

    The caption has what is shown, what the paper says of it, what bars or marks are, and what is in
    doubt. The first of the ``notes`` of a kind belongs to it, the others to the details.
    """
    rows, spec = data.rows, data.spec
    first, *others = notes or [""]
    sentences = (
        f"{spec.paper}. {spec.lead}" if spec.paper else spec.lead,
        spec.says,
        first,
        doubt_sentence(data),
    )
    details = (
        spec.details,
        parameters_sentence(rows, spec.system, spec.named),
        protocol_sentence(rows, spec.system),
        *others,
        *answer_sentences(data),
        caveat_sentence(rows),
        failure_sentence(rows),
    )
    short, lines = " ".join(filter(None, sentences)), "\n".join(filter(None, details))
    return f"{short}\n\n{lines}".strip()


def parted(text: str) -> tuple[str, list[str]]:
    """Return the caption in a file of it, and the details.

    >>> parted("Velocity. Bars: 95 %.\\n\\nParameters: e = 0.9.\\nCaveat.\\n")
    ('Velocity. Bars: 95 %.', ['Parameters: e = 0.9.', 'Caveat.'])
    """
    short, _, details = text.strip().partition("\n\n")
    return short, details.splitlines()


def doubt_sentence(data: FigureData) -> str:
    """Count the points that are not shown to be steady, carry a caveat or failed; name the caveat.

    Maps of regimes and pictures of particles show or say themselves what flows are not steady.
    """
    rows, spec = data.rows, data.spec
    shown = rows[rows["completed"] > 0]
    is_told = spec.particles or spec.show == REGIME
    unsteady = 0 if is_told else int(((shown["regime"] != "steady") | is_undecided(shown)).sum())
    caveats = rows["caveat"][rows["caveat"] != ""].value_counts()
    reasons = [
        (unsteady, "is", "are", " not shown to be steady"),
        (len(rows) - len(shown), "failed", "failed", ""),
        (caveats.sum(), "carries", "carry", " a caveat"),
    ]
    is_one = len(rows) == 1
    counts = [
        f"{'' if is_one else f'{count} '}{verb if count == 1 else verbs}{what}"
        for count, verb, verbs, what in reasons
        if count
    ]
    if not counts:
        return ""
    text = ("The point " if is_one else f"Of {points_text(len(rows))}, ") + in_words(counts)
    if len(caveats):
        mostly = "mostly " if len(caveats) > 1 else ""
        text += f" ({mostly}{first_clause(caveats.index[0])})"
    return text + "."


def first_clause(caveat: str) -> str:
    """Return what a caveat warns of, without its reasons and cures."""
    return re.split("[,;]", caveat)[0]


def point_notes(data: FigureData) -> list[str]:
    """Return the sentences of a caption on error bars and markers of measures or velocities."""
    if data.spec.quantities:
        return quantity_notes(data, quantities(data))
    return [*interval_sentences(data.rows), regime_sentence(data.rows)]


def bar_notes(data: FigureData, rows: pd.DataFrame, quantities: Sequence[Quantity]) -> list[str]:
    """Return the sentences of a caption on bars and markers of some rows of a figure.

    Only velocities have intervals of one replicate.
    """
    shown = replace(data, rows=rows)
    others = [quantity for quantity in quantities if quantity.name != "velocity"]
    if len(others) == len(quantities):
        return quantity_notes(shown, [_of_rows(quantity, rows) for quantity in quantities])
    without_bar = [
        name_in_words(quantity.name)
        for quantity in others
        if quantity.half_width[rows.index].isna().any()
    ]
    sentences = [f"No bar of the {name} where only one replicate is known." for name in without_bar]
    return [*interval_sentences(rows), *sentences, regime_sentence(rows)]


def _of_rows(quantity: Quantity, rows: pd.DataFrame) -> Quantity:
    value, half_width = quantity.value[rows.index], quantity.half_width[rows.index]
    return replace(quantity, value=value, half_width=half_width)


def quantity_notes(data: FigureData, quantities: Sequence[Quantity]) -> list[str]:
    """Return the sentences of a caption on error bars and markers of quantities.

    Points without a value are not counted.
    """
    is_known = pd.concat([measure.value.notna() for measure in quantities], axis=1)
    has_bar = pd.concat([measure.half_width.notna() for measure in quantities], axis=1) & is_known
    sentence = "Bars: 95 % interval of the mean over replicates (Student)"
    if has_bar.sum().sum() < is_known.sum().sum():
        sentence += ", none where only one"
    drawn = f"{sentence}." if has_bar.any().any() else ""
    return [drawn, regime_sentence(data.rows[is_known.any(axis=1)])]


def velocity_text(row: Mapping[str, Any]) -> str:
    """Write the mean velocity of a point with its 95 % interval, if there is one."""
    interval = f" ± {row['half_width']:.2g}" if isfinite(row["half_width"]) else ""
    return f"{row['velocity']:.3g}{interval} m/s"


def parameters_sentence(rows: pd.DataFrame, system: str, names: Sequence[str]) -> str:
    """Write the parameters that the points of a figure share, or all their values.

    Empty where no parameter is named.
    """
    if not names:
        return ""
    parts = [
        values_text(system, name, rows[name])
        if field_info(SYSTEMS[system])[name].unit
        else " and ".join(setting(system, name, value) for value in sorted(set(rows[name])))
        for name in names
    ]
    return "Parameters: " + "; ".join(parts) + "."


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
    limited = int(converged["stopped"].str.contains("limit").sum())
    return (
        f"Converged protocol ({points_text(len(converged))}): runs go on until the mean is known "
        f"to {precisions} % without a drift, at most {limit}. {points_text(limited).capitalize()} "
        "reached that limit first. Averages leave out the transient."
    )


def interval_sentences(rows: pd.DataFrame) -> list[str]:
    """Return what the bars of velocities are, and for the details what those of one run leave out.

    The first is empty where no point has completed.
    """
    shown = rows[rows["completed"] > 0]
    between_replicates = shown[shown["interval"] == "replicates"]
    within_run = shown[shown["interval"] == "within run"]
    parts = []
    if len(between_replicates):
        numbers = range_text(between_replicates["completed"])
        parts.append(f"of the mean over {numbers} replicates (Student)")
    if len(within_run):
        for_points = (
            f" for the {points_text(len(within_run))} with one replicate"
            if len(between_replicates)
            else ""
        )
        parts.append(f"within the run{for_points}")
    if not parts:
        return [""]
    bars = f"Bars: 95 % interval {', '.join(parts)}."
    within = (
        "The interval within a run counts its correlations, and leaves out how much one initial "
        "state differs from another."
    )
    return [bars, within] if len(within_run) else [bars]


def regime_sentence(rows: pd.DataFrame, *, has_bars: bool = True) -> str:
    """Explain filled, pale and open markers, with numbers of points; empty if all are steady.

    ``has_bars`` says whether the markers have error bars.
    """
    shown = rows[rows["completed"] > 0]
    is_open = is_undecided(shown)
    steady = (shown["regime"] == "steady") & ~is_open
    unsteady = _unsteady_counts(shown[~is_open])
    parts = ["filled markers are steady flows"] if steady.any() else []
    if is_open.any():
        subject = "pale ones may be" if parts else "pale markers are flows that may be steady"
        parts.append(
            f"{subject}, their runs are too short to tell ({points_text(is_open.sum())})"
            + ", and their error bars may be too small" * has_bars
        )
    if unsteady:
        subject = "open ones are" if parts else "open markers are flows"
        parts.append(
            f"{subject} not shown to be{'' if parts else ' steady'}: " + ", ".join(unsteady)
        )
    if not (is_open.any() or unsteady):
        return ""
    text = "; ".join(parts)
    value = "their value is the mean over the averaging window all the same"
    return f"{text[0].upper()}{text[1:]}; {value}."


def _unsteady_counts(rows: pd.DataFrame) -> list[str]:
    """Return the number of points in each regime that is not steady, in words."""
    counts = rows[rows["regime"].isin(_REGIMES)]["regime"].value_counts()
    return [f"{points_text(count)} {_REGIMES[regime]}" for regime, count in counts.items()]


def answer_sentences(data: FigureData) -> list[str]:
    """Count the flows not shown to be steady in an answer, those left out, and those without value.

    Empty for a figure that shows no answer.
    """
    rows, answer = data.rows[data.rows["completed"] > 0], data.spec.answer
    if not answer.file:
        return []
    observable = numbers(data.spec.system)[answer.observable]
    values = replicate_values(data.results, observable, list(rows["point"]))
    has_value = np.array([row.size > 0 for row in values], bool)
    regimes = pd.Series(map(answering_regime, rows.to_dict("records")), rows.index, dtype=object)
    counts = regimes.isin(answer.regimes)
    others = regimes[~counts & has_value].value_counts()
    texts = [f"{points_text(count)} {_REGIMES.get(name, name)}" for name, count in others.items()]
    if lacking := int((~has_value).sum()):
        texts.append(f"{points_text(lacking)} without a value")
    return [
        unsteady_sentence(
            rows.assign(regime=regimes)[counts & has_value], "part of the answer all the same"
        ),
        f"Not part of the answer: {', '.join(texts)}." if texts else "",
    ]


def unsteady_sentence(rows: pd.DataFrame, mark: str = "drawn all the same") -> str:
    """Count the flows not shown to be steady, for plots without such markers; empty if none is.

    ``mark`` says what is made of them.
    """
    shown = rows[rows["completed"] > 0]
    is_open = is_undecided(shown)
    unsteady = _unsteady_counts(shown[~is_open])
    if is_open.any():
        unsteady.append(f"{points_text(is_open.sum())} whose runs are too short to tell")
    return f"Not surely steady, and {mark}: {', '.join(unsteady)}." if unsteady else ""


def caveat_sentence(rows: pd.DataFrame) -> str:
    """Write each caveat with the number of its points; empty if there is none."""
    counts = rows[rows["caveat"] != ""]["caveat"].value_counts()
    return " ".join(f"Caveat for {points_text(count)}: {text}." for text, count in counts.items())


def failure_sentence(rows: pd.DataFrame) -> str:
    """Name the points whose run failed, and those that lost replicates; empty if there are none."""
    failed = rows[rows["completed"] == 0]
    incomplete = rows[(rows["completed"] > 0) & (rows["completed"] < rows["replicates"])]
    sentences = []
    if len(failed):
        points = "; ".join(f"{row.point} ({row.reason})" for row in failed.itertuples())
        sentences.append(f"Left out because the run failed: {points}.")
    if len(incomplete):
        points = "; ".join(
            f"{row.point} ({row.completed:g} of {row.replicates:g} replicates left: {row.reason})"
            for row in incomplete.itertuples()
        )
        sentences.append(f"Replicates lost: {points}.")
    return " ".join(sentences)


def range_text(counts: Iterable[int]) -> str:
    """Write the range of some numbers, or one if all are equal: ``3 to 5`` or ``3``."""
    least, most = min(counts), max(counts)
    return f"{least}" if least == most else f"{least} to {most}"


def points_text(count: int) -> str:
    """Write ``1 point`` or ``2 points``."""
    return f"{count} point" + ("" if count == 1 else "s")
