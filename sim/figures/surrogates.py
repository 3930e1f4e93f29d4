"""Pictures of a surrogate: sections along a parameter, maps over two, and predicted against run.

Options of a figure: ``answer`` is the surrogate's file in the results of the study; ``x`` and ``y``
are the parameters on the axes. The others are held in the middle of their ranges.
"""

from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sim.base.errors import InputError
from sim.base.statistics import MANY, student
from sim.figures.axes import set_log
from sim.figures.configuration import COLOURS
from sim.figures.data import FigureData
from sim.figures.plot import SINGLE_SIZE, parameter_label, wrap_label
from sim.figures.quantity import label_with_unit, unit_of
from sim.figures.style import LEVEL, cycle_style, legend_above, settings
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import setting
from sim.study.design import Axis
from sim.study.plot_contents import name_in_words
from sim.surrogates.storage import load
from sim.surrogates.surrogate import Surrogate, unit_cube

#: Values along a section, and along each side of a map.
_SECTION_STEPS, _MAP_STEPS = 161, 61

#: Runs are near a section where each other parameter is within this share of its range.
_NEAR = 0.2

#: Look of the runs near a section.
_RUNS: dict[str, Any] = {
    **{"fmt": "o", "markersize": 3.5, "markerfacecolor": "white", "zorder": 3},
    **{"elinewidth": 0.8, "capsize": 1.5},
}

#: Most combinations of words and switches that have a curve or a panel of their own.
_MOST_SETTINGS = 4

#: Probability of the regimes of the mean below which a section is dashed.
_EVEN = 0.5


def draw_section(data: FigureData) -> Figure:
    """Draw the mean along a parameter with its 95 % band, and the runs near it."""
    surrogate, axis = _surrogate(data), _axis(data, "x")
    figure = Figure(figsize=SINGLE_SIZE, layout="constrained")
    axes = figure.subplots()
    for index, chosen in enumerate(_settings(surrogate)):
        colour, label = cycle_style(index).colour, settings(surrogate.system, chosen.items())
        rows = _section_rows(surrogate, axis, chosen)
        low, high = rows["mean"] - rows["half_width"], rows["mean"] + rows["half_width"]
        axes.fill_between(rows[axis.name], low, high, color=colour, alpha=0.18, linewidth=0)
        likely = rows["probability"] >= _EVEN
        axes.plot(rows[axis.name], rows["mean"].where(likely), color=colour, label=label)
        axes.plot(
            rows[axis.name], rows["mean"].where(~likely), color=colour, dashes=(4, 2), linewidth=1
        )
        near = _runs_near(surrogate, axis, chosen)
        axes.errorbar(near[axis.name], near["mean"], near["half_width"], color=colour, **_RUNS)
    if axis.scale == "log":
        set_log(axes, "x")
    axes.set_xlim(axis.low, axis.high)
    axes.set_xlabel(parameter_label(surrogate.system, axis.name))
    axes.set_ylabel(_label(surrogate))
    handles, labels = axes.get_legend_handles_labels()
    if any(labels):
        legend_above(figure, handles, labels)
    return figure


def section_table(data: FigureData) -> pd.DataFrame:
    """Return the section and the runs near it, row by row, units in the headings."""
    surrogate, axis = _surrogate(data), _axis(data, "x")
    parts = []
    for chosen in _settings(surrogate):
        parts.append(_section_rows(surrogate, axis, chosen).assign(of="surrogate"))
        parts.append(_runs_near(surrogate, axis, chosen).assign(of="run"))
    rows = pd.concat([part for part in parts if len(part)], ignore_index=True)
    names = ["of", *(one.name for one in surrogate.axes), "mean", "half_width", "probability"]
    return _with_units(surrogate, rows[[name for name in names if name in rows]])


