"""Pictures of a surrogate: sections along a parameter, maps over two, and predicted against run."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from sim.base.errors import percent, upper_first
from sim.figures.data import Drawing, FigureData
from sim.figures.plot import SINGLE_SIZE, one_panel, parameter_label, wrap_label
from sim.figures.spheres import COLOURS
from sim.figures.style import LEVEL, cycle_style, legend_above, limit_axis, set_log, settings
from sim.figures.surrogate_rows import (
    MAP_STEPS,
    NEAR,
    agreement_rows,
    find_surrogate,
    held_note,
    near_rows,
    regime_note,
    run_rows,
    section_rows,
    shown_settings,
    surface_rows,
    with_units,
)
from sim.figures.units import observable_text
from sim.study.design import Axis
from sim.surrogates.answers import EVEN
from sim.surrogates.surrogate import Surrogate

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
    values = pd.concat([rows["mean"] for rows in grids])
    levels = MaxNLocator(_MOST_BANDS).tick_values(values.min(), values.max())
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
