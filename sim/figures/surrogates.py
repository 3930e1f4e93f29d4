"""Pictures of a surrogate: sections along a parameter, maps over two, and predicted against run."""

from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from sim.base.errors import percent
from sim.figures.axes import set_log
from sim.figures.data import Drawing, FigureData, observable_text
from sim.figures.plot import SINGLE_SIZE, parameter_label, wrap_label
from sim.figures.spheres import COLOURS
from sim.figures.style import LEVEL, cycle_style, legend_above, settings
from sim.figures.surrogate_rows import (
    MAP_STEPS,
    NEAR,
    agreement_rows,
    basis_note,
    find_axis,
    find_surrogate,
    near_rows,
    regime_note,
    run_rows,
    section_rows,
    shown_settings,
    surface_rows,
    with_units,
)
from sim.surrogates.answers import EVEN
from sim.surrogates.surrogate import Surrogate

#: Looks of error bars in sections, of error bars of predictions, and of the line of a regime.
_RUNS: dict[str, Any] = {
    **{"fmt": "o", "markersize": 3.5, "markerfacecolor": "white", "zorder": 3},
    **{"elinewidth": 0.8, "capsize": 1.5},
}
_AGREEMENT: dict[str, Any] = {"fmt": "o", "markersize": 3.5, "elinewidth": 0.7, "alpha": 0.85}
_BOUNDARY: dict[str, Any] = {"color": "black", "linewidth": 1.8}

#: Width of a panel of a map where there are several, relative to a single one; most bands.
_PANEL, _MOST_BANDS = 0.7, 13


def _draw_section(data: FigureData) -> Figure:
    """Draw the mean along a parameter with its 95 % band, and the runs near it."""
    surrogate, axis = find_surrogate(data), find_axis(data, "x")
    figure = Figure(figsize=SINGLE_SIZE, layout="constrained")
    axes = figure.subplots()
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
    if axis.scale == "log":
        set_log(axes, "x")
    axes.set_xlim(axis.low, axis.high)
    axes.set_xlabel(parameter_label(surrogate.system, axis.name))
    axes.set_ylabel(_label(surrogate))
    handles, labels = axes.get_legend_handles_labels()
    if any(labels):
        legend_above(figure, handles, labels)
    return figure


def _section_table(data: FigureData) -> pd.DataFrame:
    surrogate, axis = find_surrogate(data), find_axis(data, "x")
    parts = []
    for chosen in shown_settings(surrogate):
        parts.append(section_rows(surrogate, axis, chosen).assign(of="surrogate"))
        parts.append(near_rows(surrogate, axis, chosen).assign(of="run"))
    rows = pd.concat([part for part in parts if len(part)], ignore_index=True)
    names = ["of", *(one.name for one in surrogate.axes), "mean", "half_width", "probability"]
    return with_units(surrogate, rows[names])


def _section_notes(data: FigureData) -> list[str]:
    surrogate, axis = find_surrogate(data), find_axis(data, "x")
    runs = "Circles: the runs with their 95 % intervals."
    if len(surrogate.numeric) > 1:
        runs = (
            f"Circles: runs whose other parameters are within {100 * NEAR:g} % of the ranges of "
            "these values, moved here by what the surrogate says, with their 95 % intervals."
        )
    dashed = regime_note(surrogate, "The line is dashed where")
    return [basis_note(surrogate, axis.name), runs, dashed]


