"""Pictures of a calibration: posterior, predictions, and the next experiment."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.files import file_version
from sim.base.statistics import MANY, student
from sim.figures.axes import set_log
from sim.figures.data import (
    Drawing,
    FigureData,
    label_with_unit,
    parameter_heading,
    parameter_unit,
    unit_of,
)
from sim.figures.plot import SINGLE_SIZE, message_figure, parameter_label, wrap_label
from sim.figures.spheres import COLOURS as SHADES
from sim.figures.style import COLOURS, legend_above, move_aside
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
from sim.study.plot_contents import name_in_words
from sim.surrogates.posterior import DISCREPANCY, INTERVAL, ranges, summarize
from sim.surrogates.storage import load_posterior, outcome_sentences

#: Size of a picture of one parameter, and of each of several, inches.
_SINGLE, _PANEL = (4.4, 3.2), 2.1

#: Bins of a histogram, and steps of a region along each axis.
_BINS, _STEPS = 30, 60

#: Draws from which regions are made, and shares of the draws within them.
_MOST_DRAWS, _SHARES = 3000, (0.95, 0.5)

#: Shift of measurements and predictions against each other, points of print.
_ASIDE = 3.0


def _draw_posterior(data: FigureData) -> Figure:
    """Draw a histogram of each parameter on the diagonal, and the regions of each pair below."""
    groups = _groups(data)
    names = list(ranges(groups))
    count = len(names)
    size = _SINGLE if count == 1 else (_PANEL * count + 0.6, _PANEL * count + 0.6)
    if "posterior" not in groups:
        return message_figure("no parameters in the ranges fit")
    figure = Figure(figsize=size, layout="constrained")
    panels: Any = figure.subplots(count, count, squeeze=False)
    for row, column in np.ndindex(count, count):
        axes = panels[row, column]
        if column > row:
            axes.set_visible(False)
            continue
        if row == column:
            _draw_histogram(axes, groups, names[row])
        else:
            _draw_regions(axes, groups, names[column], names[row])
        _set_axis(axes, groups, names[column], "x", data.spec.system, row == count - 1)
        if row != column:
            _set_axis(axes, groups, names[row], "y", data.spec.system, column == 0)
    return figure


def _posterior_table(data: FigureData) -> pd.DataFrame:
    groups = _groups(data)
    about = _about(groups)
    if "posterior" not in groups:
        return pd.DataFrame({"outcome": ["no fit"], "probability [1]": [about["probability"]]})
    summary = summarize(groups).itertuples(index=False)
    rows = [(*row, parameter_unit(data.spec.system, row.parameter)) for row in summary]
    if DISCREPANCY in groups["posterior"]:
        low, middle, high = np.quantile(groups["posterior"][DISCREPANCY], INTERVAL)
        rows.append((DISCREPANCY, middle, low, high, np.nan, "", data.spec.answer.unit))
    headings = (
        *("parameter", "median", "lower end of 95 % interval", "upper end of 95 % interval"),
        *("length of the interval over that of the range [1]", "told by the data", "unit"),
    )
    return pd.DataFrame(rows, columns=list(headings))


def _posterior_notes(data: FigureData) -> list[str]:
    groups = _groups(data)
    sentences = outcome_sentences(groups)
    if "posterior" not in groups:
        return sentences
    about = _about(groups)
    pairs = len(ranges(groups)) > 1
    return [
        "Median and 95 % interval: " + sentences[-1] if len(sentences) == 1 else
        "Medians and 95 % intervals: " + " ".join(sentences),
        "Histograms over the ranges, with the interval as dashed lines; the dotted line is what "
        "was assumed before the measurements."
        + (" Shades: 50 % and 95 % of the draws." * pairs),
        _discrepancy_note(data, groups),
        f"Probability of measurements as far from the model: {about['probability']:.2g}.",
        f"Chains of {about['steps']} steps, {about['steps'] / about['autocorrelation']:.0f} "
        "autocorrelation times.",
    ]  # fmt: skip


def _discrepancy_note(data: FigureData, groups: Mapping[str, xr.Dataset]) -> str:
    if DISCREPANCY not in groups["posterior"]:
        return "The model is taken to lack nothing."
    unit = unit_of(data.spec.answer.unit, "si", data.spec.system)
    low, middle, high = np.quantile(groups["posterior"][DISCREPANCY], INTERVAL)
    fitted = f"What the model may lack, fitted: {middle:.2g} ({low:.2g} to {high:.2g}) {unit}"
    scale = _about(groups)["discrepancy_scale"]
    return fitted.rstrip() + f", before the measurements half-normal of scale {scale:.2g}."


def _draw_predictions(data: FigureData) -> Figure:
    """Draw each measurement with its interval, and the one of a repeated measurement beside it."""
    rows, along = _prediction_rows(data)
    figure = Figure(figsize=SINGLE_SIZE, layout="constrained")
    axes = figure.subplots()
    look: dict[str, Any] = {"linestyle": "none", "elinewidth": 1.2, "markersize": 5.0}
    measured = axes.errorbar(
        rows["x"], rows["measured"], rows["half"],
        marker="o", color="black", label="measured", **look,
    )  # fmt: skip
    predicted = axes.errorbar(
        rows["x"], rows["median"], (rows["median"] - rows["low"], rows["high"] - rows["median"]),
        marker="s", color=COLOURS[1], label="calibrated", **look,
    )  # fmt: skip
    move_aside(axes, measured.get_children(), x=-_ASIDE)
    move_aside(axes, predicted.get_children(), x=_ASIDE)
    axes.margins(x=0.08)
    if along:
        axes.set_xlabel(parameter_label(data.spec.system, along))
    else:
        axes.set_xticks(rows["x"].tolist())
        axes.set_xlabel("measurement, in the order of the file")
    axes.set_ylabel(_observable_label(data))
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _predictions_table(data: FigureData) -> pd.DataFrame:
    rows, _ = _prediction_rows(data)
    unit = data.spec.answer.unit
    conditions = _groups(data)["constant_data"].drop_vars("error").to_dataframe()
    headings = {
        "measured": f"measured [{unit}]",
        "half": f"half width of 95 % interval of the measurement [{unit}]",
        "median": f"median of a repeated measurement [{unit}]",
        "low": f"lower end of its 95 % interval [{unit}]",
        "high": f"upper end of its 95 % interval [{unit}]",
    }
    named = rows.drop(columns="x").rename(columns=headings)
    return pd.concat([conditions.reset_index(drop=True), named], axis=1)


def _predictions_notes(data: FigureData) -> list[str]:
    groups = _groups(data)
    notes = [
        "Bars: 95 % intervals; of the calibrated surrogate those of the same measurement made "
        "again, errors of measurement, surrogate and model included."
    ]
    if "posterior" not in groups:
        notes += [*outcome_sentences(groups), "Drawn are those that come nearest."]
    return notes


def _draw_experiment(data: FigureData) -> Figure:
    """Draw how much a further measurement would tell, over one or two of its conditions."""
    groups = _groups(data)
    if "predictions_constant_data" not in groups:
        return message_figure("no parameters in the ranges fit")
    figure = Figure(figsize=SINGLE_SIZE, layout="constrained")
    rows, varied = _candidates(groups)
    axes, (x, *others) = figure.subplots(), varied
    best, measured = rows.loc[rows["narrowing"].idxmax()], groups["constant_data"]
    if others:
        table = rows.pivot(index=others[0], columns=x, values="narrowing")
        filled = axes.contourf(table.columns, table.index, 100 * table.to_numpy(), 12, cmap=SHADES)
        figure.colorbar(filled, ax=axes, pad=0.02, label="variance taken away (%)")
        heights, top = measured[others[0]].to_numpy(), best[others[0]]
        axes.set_ylabel(parameter_label(data.spec.system, others[0]))
        axes.grid(visible=False)
    else:
        axes.plot(rows[x], 100 * rows["narrowing"], color=COLOURS[1])
        heights, top = np.zeros(measured.sizes["measurement"]), 100 * best["narrowing"]
        axes.set_ylim(0, 1.15 * top or 1.0)
        axes.set_ylabel("variance taken away (%)")
    axes.plot(measured[x], heights, "o", color="black", clip_on=False, zorder=4, label="measured")
    look: dict[str, Any] = {"markeredgecolor": "white", "markersize": 13, "clip_on": False}
    axes.plot(best[x], top, "*", color=COLOURS[2], zorder=5, label="next", **look)
    axes.set_xlabel(parameter_label(data.spec.system, x))
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _experiment_table(data: FigureData) -> pd.DataFrame:
    groups = _groups(data)
    if "predictions_constant_data" not in groups:
        return _posterior_table(data)
    rows = groups["predictions_constant_data"].to_dataframe().reset_index(drop=True)
    names = [name for name in rows if name in SYSTEMS[data.spec.system].model_fields]
    headings = {name: parameter_heading(data.spec.system, name) for name in names}
    return rows.rename(columns=headings | {"narrowing": "variance taken away [1]"})


def _experiment_notes(data: FigureData) -> list[str]:
    groups = _groups(data)
    if "predictions_constant_data" not in groups:
        return outcome_sentences(groups)
    rows, varied = _candidates(groups)
    best, names = rows.loc[rows["narrowing"].idxmax()], _conditions(groups["constant_data"])
    place = ", ".join(setting(data.spec.system, name, float(f"{best[name]:.3g}")) for name in names)
    others = " The other conditions are those that tell most." * (len(varied) > 2)
    return [
        f"It tells most at {place}: there it takes some {100 * best['narrowing']:.0f} % of the "
        "variance of the parameters, each in units of its range, if its error is the median one "
        "and predictions depend on the parameters linearly.",
        "Only conditions within the ranges of the data are looked at." + others,
    ]


def _groups(data: FigureData) -> Mapping[str, xr.Dataset]:
    return _load(data.answer, file_version(data.answer))


@lru_cache(maxsize=4)
def _load(path: Path, version: tuple[int, ...]) -> Mapping[str, xr.Dataset]:
    return load_posterior(path)


def _about(groups: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    return groups["observed_data"].attrs


def _draw_histogram(axes: Axes, groups: Mapping[str, xr.Dataset], name: str) -> None:
    low, high, scale = ranges(groups)[name]
    draws = groups["posterior"][name].to_numpy().ravel()
    spread: Any = np.geomspace if scale == "log" else np.linspace
    bins = spread(low, high, _BINS + 1)
    axes.hist(draws, bins, weights=np.full(draws.size, _BINS / draws.size), color=COLOURS[1])
    axes.axhline(1, color="#444444", linestyle=":", linewidth=1)
    for value in np.quantile(draws, INTERVAL):
        axes.axvline(value, color="black", linestyle="--", linewidth=0.9)
    axes.set_yticks([])


def _draw_regions(axes: Axes, groups: Mapping[str, xr.Dataset], x: str, y: str) -> None:
    """Draw the regions that hold the shares `_SHARES` of the draws, from a smoothed density."""
    from scipy.stats import gaussian_kde

    columns, lines = [], []
    for name in (x, y):
        low, high, scale = ranges(groups)[name]
        is_log = scale == "log"
        draws = groups["posterior"][name].to_numpy().ravel()
        draws = draws[:: max(1, draws.size // _MOST_DRAWS)]
        columns.append(np.log(draws) if is_log else draws)
        first, last = np.log([low, high]) if is_log else (low, high)
        lines.append((np.linspace(first, last, _STEPS), is_log))
    density = gaussian_kde(columns)
    grid = np.meshgrid(lines[0][0], lines[1][0])
    heights = density(np.array([one.ravel() for one in grid])).reshape(_STEPS, _STEPS)
    at_draws = density(np.array(columns))
    levels = [float(np.quantile(at_draws, 1 - share)) for share in _SHARES]
    across, up = (np.exp(line) if is_log else line for line, is_log in lines)
    shades = ("#c6dbef", COLOURS[1])
    axes.contourf(across, up, heights, [*levels, np.inf], colors=shades)


def _set_axis(
    axes: Axes, groups: Mapping[str, xr.Dataset], name: str, axis: Any, system: str, labelled: bool
) -> None:
    """Set scale and limits of the axis of a parameter, and label it or hide its numbers."""
    low, high, scale = ranges(groups)[name]
    if scale == "log":
        set_log(axes, axis)
    getattr(axes, f"set_{axis}lim")(low, high)
    if scale != "log":
        axes.locator_params(axis, nbins=4)
    if labelled:
        getattr(axes, f"set_{axis}label")(parameter_label(system, name))
    else:
        axes.tick_params(axis, labelbottom=False, labelleft=False)


def _prediction_rows(data: FigureData) -> tuple[pd.DataFrame, str]:
    """Return measurements and predictions, and the only condition that varies, or nothing."""
    groups = _groups(data)
    name = str(_about(groups)["observable"])
    constant = groups["constant_data"]
    repeated = (
        groups["posterior_predictive"][name].to_numpy().reshape(-1, constant.sizes["measurement"])
    )
    low, middle, high = np.quantile(repeated, INTERVAL, axis=0)
    varied = _conditions(constant, varied=True)
    along = varied[0] if len(varied) == 1 else ""
    x = constant[along].to_numpy() if along else np.arange(1, len(middle) + 1)
    half = float(student(MANY)) * constant["error"].to_numpy()
    columns = {"x": x, "measured": groups["observed_data"][name].to_numpy(), "half": half}
    return pd.DataFrame(columns | {"median": middle, "low": low, "high": high}), along


def _conditions(constant: xr.Dataset, *, varied: bool = False) -> list[str]:
    """Return the conditions of measurements, or those that differ between them."""
    names = [str(name) for name in constant.data_vars if name != "error"]
    return [name for name in names if not varied or np.ptp(constant[name].to_numpy()) > 0]


def _candidates(groups: Mapping[str, xr.Dataset]) -> tuple[pd.DataFrame, list[str]]:
    """Return candidates of the first two conditions that vary, the others as the best has them."""
    rows = groups["predictions_constant_data"].to_dataframe()
    varied = _conditions(groups["constant_data"], varied=True)
    best = rows.loc[rows["narrowing"].idxmax()]
    for name in varied[2:]:
        rows = rows[rows[name] == best[name]]
    return rows, varied


def _observable_label(data: FigureData) -> str:
    name = name_in_words(str(_about(_groups(data))["observable"]))
    return wrap_label(label_with_unit(name, unit_of(data.spec.answer.unit, "si", data.spec.system)))


POSTERIOR = Drawing(_draw_posterior, _posterior_table, _posterior_notes)
PREDICTIONS = Drawing(_draw_predictions, _predictions_table, _predictions_notes)
EXPERIMENT = Drawing(_draw_experiment, _experiment_table, _experiment_notes)
