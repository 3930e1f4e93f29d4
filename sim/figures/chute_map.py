"""Regimes of chute flows over depth and another parameter, with the boundaries found."""

from math import atan, degrees, radians, tan

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from sim.figures.boundaries import BAR_PITCH, boundary_notes, draw_boundaries
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.style import THEORY, canvas, place_legend
from sim.study.figure_spec import CREEP

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
    """Draw a marker per point, the boundaries, and where friction balances the weight."""
    figure, axes = canvas(height=4.3)
    _, y = data.spec.axes
    _draw_points(axes, data.rows, y)
    draw_boundaries(axes, data.boundaries, ("depth", y), aside=1.5 * BAR_PITCH)
    _set_depth_axis(axes)
    _THEORIES[y](axes, data.rows)
    place_legend(figure, axes)
    return figure


def _draw_points(axes: Axes, rows: pd.DataFrame, y: str) -> None:
    regimes = rows["regime"].mask(creeping(rows), CREEPING)
    for regime, (marker, colour, filled) in MARKS.items():
        part = rows[regimes == regime]
        if len(part):
            axes.plot(
                part["depth"],
                part[y],
                marker,
                color=colour,
                markerfacecolor=colour if filled else "white",
                markersize=4.6,
                label=regime,
                zorder=3,
            )


def creeping(rows: pd.DataFrame) -> pd.Series:
    """Return which points of the chute move, but slower than `CREEP`, whatever their trend is."""
    slow = rows["velocity"].abs() < CREEP * np.sqrt(rows["gravity"] * rows["diameter"])
    return slow & ~rows["regime"].isin(("arrested", "failed"))


def _set_depth_axis(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("depth n (particles per σ²)")


def _draw_least_friction(axes: Axes, rows: pd.DataFrame) -> None:
    for angle in sorted(set(rows["angle"])):
        axes.axhline(tan(radians(angle)), label=f"μ = tan θ, θ = {angle:g}°", **THEORY)
    axes.set_ylabel("friction coefficient μ")


def _draw_largest_angle(axes: Axes, rows: pd.DataFrame) -> None:
    for friction in sorted(set(rows["friction"])):
        axes.axhline(degrees(atan(friction)), label=f"tan θ = μ = {friction:g}", **THEORY)
    axes.set_ylabel("inclination θ (degrees)")


#: Draws where friction just holds the weight, by the parameter on the vertical axis.
_THEORIES = {"friction": _draw_least_friction, "angle": _draw_largest_angle}

KIND = Kind(draw, notes=boundary_notes)