def section_notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption of a section."""
    surrogate, axis = _surrogate(data), _axis(data, "x")
    notes = [_held_note(surrogate, axis.name)]
    if len(surrogate.numeric) > 1:
        notes.append(
            f"Circles: runs whose other parameters are within {100 * _NEAR:g} % of the ranges of "
            "these values, with their 95 % intervals, which are left where they were run."
        )
    else:
        notes.append("Circles: the runs, with their 95 % intervals.")
    return [*notes, _regime_note(surrogate, "The line is dashed"), _error_note(surrogate)]


def draw_surface(data: FigureData) -> Figure:
    """Draw the mean over two parameters, a panel for each choice, with runs and regimes."""
    surrogate, x, y = _surrogate(data), _axis(data, "x"), _axis(data, "y")
    every = _settings(surrogate)
    width, height = SINGLE_SIZE
    figure = Figure(figsize=(width * (1 if len(every) == 1 else 0.75 * len(every)), height))
    figure.set_layout_engine("constrained")
    panels = figure.subplots(1, len(every), sharey=True, squeeze=False)[0]
    grids = [_surface_rows(surrogate, x, y, chosen) for chosen in every]
    ends = min(rows["mean"].min() for rows in grids), max(rows["mean"].max() for rows in grids)
    levels = np.linspace(*ends, 13) if ends[0] < ends[1] else np.linspace(-1, 1, 3) + ends[0]
    for axes, chosen, rows in zip(panels, every, grids, strict=True):
        shape = (_MAP_STEPS, _MAP_STEPS)
        across, up, mean, chance = (
            rows[name].to_numpy().reshape(shape) for name in (x.name, y.name, "mean", "probability")
        )
        filled = axes.contourf(across, up, mean, levels=levels, cmap=COLOURS)
        if chance.min() < _EVEN < chance.max():
            axes.contour(across, up, chance, levels=[_EVEN], colors="black", linewidths=1.6)
        _draw_runs(axes, surrogate, x, y, chosen)
        if chosen:
            axes.set_title(settings(surrogate.system, chosen.items()), fontsize=9)
        for name, one in (("x", x), ("y", y)):
            if one.scale == "log":
                set_log(axes, name)
        axes.set_xlim(x.low, x.high)
        axes.set_ylim(y.low, y.high)
        axes.set_xlabel(parameter_label(surrogate.system, x.name))
        axes.grid(visible=False)
    panels[0].set_ylabel(parameter_label(surrogate.system, y.name))
    bar = figure.colorbar(filled, ax=list(panels), pad=0.02)
    bar.set_label(_label(surrogate))
    bar.outline.set_visible(False)
    _explain_marks(figure, panels, surrogate)
    return figure


def surface_table(data: FigureData) -> pd.DataFrame:
    """Return the map, row by row, units in the headings."""
    surrogate, x, y = _surrogate(data), _axis(data, "x"), _axis(data, "y")
    rows = pd.concat(
        [_surface_rows(surrogate, x, y, chosen) for chosen in _settings(surrogate)],
        ignore_index=True,
    )
    names = [*(one.name for one in surrogate.axes), "mean", "half_width", "probability"]
    return _with_units(surrogate, rows[names])


def surface_notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption of a map."""
    surrogate = _surrogate(data)
    held = _held_note(surrogate, data.spec.options["x"], data.spec.options["y"])
    dots = (
        "Dots: all runs, wherever their other parameters are; open ones are not part of the mean."
    )
    return [held, dots, _regime_note(surrogate, "Beyond the line"), _error_note(surrogate)]


