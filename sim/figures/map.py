"""A map over two parameters: regimes and the boundaries between them, or an observable.

Options of a figure: those of `sim.figures.plot`; ``show`` may be ``"regime"``. Maps of papers show
boundaries, a line of theory, and the chute's flows that creep; those of the belt show no points.
"""

from collections.abc import Sequence
from math import atan, degrees, radians, tan
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from sim.figures.axes import set_log
from sim.figures.boundaries import boundary_notes, draw_boundaries
from sim.figures.data import FigureData, varying_parameters, velocity_table
from sim.figures.foreign_data import (
    append_foreign_data,
    draw_foreign_data,
    foreign_data_notes,
    set_run_ticks,
)
from sim.figures.looks import legend
from sim.figures.plot import (
    PANEL_SIZE,
    SINGLE_SIZE,
    Panels,
    given_labels,
    label_axes,
    observed_quantity,
    panels,
    parameter_label,
    width_of,
)
from sim.figures.quantity import quantity_table
from sim.figures.style import THEORY, legend_title, move_aside, place_legend
from sim.figures.value_map import draw_values, value_notes
from sim.study.figure_spec import CREEP
from sim.study.plot_kinds import REGIME

#: Height of a paper's map of the chute, inches; size of its markers, points of print, and least
#: distance of two in a column, as a share of the range.
_CHUTE_HEIGHT, _MARKER, _APART = 4.6, 4.6, 0.03

CREEPING = f"creeps: |V| < {CREEP:g} √(gσ)"

#: Marker, colour and whether it is filled, of regimes and creeping flows as in the legend. The
#: later lie over the earlier where several runs are in one place.
MARKS = {
    "undetermined": ("D", "#666666", False),
    "mixed": ("p", "#666666", False),
    "steady": ("o", "#0072b2", True),
    "accelerating": ("^", "#d55e00", True),
    "arrested": ("s", "#000000", True),
    CREEPING: ("v", "#000000", False),
    "failed": ("x", "#666666", True),
}


def draw(data: FigureData) -> Figure:
    """Draw a marker per point of its regime, or cells or contours of the observable."""
    spec = data.spec
    figure, shown = panels(data)
    if spec.paper and spec.options["show"] == REGIME:
        _draw_of_paper(data, figure, shown)
        return figure
    if spec.options["show"] == REGIME:
        for axes, rows in shown:
            _draw_regimes(axes, rows, rows["regime"], spec.axes)
    else:
        draw_values(data, figure, shown)
    foreign = draw_foreign_data(data, shown)
    _set_axes(data, shown)
    label_axes(figure, shown, *(parameter_label(spec.system, name) for name in spec.axes))
    legend(data, figure, shown, foreign=foreign)
    return figure


