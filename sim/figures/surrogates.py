"""Pictures of a surrogate: sections along a parameter, maps over two, and predicted against run."""

from itertools import islice, product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from sim.base.errors import percent, upper_first
from sim.base.statistics import MANY, student
from sim.figures.caption import observable_text
from sim.figures.data import Drawing, FigureData, parameter_heading
from sim.figures.plot import SINGLE_SIZE, one_panel, parameter_label, wrap_label
from sim.figures.spheres import COLOURS
from sim.figures.style import LEVEL, cycle_style, legend_above, limit_axis, set_log, settings
from sim.parameters.words import setting
from sim.study.design import Axis
from sim.surrogates.answers import EVEN
from sim.surrogates.fit import counted_probability
from sim.surrogates.sample import unit_cube
from sim.surrogates.storage import load_surrogate
from sim.surrogates.surrogate import Surrogate

#: Values along a section, and along each side of a map.
SECTION_STEPS, MAP_STEPS = 161, 61

#: Runs are near a section where each other parameter is within this share of its range.
NEAR = 0.25

#: Most combinations of words and switches that have a curve or a panel of their own.
_MOST_SETTINGS = 4


def find_surrogate(data: FigureData) -> tuple[Surrogate, list[Axis]]:
    """Return the surrogate that a figure shows, and the parameters on its axes."""
    surrogate: Surrogate = data.read_answer(load_surrogate)
    answer = data.spec.answer
    axes = {axis.name: axis for axis in surrogate.axes}
    return surrogate, [axes[name] for name in (answer.x, answer.y) if name]


def shown_settings(surrogate: Surrogate) -> list[dict[str, Any]]:
    """Return combinations of the words and switches, no more than are shown."""
    choices = surrogate.choices
    every = (dict(zip(choices, values, strict=True)) for values in product(*choices.values()))
    return list(islice(every, _MOST_SETTINGS))


def _steps(axis: Axis, count: int) -> np.ndarray:
    spread = np.geomspace if axis.scale == "log" else np.linspace
    return np.clip(spread(axis.low, axis.high, count), axis.low, axis.high)


def _predictions(
    surrogate: Surrogate, columns: dict[str, np.ndarray], chosen: dict[str, Any]
) -> pd.DataFrame:
    """Return predictions at values (n,) of some parameters, the others in the middle."""
    count = len(next(iter(columns.values())))
    rows = pd.DataFrame(
        {
            axis.name: columns.get(axis.name, np.full(count, axis.middle))
            for axis in surrogate.numeric
        }
    )
    there, x = surrogate.at(**chosen), rows.to_numpy()
    rows["mean"], error = there.predict(x)
    likely = counted_probability(there, there.probability(x))
    return rows.assign(half_width=student(MANY) * error, probability=likely, **chosen)