def draw_agreement(data: FigureData) -> Figure:
    """Draw each run against what the others predict of it."""
    surrogate = _surrogate(data)
    rows = _agreement_rows(surrogate)
    figure = Figure(figsize=(4.4, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.errorbar(
        rows["predicted"], rows["run"], rows["run_half_width"], rows["predicted_half_width"],
        fmt="o", color=cycle_style(1).colour, markersize=3.5, elinewidth=0.7, capsize=0, alpha=0.85,
    )  # fmt: skip
    both = pd.concat([rows["predicted"], rows["run"]])
    room = 0.05 * (both.max() - both.min() or abs(both.max()) or 1.0)
    low, high = both.min() - room, both.max() + room
    if surrogate.process.is_log and both.min() > 0:
        low, high = 0.85 * both.min(), both.max() / 0.85
        for name in "xy":
            set_log(axes, name)
    axes.plot([low, high], [low, high], **LEVEL | {"linestyle": "-"})
    axes.set_xlim(low, high)
    axes.set_ylim(low, high)
    axes.set_aspect("equal")
    axes.set_xlabel(f"predicted: {_label(surrogate)}")
    axes.set_ylabel(f"run: {_label(surrogate)}")
    return figure


def agreement_table(data: FigureData) -> pd.DataFrame:
    """Return runs and predictions, row by row, units in the headings."""
    surrogate = _surrogate(data)
    return _with_units(surrogate, _agreement_rows(surrogate))


def agreement_notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption of predicted against run."""
    surrogate = _surrogate(data)
    left = ", ".join(f"{count} {name}" for name, count in surrogate.counts.items())
    form = "its logarithm" if surrogate.process.is_log else "the observable itself"
    notes = [
        "Bars: 95 % intervals of the runs (vertical) and of the predictions (horizontal).",
        f"The surrogate goes through {form}.",
        f"{100 * surrogate.coverage:.0f} % of the runs were within the 95 % interval of their "
        f"prediction, before intervals were widened by {surrogate.process.widening:.2f}.",
        _error_note(surrogate),
    ]
    if surrogate.process.has_scatter:
        notes.append(
            "No point has two replicates: how much initial states differ is estimated from how far "
            "the runs are from a smooth surface."
        )
    return [*notes, f"Not part of the mean: {left}."] if left else notes


def _surrogate(data: FigureData) -> Surrogate:
    if data.results.runs is None:
        raise InputError(f"{data.spec.name}: drawn in the results of a study alone")
    path = data.results.runs.parent / data.spec.options["answer"]
    return _load(path, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(maxsize=4)
def _load(path: Path, changed: int) -> Surrogate:
    """Return the surrogate in a file that was ``changed`` (ns) at some time."""
    return load(path)


def _axis(data: FigureData, option: str) -> Axis:
    name = data.spec.options[option]
    return next(axis for axis in _surrogate(data).axes if axis.name == name)


def _settings(surrogate: Surrogate) -> list[dict[str, Any]]:
    """Return combinations of the words and switches, no more than are shown."""
    choices = surrogate.choices
    every = (dict(zip(choices, values, strict=True)) for values in product(*choices.values()))
    return [chosen for chosen, _ in zip(every, range(_MOST_SETTINGS), strict=False)]


def _steps(axis: Axis, count: int) -> np.ndarray:
    spread = np.geomspace if axis.scale == "log" else np.linspace
    return np.clip(spread(axis.low, axis.high, count), axis.low, axis.high)


def _middle(axis: Axis) -> float:
    """Return the middle of the range of a parameter, to three digits."""
    return float(f"{_steps(axis, 3)[1]:.3g}")


def _rows(
    surrogate: Surrogate, columns: dict[str, np.ndarray], chosen: dict[str, Any]
) -> pd.DataFrame:
    """Return predictions at values (n,) of some parameters, the others in the middle."""
    count = len(next(iter(columns.values())))
    rows = pd.DataFrame(
        {
            axis.name: columns.get(axis.name, np.full(count, _middle(axis)))
            for axis in surrogate.numeric
        }
    )
    set_surrogate = surrogate.at(**chosen)
    x = rows.to_numpy()
    rows["mean"], error = set_surrogate.predict(x)
    chances = dict(zip(surrogate.regimes.names, set_surrogate.probability(x), strict=True))
    total = sum((chances[name] for name in surrogate.used if name in chances), np.zeros(count))
    return rows.assign(half_width=student(MANY) * error, probability=total, **chosen)


def _section_rows(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    return _rows(surrogate, {axis.name: _steps(axis, _SECTION_STEPS)}, chosen)


def _surface_rows(surrogate: Surrogate, x: Axis, y: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    up, across = np.meshgrid(_steps(y, _MAP_STEPS), _steps(x, _MAP_STEPS), indexing="ij")
    return _rows(surrogate, {x.name: across.ravel(), y.name: up.ravel()}, chosen)


def _runs(surrogate: Surrogate, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs at a choice of words and switches, with their 95 % intervals."""
    sample = surrogate.sample
    names = [axis.name for axis in surrogate.axes]
    columns = {name: sample[name].values for name in (*names, "mean", "regime")}
    rows = pd.DataFrame(columns).assign(included=surrogate.included)
    rows["half_width"] = student(MANY) * sample["standard_error"].values
    is_chosen = [rows[name] == value for name, value in chosen.items()]
    return rows[np.all(is_chosen, axis=0)] if is_chosen else rows


def _runs_near(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs of the mean whose other parameters are near the middle."""
    rows = _runs(surrogate, chosen)
    others = tuple(one for one in surrogate.numeric if one.name != axis.name)
    rows = rows[rows["included"]]
    if others and len(rows):
        cube = unit_cube(others, {one.name: rows[one.name].to_numpy() for one in others})
        middle = unit_cube(others, {one.name: np.array([_middle(one)]) for one in others})
        rows = rows[(np.abs(cube - middle) <= _NEAR).all(axis=1)]
    return rows


def _draw_runs(axes: Axes, surrogate: Surrogate, x: Axis, y: Axis, chosen: dict[str, Any]) -> None:
    for is_included, rows in _runs(surrogate, chosen).groupby("included"):
        face = "black" if is_included else "white"
        axes.plot(
            rows[x.name], rows[y.name], "o", markersize=3.2, markerfacecolor=face,
            markeredgecolor="black", markeredgewidth=0.7, clip_on=False, zorder=3,
        )  # fmt: skip


def _explain_marks(figure: Figure, panels: Any, surrogate: Surrogate) -> None:
    """Put a legend above the map: dots, and the line where another regime becomes likely."""
    dot: dict[str, Any] = {"marker": "o", "linestyle": "", "color": "black", "markersize": 3.5}
    entries = {"run": Line2D([], [], **dot)}
    if not surrogate.included.all():
        entries["run of another regime"] = Line2D([], [], markerfacecolor="white", **dot)
    if any(len(axes.collections) > 1 for axes in panels):
        label = f"probability of {' or '.join(surrogate.used)} is 1/2"
        entries[label] = Line2D([], [], color="black", linewidth=1.6)
    legend_above(figure, list(entries.values()), list(entries))


def _agreement_rows(surrogate: Surrogate) -> pd.DataFrame:
    rows, normal = surrogate.predicted, float(student(MANY))
    parameters = surrogate.sample.isel(point=surrogate.included)
    return pd.DataFrame(
        {"point": rows["point"].values}
        | {axis.name: parameters[axis.name].values for axis in surrogate.axes}
        | {
            "run": rows["run"].values,
            "run_half_width": normal * rows["run_error"].values,
            "predicted": rows["mean"].values,
            "predicted_half_width": normal * rows["error"].values,
        }
    )


def _label(surrogate: Surrogate) -> str:
    unit = unit_of(surrogate.unit, "si", surrogate.system)
    return wrap_label(label_with_unit(name_in_words(surrogate.observable), unit))


#: Columns in the unit of the observable, and their headings.
_OF_OBSERVABLE = {
    "mean": "mean",
    "half_width": "half width of 95 % interval",
    "run": "run",
    "run_half_width": "half width of 95 % interval of the run",
    "predicted": "predicted from the other runs",
    "predicted_half_width": "half width of 95 % interval of the prediction",
}


def _with_units(surrogate: Surrogate, rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table with units in its headings."""
    declared = field_info(SYSTEMS[surrogate.system])
    units = {axis.name: declared[axis.name] for axis in surrogate.axes}
    headings = {name: f"{words} [{surrogate.unit}]" for name, words in _OF_OBSERVABLE.items()}
    for name, row in units.items():
        unit = row.scale or row.unit
        headings[name] = f"{name} [{unit}]" if unit else name
    headings["probability"] = f"probability of {' or '.join(surrogate.used)}"
    return rows.rename(columns=headings)


def _held_note(surrogate: Surrogate, *shown: str) -> str:
    held = [
        setting(surrogate.system, axis.name, _middle(axis))
        for axis in surrogate.numeric
        if axis.name not in shown
    ]
    return f"Held: {', '.join(held)}." if held else ""


def _regime_note(surrogate: Surrogate, where: str) -> str:
    others = [name for name in surrogate.regimes.names if name not in surrogate.used]
    if not others:
        return ""
    used = " or ".join(surrogate.used)
    return f"{where} another regime is likelier than {used}: {' or '.join(others)}."


def _error_note(surrogate: Surrogate) -> str:
    return (
        f"Error of the surrogate: {100 * surrogate.error:.2g} % of the mean size of the "
        f"observable, from {len(surrogate.process.y)} points, each predicted from the others."
    )
