"""Pictures of a calibration: posterior, predictions, and the next experiment."""

from collections.abc import Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import MANY, student
from sim.figures.caption import observable_text, unit_of
from sim.figures.data import Drawing, FigureData, parameter_heading, parameter_unit
from sim.figures.plot import message_figure, one_panel, parameter_label, wrap_label
from sim.figures.spheres import COLOURS as SHADES
from sim.figures.style import COLOURS, legend_above, move_aside, set_log
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
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

_NO_FIT = "no parameters in the ranges fit"


def _draw_posterior(data: FigureData) -> Figure:
    """Draw a histogram of each parameter on the diagonal, and the regions of each pair below."""
    groups, _ = _groups(data)
    if "posterior" not in groups:
        return message_figure(_NO_FIT)
    lines = {name: _line(groups, name) for name in ranges(groups)}
    count = len(lines)
    size = _SINGLE if count == 1 else (_PANEL * count + 0.6, _PANEL * count + 0.6)
    figure = Figure(figsize=size, layout="constrained")
    panels: Any = figure.subplots(count, count, squeeze=False, sharex="col")
    for (row, y), (column, x) in product(enumerate(lines), repeat=2):
        axes = panels[row, column]
        if column > row:
            axes.set_visible(False)
            continue
        _set_axis(axes, "x", lines[x], parameter_label(data.spec.system, x))
        if row == column:
            _draw_histogram(axes, lines[x])
        else:
            _draw_regions(axes, lines[x], lines[y])
            _set_axis(axes, "y", lines[y], parameter_label(data.spec.system, y))
        axes.label_outer()
    return figure


def _posterior_table(data: FigureData) -> pd.DataFrame:
    groups, about = _groups(data)
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
    groups, about = _groups(data)
    sentences = outcome_sentences(groups)
    if "posterior" not in groups:
        return sentences
    return [
        "Medians and 95 % intervals: " + " ".join(sentences),
        "Histograms over the ranges, with the interval as dashed lines; the dotted line is what "
        "was assumed before the measurements. Shades: 50 % and 95 % of the draws.",
        _discrepancy_note(data),
        f"Probability of measurements as far from the model: {about['probability']:.2g}.",
        f"Chains of {about['steps']} steps, {about['steps'] / about['autocorrelation']:.0f} "
        "autocorrelation times.",
    ]


def _discrepancy_note(data: FigureData) -> str:
    groups, about = _groups(data)
    if DISCREPANCY not in groups["posterior"]:
        return "The model is taken to lack nothing."
    unit = unit_of(data.spec.answer.unit, "si", data.spec.system)
    low, middle, high = np.quantile(groups["posterior"][DISCREPANCY], INTERVAL)
    fitted = f"What the model may lack, fitted: {middle:.2g} ({low:.2g} to {high:.2g}) {unit}"
    scale = f"half-normal of scale {about['discrepancy_scale']:.2g}"
    return f"{fitted.rstrip()}, before the measurements {scale}."


def _draw_predictions(data: FigureData) -> Figure:
    """Draw each measurement with its interval, and the one of a repeated measurement beside it."""
    rows, along = _prediction_rows(data)
    figure, axes = one_panel()
    system = data.spec.system
    halves = rows["median"] - rows["low"], rows["high"] - rows["median"]
    for name, half, marker, colour, label, aside in (
        ("measured", rows["half"], "o", "black", "measured", -_ASIDE),
        ("median", halves, "s", COLOURS[1], "calibrated", _ASIDE),
    ):
        look: dict[str, Any] = {"fmt": marker, "color": colour, "elinewidth": 1.2, "label": label}
        move_aside(axes, axes.errorbar(rows["x"], rows[name], half, **look).get_children(), x=aside)
    axes.margins(x=0.08)
    if along:
        axes.set_xlabel(parameter_label(system, along))
    else:
        axes.set_xticks(rows["x"].tolist())
        axes.set_xlabel("measurement, in the order of the file")
    name = str(_groups(data)[1]["observable"])
    axes.set_ylabel(wrap_label(observable_text(name, data.spec.answer.unit, "si", system)))
    legend_above(figure, *axes.get_legend_handles_labels())
    return figure


def _predictions_table(data: FigureData) -> pd.DataFrame:
    rows, _ = _prediction_rows(data)
    unit = data.spec.answer.unit
    conditions = _groups(data)[0]["constant_data"].drop_vars("error").to_dataframe()
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
    groups, _ = _groups(data)
    notes = [
        "Bars: 95 % intervals; of the calibrated surrogate those of the same measurement made "
        "again, errors of measurement, surrogate and model included."
    ]
    if "posterior" not in groups:
        notes += [*outcome_sentences(groups), "Drawn are those that come nearest."]
    return notes


