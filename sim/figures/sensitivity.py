"""Pictures of what matters, and of what follows: Sobol' indices, Morris' screening, a spread."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.figures.caption import label_with_unit, unit_of
from sim.figures.data import Drawing, FigureData
from sim.figures.plot import SINGLE_SIZE, one_panel, wrap_label
from sim.figures.style import COLOURS, LEVEL, cycle_style, legend_above, phrase
from sim.study.plot_contents import name_in_words
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
    phrases = [phrase(data.spec.system, name) for name in names]
    bars = {"first order: alone": first, "total: with all interactions": total}
    return _bars(
        phrases, {label: rows.set_index("parameter").loc[names] for label, rows in bars.items()}
    )


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
    pairs = zip(rows["parameter"], rows["other"], strict=True)
    phrases = [" × ".join(phrase(data.spec.system, one) for one in pair) for pair in pairs]
    return _bars(phrases, {"": rows})


def _interactions_table(data: FigureData) -> pd.DataFrame:
    return _with_headings(_of(_table(data), "interaction"), "1")


def _interactions_notes(data: FigureData) -> list[str]:
    table = _table(data)
    return [
        "Share of the variance that a pair of parameters explains beyond what each explains alone. "
        f"Values below zero are zero within their intervals. Drawn are the largest {_MOST_PAIRS}.",
        *_sample_notes(table),
    ]


def _draw_screening(data: FigureData) -> Figure:
    """Draw mean size against deviation of the effects of each parameter."""
    table = _table(data)
    means, deviations = (_of(table, index).set_index("parameter") for index in ("mu_star", "sigma"))
    figure, axes = one_panel()
    for number, name in enumerate(means.sort_values("value", ascending=False).index):
        style, label = cycle_style(number), phrase(data.spec.system, name)
        both = [one.loc[name, ["low", "value", "high"]] for one in (means, deviations)]
        (_, x, _), (_, y, _) = both
        xerr, yerr = (np.abs(np.diff(one.to_numpy(float)))[:, None] for one in both)
        look: dict[str, Any] = {"fmt": style.marker, "color": style.colour, "label": label}
        axes.errorbar(x, y, yerr, xerr, elinewidth=0.9, **look)
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


def _draw_spread(data: FigureData) -> Figure:
    """Draw the distribution: quantiles, and probabilities not to exceed values, with intervals."""
    table, unit = _table(data), unit_of(data.spec.answer.unit, "si", data.spec.system)
    figure, axes = one_panel()
    levels, above = _of(table, "quantile"), _of(table, "exceedance")
    look: dict[str, Any] = {"fmt": "o", "markersize": 4, "capsize": 2, "elinewidth": 0.9}
    half = [levels["value"] - levels["low"], levels["high"] - levels["value"]]
    at = levels["parameter"].astype(float)
    axes.errorbar(levels["value"], at, xerr=half, color=COLOURS[1], label="quantile", **look)
    if len(above):
        half = [above["high"] - above["value"], above["value"] - above["low"]]
        at, label = above["parameter"].astype(float), "1 - probability to exceed"
        look |= {"fmt": "s", "color": COLOURS[2]}
        axes.errorbar(at, 1 - above["value"], yerr=half, label=label, **look)
    mean = _of(table, "mean").iloc[0]
    axes.axvspan(mean["low"], mean["high"], color=COLOURS[0], alpha=0.15, lw=0, label="mean")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel(wrap_label(label_with_unit(name_in_words(data.spec.answer.observable), unit)))
    axes.set_ylabel("share below")
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _spread_table(data: FigureData) -> pd.DataFrame:
    table = _table(data).rename(columns={"index": "of", "parameter": "at", "blocks": "draws"})
    is_chance = table["of"] == "exceedance"
    table.insert(2, "unit", np.where(is_chance, "1", data.spec.answer.unit))
    headings = {"low": "lower end of 95 % interval", "high": "upper end of 95 % interval"}
    return table.rename(columns=headings).drop(columns="other")


def _spread_notes(data: FigureData) -> list[str]:
    table = _table(data)
    mean, deviation = (_of(table, one).iloc[0] for one in ("mean", "deviation"))
    unit = unit_of(data.spec.answer.unit, "si", data.spec.system)
    texts = [
        f"{name} {row['value']:.4g} ({row['low']:.4g} to {row['high']:.4g}){unit and f' {unit}'}"
        for name, row in (("Mean", mean), ("standard deviation", deviation))
    ]
    chances = [
        f"above {row.parameter}: {row.value:.3g} ({row.low:.3g} to {row.high:.3g})"
        for row in _of(table, "exceedance").itertuples()
    ]
    by_runs = (
        f"Bars: 95 % intervals, which take the {mean['blocks']:,} runs for independent draws; a "
        "design that spreads them evenly does better."
    )
    by_surrogate = "Bars: 95 % intervals, of the surrogate's error and of the draws."
    return [
        f"{'; '.join([*texts, *(['probability ' + ', '.join(chances)] if chances else [])])}.",
        by_runs if np.isnan(mean["error"]) else by_surrogate,
    ]


def _table(data: FigureData) -> pd.DataFrame:
    table: pd.DataFrame = data.read_answer(load_table)
    return table


def _of(table: pd.DataFrame, index: str) -> pd.DataFrame:
    return table[table["index"] == index]


def _bars(names: Sequence[str], each: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw horizontal bars with intervals, a row of them for each name from the top.

    ``each`` are the values of the rows by their entry in the legend, empty for none.
    """
    figure, axes = one_panel((SINGLE_SIZE[0], _FRAME + _ROW * max(len(names), 2)))
    height = 0.74 / len(each)
    for number, (label, rows) in enumerate(each.items()):
        places = np.arange(len(rows)) + height * (number - (len(each) - 1) / 2)
        half = [rows["value"] - rows["low"], rows["high"] - rows["value"]]
        look: dict[str, Any] = {"color": COLOURS[number + 1], "label": label}
        axes.barh(places, rows["value"], 0.95 * height, xerr=half, capsize=2, **look)
    axes.axvline(0, color="#444444", linewidth=0.8)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("share of the variance")
    if len(each) > 1:
        legend_above(figure, *axes.get_legend_handles_labels())
    return figure


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
SPREAD = Drawing(_draw_spread, _spread_table, _spread_notes)
SCREENING = Drawing(_draw_screening, _screening_table, _screening_notes)