def section_rows(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return predictions along a parameter."""
    return _predictions(surrogate, {axis.name: _steps(axis, SECTION_STEPS)}, chosen)


def surface_rows(surrogate: Surrogate, x: Axis, y: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return predictions over two parameters, those along ``x`` in turn for each ``y``."""
    up, across = np.meshgrid(_steps(y, MAP_STEPS), _steps(x, MAP_STEPS), indexing="ij")
    return _predictions(surrogate, {x.name: across.ravel(), y.name: up.ravel()}, chosen)


def run_rows(surrogate: Surrogate, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs at a choice of words and switches; ``in_mean`` are those of the mean."""
    sample = surrogate.sample
    names = ["point", *(axis.name for axis in surrogate.axes), "mean"]
    rows = pd.DataFrame({name: sample[name].values for name in names})
    rows["in_mean"], rows["half_width"] = surrogate.in_mean, np.nan
    errors = student(MANY) * surrogate.leave_one_out["run_error"].values
    rows.loc[surrogate.in_mean, "half_width"] = errors
    is_chosen = [rows[name] == value for name, value in chosen.items()]
    return rows[np.all(is_chosen, axis=0)] if is_chosen else rows


def near_rows(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs near a section, moved onto it by what the surrogate says."""
    rows = run_rows(surrogate, chosen)
    rows = rows[rows["in_mean"]].drop(columns="in_mean")
    others = tuple(one for one in surrogate.numeric if one.name != axis.name)
    if others and len(rows):
        cube = unit_cube(others, {one.name: rows[one.name].to_numpy() for one in others})
        middle = unit_cube(others, {one.name: np.array([one.middle]) for one in others})
        rows = rows[(np.abs(cube - middle) <= NEAR).all(axis=1)]
    if others and len(rows):
        here, _ = surrogate.at(**chosen).predict(rows[list(surrogate.parameters)].to_numpy(float))
        there = _predictions(surrogate, {axis.name: rows[axis.name].to_numpy(float)}, chosen)
        rows = rows.assign(mean=rows["mean"] + there["mean"].to_numpy() - here)
    return rows


def agreement_rows(surrogate: Surrogate) -> pd.DataFrame:
    """Return each run of the mean beside what the others predict of it."""
    predicted, normal = surrogate.leave_one_out, float(student(MANY))
    rows = run_rows(surrogate, {})
    rows = rows[rows["in_mean"]].drop(columns="in_mean")
    rows = rows.rename(columns={"mean": "run", "half_width": "run_half_width"})
    return rows.assign(
        predicted=predicted["mean"].values, predicted_half_width=normal * predicted["error"].values
    )


#: Columns in the unit of the observable, and their headings.
_OF_OBSERVABLE = {
    "mean": "mean",
    "half_width": "half width of 95 % interval",
    "run": "run",
    "run_half_width": "half width of 95 % interval of the run",
    "predicted": "predicted from the other runs",
    "predicted_half_width": "half width of 95 % interval of the prediction",
}


def with_units(surrogate: Surrogate, rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table with units in its headings."""
    headings = {name: f"{words} [{surrogate.unit}]" for name, words in _OF_OBSERVABLE.items()}
    names = [axis.name for axis in surrogate.axes]
    headings |= {name: parameter_heading(surrogate.system, name) for name in names}
    headings["probability"] = f"probability of {' or '.join(surrogate.mean_regimes)}"
    return rows.rename(columns=headings)


def held_note(surrogate: Surrogate, *shown: str) -> str:
    """Return the sentence on the parameters that are not on an axis."""
    others = [
        setting(surrogate.system, axis.name, axis.middle)
        for axis in surrogate.numeric
        if axis.name not in shown
    ]
    return f"Held: {', '.join(others)}." if others else ""


def regime_note(surrogate: Surrogate, where: str) -> str:
    """Return the sentence on where the mean means nothing, as another regime is likelier."""
    others = [name for name in surrogate.regimes.names if name not in surrogate.mean_regimes]
    if not others:
        return ""
    return (
        f"{where} another regime ({' or '.join(others)}) is likelier than "
        f"{' or '.join(surrogate.mean_regimes)}."
    )


# Pictures of these tables.

#: Looks of error bars in sections, and of error bars of predictions.
_RUNS: dict[str, Any] = {
    **{"fmt": "o", "markersize": 3.5, "markerfacecolor": "white", "zorder": 3},
    **{"elinewidth": 0.8, "capsize": 1.5},
}
_AGREEMENT: dict[str, Any] = {"fmt": "o", "markersize": 3.5, "elinewidth": 0.7, "alpha": 0.85}

#: Width of a panel of a map where there are several, relative to a single one; most bands.
_PANEL, _MOST_BANDS = 0.7, 13


def _draw_section(data: FigureData) -> Figure:
    """Draw the mean along a parameter with its 95 % band, and the runs near it."""
    surrogate, (axis,) = find_surrogate(data)
    figure, axes = one_panel()
    for index, chosen in enumerate(shown_settings(surrogate)):
        colour, label = cycle_style(index).colour, settings(surrogate.system, chosen.items())
        rows = section_rows(surrogate, axis, chosen)
        x, mean, half_width = rows[axis.name], rows["mean"], rows["half_width"]
        axes.fill_between(x, mean - half_width, mean + half_width, color=colour, alpha=0.15, lw=0)
        likely = rows["probability"] >= EVEN
        axes.plot(x, mean.where(likely), color=colour, label=label)
        axes.plot(x, mean.where(~likely), color=colour, dashes=(4, 2), linewidth=1)
        near = near_rows(surrogate, axis, chosen)
        axes.errorbar(near[axis.name], near["mean"], near["half_width"], color=colour, **_RUNS)
    _set_axis(axes, "x", axis, surrogate)
    axes.set_ylabel(_label(surrogate))
    handles, labels = axes.get_legend_handles_labels()
    if any(labels):
        legend_above(figure, handles, labels)
    return figure


def _set_axis(axes: Axes, along: str, axis: Axis, surrogate: Surrogate) -> None:
    """Set scale, limits and label of an axis with a parameter."""
    if axis.scale == "log":
        set_log(axes, along)
    label = parameter_label(surrogate.system, axis.name)
    axes.set(**{f"{along}lim": (axis.low, axis.high), f"{along}label": label})


def _section_table(data: FigureData) -> pd.DataFrame:
    surrogate, (axis,) = find_surrogate(data)
    parts = []
    for chosen in shown_settings(surrogate):
        parts.append(section_rows(surrogate, axis, chosen).assign(of="surrogate"))
        parts.append(near_rows(surrogate, axis, chosen).assign(of="run"))
    rows = pd.concat([part for part in parts if len(part)], ignore_index=True)
    return with_units(surrogate, rows[["of", *_columns(surrogate)]])


def _columns(surrogate: Surrogate) -> list[str]:
    return [*(one.name for one in surrogate.axes), "mean", "half_width", "probability"]


def _section_notes(data: FigureData) -> list[str]:
    surrogate, _ = find_surrogate(data)
    runs = "Circles: the runs with their 95 % intervals."
    if len(surrogate.numeric) > 1:
        runs = (
            f"Circles: runs whose other parameters are within {100 * NEAR:g} % of the ranges of "
            "these values, moved here by what the surrogate says, with their 95 % intervals."
        )
    return [_basis_note(data), runs, regime_note(surrogate, "The line is dashed where")]


def _basis_note(data: FigureData) -> str:
    """Return the sentences on points and error of the mean, and on parameters on no axis."""
    surrogate, shown = find_surrogate(data)
    held = held_note(surrogate, *(axis.name for axis in shown))
    return f"{upper_first(surrogate.basis)}. {held}".strip()


def _draw_surface(data: FigureData) -> Figure:
    """Draw the mean over two parameters, a panel for each choice, with runs and regimes."""
    surrogate, (x, y) = find_surrogate(data)
    every = shown_settings(surrogate)
    width = SINGLE_SIZE[0] * (1 if len(every) == 1 else _PANEL * len(every))
    figure = Figure(figsize=(width, SINGLE_SIZE[1]), layout="constrained")
    panels = figure.subplots(1, len(every), sharey=True, squeeze=False)[0]
    grids = [surface_rows(surrogate, x, y, chosen) for chosen in every]
    means = pd.concat(grids)["mean"]
    levels = MaxNLocator(_MOST_BANDS).tick_values(means.min(), means.max())
    entries: dict[str, Any] = {}
    for axes, chosen, rows in zip(panels, every, grids, strict=True):
        names = (x.name, y.name, "mean", "probability")
        across, up, mean, chance = (
            rows[name].to_numpy().reshape(MAP_STEPS, MAP_STEPS) for name in names
        )
        filled = axes.contourf(across, up, mean, levels=levels, cmap=COLOURS)
        for is_in_mean, runs in run_rows(surrogate, chosen).groupby("in_mean"):
            look = {"color": "black", "markerfacecolor": "black" if is_in_mean else "white"}
            look |= {"label": "run" if is_in_mean else "run left out of the mean"}
            axes.plot(runs[x.name], runs[y.name], "o", markersize=3.6, clip_on=False, **look)
        if chance.min() < EVEN < chance.max():
            axes.contour(across, up, chance, [EVEN], colors="black", linewidths=1.8)
            label = f"probability of {' or '.join(surrogate.mean_regimes)} 1/2"
            axes.plot([], [], color="black", linewidth=1.8, label=label)
        if chosen:
            axes.set_title(settings(surrogate.system, chosen.items()), fontsize=9)
        axes.grid(visible=False)
        for along, one in (("x", x), ("y", y)):
            _set_axis(axes, along, one, surrogate)
        axes.label_outer()
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    figure.colorbar(filled, ax=list(panels), pad=0.02, label=_label(surrogate))
    legend_above(figure, list(entries.values()), list(entries))
    return figure


def _surface_table(data: FigureData) -> pd.DataFrame:
    surrogate, (x, y) = find_surrogate(data)
    parts = [surface_rows(surrogate, x, y, chosen) for chosen in shown_settings(surrogate)]
    return with_units(surrogate, pd.concat(parts, ignore_index=True)[_columns(surrogate)])


def _surface_notes(data: FigureData) -> list[str]:
    surrogate, _ = find_surrogate(data)
    dots = "Dots: all runs, wherever their other parameters are."
    return [_basis_note(data), dots, regime_note(surrogate, "Across the line")]


def _draw_agreement(data: FigureData) -> Figure:
    """Draw each run against what the others predict of it."""
    surrogate, _ = find_surrogate(data)
    rows = agreement_rows(surrogate)
    figure, axes = one_panel((4.4, 4.2))
    bars = rows["run_half_width"], rows["predicted_half_width"]
    colour = cycle_style(1).colour
    axes.errorbar(rows["predicted"], rows["run"], *bars, color=colour, **_AGREEMENT)
    both = pd.concat([rows["predicted"], rows["run"]])
    if surrogate.process.is_log and both.min() > 0:
        for along in "xy":
            set_log(axes, along)
    for along in "xy":
        limit_axis(axes, along, both)
    ends = *axes.get_xlim(), *axes.get_ylim()
    axes.set(xlim=(min(ends), max(ends)), ylim=(min(ends), max(ends)), aspect="equal")
    axes.plot([0, 1], [0, 1], transform=axes.transAxes, **LEVEL | {"linestyle": "-"})
    axes.set_xlabel(f"predicted {_label(surrogate)}")
    axes.set_ylabel(f"{_label(surrogate)} of the run")
    return figure


def _agreement_table(data: FigureData) -> pd.DataFrame:
    surrogate, _ = find_surrogate(data)
    return with_units(surrogate, agreement_rows(surrogate))


def _agreement_notes(data: FigureData) -> list[str]:
    surrogate, _ = find_surrogate(data)
    scatter = (
        "Too few points have two replicates: how far initial states differ is estimated from how "
        "far the runs are from a smooth surface."
    )
    return [
        "Bars: 95 % intervals of the runs (vertical) and of the predictions (horizontal).",
        f"{100 * surrogate.coverage:.0f} % of the runs are within the interval of their prediction "
        f"before it is widened: by {surrogate.process.widening:.2f} for few points, and by more "
        "beside runs that the others do not expect.",
        f"Error of the surrogate: {percent(surrogate.error)} of the mean size of the observable, "
        f"from {len(surrogate.process.y)} points, each predicted from the others.",
        scatter * surrogate.process.has_scatter,
    ]


def _label(surrogate: Surrogate) -> str:
    text = observable_text(surrogate.observable, surrogate.unit, "si", surrogate.system)
    return wrap_label(text)


SECTION = Drawing(_draw_section, _section_table, _section_notes)
SURFACE = Drawing(_draw_surface, _surface_table, _surface_notes)
AGREEMENT = Drawing(_draw_agreement, _agreement_table, _agreement_notes)