def _draw_experiment(data: FigureData) -> Figure:
    """Draw how much a further measurement would tell, over one or two of its conditions."""
    groups, _ = _groups(data)
    if "predictions_constant_data" not in groups:
        return message_figure(_NO_FIT)
    figure, axes = one_panel()
    rows, (x, *others) = _candidates(groups)
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
    groups, _ = _groups(data)
    if "predictions_constant_data" not in groups:
        return _posterior_table(data)
    rows = groups["predictions_constant_data"].to_dataframe().reset_index(drop=True)
    names = [name for name in rows if name in SYSTEMS[data.spec.system].model_fields]
    headings = {name: parameter_heading(data.spec.system, name) for name in names}
    return rows.rename(columns=headings | {"narrowing": "variance taken away [1]"})


def _experiment_notes(data: FigureData) -> list[str]:
    groups, _ = _groups(data)
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


def _groups(data: FigureData) -> tuple[Mapping[str, xr.Dataset], dict[str, Any]]:
    """Return the groups of the calibration, and what it says of itself."""
    groups: Mapping[str, xr.Dataset] = data.read_answer(load_posterior)
    return groups, groups["observed_data"].attrs


class _Line(NamedTuple):
    """A parameter: its draws (D,), as logarithms where its scale is so, and its range as these."""

    draws: np.ndarray
    low: float
    high: float
    is_log: bool

    def steps(self, count: int) -> np.ndarray:
        """Return values from one end of the range to the other, as the scale spreads them."""
        return np.linspace(self.low, self.high, count)

    def value(self, place: np.ndarray) -> np.ndarray:
        return np.exp(place) if self.is_log else place


def _line(groups: Mapping[str, xr.Dataset], name: str) -> _Line:
    low, high, scale = ranges(groups)[name]
    draws, is_log = groups["posterior"][name].to_numpy().ravel(), scale == "log"
    change = np.log if is_log else np.asarray
    return _Line(change(draws), float(change(low)), float(change(high)), is_log)


def _draw_histogram(axes: Axes, line: _Line) -> None:
    bins, share = line.value(line.steps(_BINS + 1)).tolist(), _BINS / line.draws.size
    weights = np.full(line.draws.size, share)
    axes.hist(line.value(line.draws), bins, weights=weights, color=COLOURS[1])
    axes.axhline(1, color="#444444", linestyle=":", linewidth=1)
    for end in line.value(np.quantile(line.draws, INTERVAL)):
        axes.axvline(end, color="black", linestyle="--", linewidth=0.9)
    axes.set_yticks([])


def _draw_regions(axes: Axes, x: _Line, y: _Line) -> None:
    """Draw the regions that hold the shares `_SHARES` of the draws, from a smoothed density."""
    from scipy.stats import gaussian_kde

    draws = np.array([line.draws[:: max(1, line.draws.size // _MOST_DRAWS)] for line in (x, y)])
    density, places = gaussian_kde(draws), (x.steps(_STEPS), y.steps(_STEPS))
    heights = density(np.array([one.ravel() for one in np.meshgrid(*places)]))
    levels = [float(np.quantile(density(draws), 1 - share)) for share in _SHARES]
    at, shades = (x.value(places[0]), y.value(places[1])), ("#c6dbef", COLOURS[1])
    axes.contourf(*at, heights.reshape(_STEPS, _STEPS), [*levels, np.inf], colors=shades)


def _set_axis(axes: Axes, along: Any, line: _Line, label: str) -> None:
    """Set scale, limits and label of the axis of a parameter."""
    if line.is_log:
        set_log(axes, along)
    else:
        axes.locator_params(along, nbins=4)
    ends = line.value(np.array([line.low, line.high]))
    axes.set(**{f"{along}lim": ends, f"{along}label": label})


def _prediction_rows(data: FigureData) -> tuple[pd.DataFrame, str]:
    """Return measurements and predictions, and the only condition that varies, or nothing."""
    groups, about = _groups(data)
    name = str(about["observable"])
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


POSTERIOR = Drawing(_draw_posterior, _posterior_table, _posterior_notes)
PREDICTIONS = Drawing(_draw_predictions, _predictions_table, _predictions_notes)
EXPERIMENT = Drawing(_draw_experiment, _experiment_table, _experiment_notes)