def _draw_regimes(
    axes: Axes, rows: pd.DataFrame, regimes: pd.Series, plane: Sequence[str], size: float = 6.0
) -> None:
    """Draw a marker (points of print) of its regime for each point, in its lane if it has one."""
    x, y = plane
    lanes = rows.get("lane", pd.Series(0, rows.index))
    for regime, (marker, colour, filled) in MARKS.items():
        face = colour if filled else "white"
        look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "markersize": size}
        label = regime
        for lane, part in rows[regimes == regime].groupby(lanes):
            drawn = axes.plot(part[x], part[y], marker, label=label, zorder=3, **look)
            move_aside(axes, drawn, x=(-1) ** lane * ((lane + 1) // 2) * (size + 1.5))
            label = ""


def _lanes(rows: pd.DataFrame, plane: Sequence[str]) -> pd.Series:
    """Return by how many markers each point stands aside, so that it covers none below it."""
    x, y = plane
    apart, lanes = _APART * np.ptp(rows[y]), pd.Series(0, rows.index)
    for _, column in rows.groupby(x):
        highest: list[float] = []
        for index, value in column[y].sort_values().items():
            free = (lane for lane, last in enumerate(highest) if value - last >= apart)
            lanes[index] = lane = next(free, len(highest))
            highest[lane : lane + 1] = [value]
    return lanes


def _draw_of_paper(data: FigureData, figure: Figure, shown: Panels) -> None:
    """Draw the boundaries and a line of theory; on the chute a marker for each point, too."""
    ((axes, rows),), plane = shown, data.spec.axes
    if data.spec.system == "chute":
        figure.set_figheight(_CHUTE_HEIGHT)
        regimes = rows["regime"].mask(creeping(rows), CREEPING)
        rows = rows.assign(lane=_lanes(rows, plane))
        _draw_regimes(axes, rows, regimes, plane, size=_MARKER)
    # Beside all markers.
    aside = _MARKER * (rows["lane"].max() / 2 + 2) if data.spec.system == "chute" else 0
    draw_boundaries(axes, data.boundaries, plane, aside=aside)
    for axis in data.spec.options["log"]:
        set_log(axes, axis)
        getattr(axes, f"set_{axis}margin")(0.11)
        getattr(axes, f"{axis}axis").set_minor_locator(NullLocator())
    if draw_theory := _THEORIES.get(plane[1]):
        draw_theory(axes, rows)
    label_axes(figure, shown, *given_labels(data))
    curves = [name for name in data.spec.curves if name not in plane]
    kinds = varying_parameters(data.boundaries, curves)
    place_legend(figure, axes, legend_title(data.spec.system, kinds))


def creeping(rows: pd.DataFrame) -> pd.Series:
    """Return which points of the chute move, but slower than `CREEP`, whatever their trend is."""
    slow = rows["velocity"].abs() < CREEP * np.sqrt(rows["gravity"] * rows["diameter"])
    return slow & ~rows["regime"].isin(("arrested", "failed"))


def _draw_least_friction(axes: Axes, rows: pd.DataFrame) -> None:
    for angle in sorted(set(rows["angle"])):
        label = f"μ = tan θ, slope θ = {angle:g}°"
        axes.axhline(tan(radians(angle)), label=label, **THEORY)


def _draw_largest_angle(axes: Axes, rows: pd.DataFrame) -> None:
    for friction in sorted(set(rows["friction"])):
        label = f"tan θ = μ, friction μ = {friction:g}"
        axes.axhline(degrees(atan(friction)), label=label, **THEORY)


def _draw_lift_off(axes: Axes, rows: pd.DataFrame) -> None:
    smallest, largest = rows["amplitude"][rows["amplitude"] > 0].agg(["min", "max"])
    amplitude = np.linspace(0.9 * smallest, 1.05 * largest, 200)
    for (gravity, diameter), _ in rows.groupby(["gravity", "diameter"]):
        frequency = np.sqrt(gravity / (amplitude * diameter)) / (2 * np.pi)
        axes.plot(amplitude, frequency, label="$Γ = 4π^2 f^2 A_z/g$ = 1", **THEORY)


#: Draws, by the parameter on the vertical axis, where friction just holds the weight, or where the
#: belt's acceleration reaches that of gravity.
_THEORIES = {
    "friction": _draw_least_friction,
    "angle": _draw_largest_angle,
    "frequency": _draw_lift_off,
}


def _set_axes(data: FigureData, shown: Panels) -> None:
    """Set scales, and put ticks at the values that were run."""
    x, y = data.spec.axes
    log = data.spec.options["log"]
    height = SINGLE_SIZE[1] - 1.0 if len(shown) == 1 else PANEL_SIZE[1] - 0.5
    for axes, _ in shown:
        for axis in {"x", "y"} & set(log):
            set_log(axes, axis)
        if data.spec.options["show"] == REGIME:
            axes.margins(0.1)
        axes.autoscale_view()
        set_run_ticks(axes, data, x, width_of(shown))
        set_run_ticks(axes, data, y, height, "y")


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, one row per point, units in the headings."""
    shows_regimes = data.spec.options["show"] == REGIME
    rows = (
        velocity_table(data) if shows_regimes else quantity_table(data, [observed_quantity(data)])
    )
    # Both parameters follow the id of the point.
    _, x, y, *_ = rows.columns
    return append_foreign_data(data, rows, x, y)


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on markers."""
    if data.spec.options["show"] == REGIME:
        return (
            boundary_notes(data)
            if data.spec.paper
            else ["One marker per point.", *foreign_data_notes(data)]
        )
    return [*value_notes(data), *foreign_data_notes(data)]