def _draw_surface(data: FigureData) -> Figure:
    """Draw the mean over two parameters, a panel for each choice, with runs and regimes."""
    surrogate, x, y = find_surrogate(data), find_axis(data, "x"), find_axis(data, "y")
    every = shown_settings(surrogate)
    width = SINGLE_SIZE[0] * (1 if len(every) == 1 else _PANEL * len(every))
    figure = Figure(figsize=(width, SINGLE_SIZE[1]), layout="constrained")
    panels = figure.subplots(1, len(every), sharey=True, squeeze=False)[0]
    grids = [surface_rows(surrogate, x, y, chosen) for chosen in every]
    values = pd.concat([rows["mean"] for rows in grids])
    levels = MaxNLocator(_MOST_BANDS).tick_values(values.min(), values.max())
    for axes, chosen, rows in zip(panels, every, grids, strict=True):
        columns = (x.name, y.name, "mean", "probability")
        parts = (rows[name].to_numpy().reshape(MAP_STEPS, MAP_STEPS) for name in columns)
        across, up, mean, chance = parts
        filled = axes.contourf(across, up, mean, levels=levels, cmap=COLOURS)
        if chance.min() < EVEN < chance.max():
            axes.contour(across, up, chance, [EVEN], colors="black", linewidths=1.8)
        for is_in_mean, runs in run_rows(surrogate, chosen).groupby("in_mean"):
            axes.plot(runs[x.name], runs[y.name], clip_on=False, **_dot(bool(is_in_mean)))
        if chosen:
            axes.set_title(settings(surrogate.system, chosen.items()), fontsize=9)
        for name, one in (("x", x), ("y", y)):
            if one.scale == "log":
                set_log(axes, name)
        axes.set(xlim=(x.low, x.high), ylim=(y.low, y.high))
        axes.set_xlabel(parameter_label(surrogate.system, x.name))
        axes.grid(visible=False)
    panels[0].set_ylabel(parameter_label(surrogate.system, y.name))
    figure.colorbar(filled, ax=list(panels), pad=0.02, label=_label(surrogate))
    _explain_marks(figure, panels, surrogate)
    return figure


def _dot(is_in_mean: bool) -> dict[str, Any]:
    """Return the look of a run in a map: filled where it is part of the mean."""
    face = "black" if is_in_mean else "white"
    edge = {"markeredgecolor": "black", "markeredgewidth": 0.7}
    return {"marker": "o", "linestyle": "", "markersize": 3.6, "markerfacecolor": face, **edge}


def _explain_marks(figure: Figure, panels: Sequence[Axes], surrogate: Surrogate) -> None:
    """Put a legend above a map: dots, and the line where another regime becomes likelier."""
    entries = {"run": Line2D([], [], **_dot(True))}
    if not surrogate.in_mean.all():
        entries["run left out of the mean"] = Line2D([], [], **_dot(False))
    if any(len(axes.collections) > 1 for axes in panels):
        label = f"probability of {' or '.join(surrogate.mean_regimes)} 1/2"
        entries[label] = Line2D([], [], **_BOUNDARY)
    legend_above(figure, list(entries.values()), list(entries))


def _surface_table(data: FigureData) -> pd.DataFrame:
    surrogate, x, y = find_surrogate(data), find_axis(data, "x"), find_axis(data, "y")
    parts = [surface_rows(surrogate, x, y, chosen) for chosen in shown_settings(surrogate)]
    names = [*(one.name for one in surrogate.axes), "mean", "half_width", "probability"]
    return with_units(surrogate, pd.concat(parts, ignore_index=True)[names])


def _surface_notes(data: FigureData) -> list[str]:
    surrogate = find_surrogate(data)
    basis = basis_note(surrogate, data.spec.answer.x, data.spec.answer.y)
    dots = "Dots: all runs, wherever their other parameters are."
    line = regime_note(surrogate, "Across the line")
    return [basis, dots, line]


def _draw_agreement(data: FigureData) -> Figure:
    """Draw each run against what the others predict of it."""
    surrogate = find_surrogate(data)
    rows = agreement_rows(surrogate)
    figure = Figure(figsize=(4.4, 4.2), layout="constrained")
    axes, colour = figure.subplots(), cycle_style(1).colour
    bars = rows["run_half_width"], rows["predicted_half_width"]
    axes.errorbar(rows["predicted"], rows["run"], *bars, color=colour, **_AGREEMENT)
    both = pd.concat([rows["predicted"], rows["run"]])
    room = 0.05 * (both.max() - both.min() or abs(both.max()) or 1.0)
    low, high = both.min() - room, both.max() + room
    if surrogate.process.is_log and both.min() > 0:
        low, high = 0.85 * both.min(), both.max() / 0.85
        for name in "xy":
            set_log(axes, name)
    axes.plot([low, high], [low, high], **LEVEL | {"linestyle": "-"})
    axes.set(xlim=(low, high), ylim=(low, high), aspect="equal")
    axes.set_xlabel(f"predicted {_label(surrogate)}")
    axes.set_ylabel(f"{_label(surrogate)} of the run")
    return figure


def _agreement_table(data: FigureData) -> pd.DataFrame:
    surrogate = find_surrogate(data)
    return with_units(surrogate, agreement_rows(surrogate))


def _agreement_notes(data: FigureData) -> list[str]:
    surrogate = find_surrogate(data)
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
