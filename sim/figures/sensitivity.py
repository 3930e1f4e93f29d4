"""Pictures of what matters: bars of Sobol' indices and interactions, and Morris' screening."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.data import Drawing, FigureData, label_with_unit, unit_of
from sim.figures.plot import SINGLE_SIZE, wrap_label
from sim.figures.style import COLOURS, LEVEL, cycle_style, escape_label, legend_above
from sim.study.plot_contents import parameter_phrase
from sim.surrogates.answers import MANY_BLOCKS
from sim.surrogates.indices import NEGLIGIBLE
from sim.surrogates.storage import load_table

#: Height of the room of a parameter, and of a picture without any, inches.
_ROW, _FRAME = 0.42, 1.3

#: Most pairs of parameters that a picture has room for.
_MOST_PAIRS = 15


def _draw_indices(data: FigureData) -> Figure:
    """Draw a bar of the first-order and of the total index of each parameter."""
    table = _table(data)
    total, first = (_of(table, index) for index in ("total", "first"))
    names = total.sort_values("value", ascending=False, na_position="last")["parameter"].tolist()
    figure, axes = _bars(len(names))
    for shift, rows, label, colour in (
        (-0.19, first, "first order: alone", COLOURS[1]),
        (0.19, total, "total: with all interactions", COLOURS[2]),
    ):
        _draw_bars(axes, rows.set_index("parameter").loc[names], shift, 0.36, colour, label)
    _name_rows(axes, [parameter_phrase(data.spec.system, name) for name in names])
    axes.set_xlabel("share of the variance")
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _indices_table(data: FigureData) -> pd.DataFrame:
    table = _table(data)
    return _with_headings(table[table["index"] != "interaction"], "1").drop(columns="other")


def _indices_notes(data: FigureData) -> list[str]:
    table = _table(data)
    return [
        "First order: the share of the variance that goes away when the parameter is known. Total: "
        "the share that is left when all others are known.",
        _sum_note(_of(table, "sum").iloc[0]),
        *_negligible_note(table),
        *_sample_notes(table),
    ]


def _sum_note(row: pd.Series) -> str:
    text = f"First-order indices sum to {row['value']:.2f} ({row['low']:.2f} to {row['high']:.2f})"
    if row["high"] < 1:
        return f"{text}; what they lack of 1 is from interactions."
    if row["low"] <= 1:
        return f"{text}, 1 within its interval: what they lack of 1 may be chance."
    return f"{text}, more than 1: they are too noisy."


def _negligible_note(table: pd.DataFrame) -> list[str]:
    """Return which parameters have no effect, by the upper ends of their intervals."""
    total = _of(table, "total")
    if np.isnan(total["error"].iloc[0]) and total["blocks"].iloc[0] < MANY_BLOCKS:
        return []
    names = total["parameter"][(total["high"] < NEGLIGIBLE) & (total["doubt"] == "")]
    return [f"Below {NEGLIGIBLE:g}, interval included: {', '.join(names)}."] if len(names) else []


def _draw_interactions(data: FigureData) -> Figure:
    """Draw a bar of the second-order index of each pair of parameters, the largest first."""
    rows = _of(_table(data), "interaction").sort_values("value", ascending=False)[:_MOST_PAIRS]
    figure, axes = _bars(len(rows))
    _draw_bars(axes, rows, 0.0, 0.6, COLOURS[3], None)
    system = data.spec.system
    pairs = zip(rows["parameter"], rows["other"], strict=True)
    _name_rows(axes, [" × ".join(parameter_phrase(system, one) for one in pair) for pair in pairs])
    axes.set_xlabel("share of the variance")
    return figure


def _interactions_table(data: FigureData) -> pd.DataFrame:
    return _with_headings(_of(_table(data), "interaction"), "1")


def _interactions_notes(data: FigureData) -> list[str]:
    table = _table(data)
    pairs = len(_of(table, "interaction"))
    more = [f"The largest {_MOST_PAIRS} of {pairs} pairs."] if pairs > _MOST_PAIRS else []
    return [
        "Share of the variance that a pair of parameters explains beyond what each explains alone. "
        "Values below zero are zero within their intervals.",
        *more,
        *_sample_notes(table),
    ]


def _draw_screening(data: FigureData) -> Figure:
    """Draw mean size against deviation of the effects of each parameter."""
    table = _table(data)
    means, deviations = (_of(table, index).set_index("parameter") for index in ("mu_star", "sigma"))
    figure = Figure(figsize=SINGLE_SIZE, layout="constrained")
    axes = figure.subplots()
    for number, name in enumerate(means.sort_values("value", ascending=False).index):
        x, y, style = means.loc[name], deviations.loc[name], cycle_style(number)
        axes.errorbar(
            x["value"],
            y["value"],
            xerr=[[x["value"] - x["low"]], [x["high"] - x["value"]]],
            yerr=[[y["value"] - y["low"]], [y["high"] - y["value"]]],
            color=style.colour,
            marker=style.marker,
            linestyle="none",
            elinewidth=0.9,
            label=escape_label(parameter_phrase(data.spec.system, name)),
        )
    ends = pd.concat([means, deviations])[["value", "high"]]
    end = 1.05 * np.nanmax(ends) or 1.0
    axes.plot([0, end], [0, end], **LEVEL, label="σ = μ*")
    axes.set_xlim(0, end)
    axes.set_ylim(min(0.0, -0.02 * end), end)
    unit = unit_of(data.spec.answer.unit, "si", data.spec.system)
    axes.set_xlabel(wrap_label(label_with_unit("mean size of the effect μ*", unit)))
    axes.set_ylabel(wrap_label(label_with_unit("deviation of the effect σ", unit)))
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _screening_table(data: FigureData) -> pd.DataFrame:
    return _with_headings(_table(data), data.spec.answer.unit).drop(columns="other")


def _screening_notes(data: FigureData) -> list[str]:
    return [
        "Effect: change of the observable when the parameter goes from one end of its range to the "
        "other, the others held. Far right: it matters. High above the dotted line: the effect "
        "depends on the other parameters, or is not a straight line. Near zero: it may be fixed.",
        *_sample_notes(_table(data)),
    ]


def _table(data: FigureData) -> pd.DataFrame:
    return load_table(data.answer)


def _of(table: pd.DataFrame, index: str) -> pd.DataFrame:
    return table[table["index"] == index]


def _bars(rows: int) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(SINGLE_SIZE[0], _FRAME + _ROW * max(rows, 2)), layout="constrained")
    return figure, figure.subplots()


def _draw_bars(
    axes: Axes, rows: pd.DataFrame, shift: float, height: float, colour: str, label: str | None
) -> None:
    """Draw horizontal bars with intervals, from the top, ``shift`` rows lower."""
    places = np.arange(len(rows)) + shift
    half = [rows["value"] - rows["low"], rows["high"] - rows["value"]]
    axes.barh(places, rows["value"], height, color=colour, label=label)
    look: dict[str, Any] = {"fmt": "none", "ecolor": "black", "elinewidth": 0.9, "capsize": 2}
    axes.errorbar(rows["value"], places, xerr=half, **look)
    axes.axvline(0, color="#444444", linewidth=0.8)


def _name_rows(axes: Axes, names: Sequence[str]) -> None:
    axes.set_yticks(range(len(names)), [escape_label(name) for name in names])
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _sample_notes(table: pd.DataFrame) -> list[str]:
    first = table.iloc[0]
    if np.isfinite(first["error"]):
        return [
            "Bars: 95 % intervals, of the sample and of the surrogate's error. All values within "
            "the ranges count the same."
        ]
    what = "trajectories" if "mu_star" in set(table["index"]) else "blocks"
    notes = [f"Bars: 95 % intervals, from the scatter between {first['blocks']} {what}."]
    if first["left_out"]:
        total = first["blocks"] + first["left_out"]
        notes.append(
            f"Left out: {first['left_out']} of {total} {what}, in which a run failed or its flow "
            "is of a regime that does not count. If these lie in one corner of the ranges, the "
            "answer is of the rest."
        )
    return notes


def _with_headings(table: pd.DataFrame, unit: str) -> pd.DataFrame:
    headings = {"low": "lower end of 95 % interval", "high": "upper end of 95 % interval"}
    named = {name: f"{headings.get(name, name)} [{unit}]" for name in ("value", "low", "high")}
    return table.rename(columns=named | {"left_out": "blocks left out"})


INDICES = Drawing(_draw_indices, _indices_table, _indices_notes)
INTERACTIONS = Drawing(_draw_interactions, _interactions_table, _interactions_notes)
SCREENING = Drawing(_draw_screening, _screening_table, _screening_notes)
