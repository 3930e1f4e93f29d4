"""Regimes of points in a plane of two parameters, boundaries between them, and lines of theory."""

from collections.abc import Sequence
from dataclasses import replace
from math import atan, degrees, radians, tan
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from sim.figures.data import FigureData, split_curves
from sim.figures.fit import Fit, fit_points
from sim.figures.style import THEORY, CurveStyle, cycle_style, escape_label, move_aside
from sim.parameters import SYSTEMS
from sim.parameters.words import setting
from sim.study.plottable import CREEP

#: Size of the markers of regimes, and shift between bars at the same position, points of print.
_MARKER, BAR_PITCH = 5.0, 5.0

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

#: Name in legends and style of the bars of each kind of boundary. Further boundaries of a kind get
#: other styles.
BOUNDARIES = {
    "flow": ("limit of arrest", CurveStyle("#009e73", "-", "")),
    "acceleration": ("limit of acceleration", CurveStyle("#cc79a7", "-", "")),
    "transport": ("onset of transport", CurveStyle("#000000", "-", "o")),
}

#: What captions say of boundaries without an interval as narrow as asked for.
_VERDICTS = {
    "wide": "wider than asked for",
    "none": "not within the range searched",
    "several": "not a single one",
    "open": "unknown",
}


def draw_plane(axes: Axes, data: FigureData, rows: pd.DataFrame) -> None:
    """Draw regimes of points, the boundaries that feed the figure, and a line of theory."""
    spec, aside = data.spec, 0.0
    if spec.panels and len(data.boundaries):
        is_here = data.boundaries[spec.panels].isin(rows[spec.panels])
        data = replace(data, boundaries=data.boundaries[is_here])
    if spec.point != "none":
        # Points at one place stand side by side.
        lanes = rows.groupby(list(spec.axes)).cumcount()
        is_slow = creeping(rows) if spec.creep else pd.Series(False, rows.index)
        _draw_regimes(axes, rows, rows["regime"].mask(is_slow, CREEPING), spec.axes, lanes)
        aside = _MARKER * (lanes.max() / 2 + 2)
    _draw_boundaries(axes, data.boundaries, spec.axes, aside=aside)
    for fit in fit_boundaries(data):
        label = "" if fit.problem else f"{spec.fit} law"
        axes.plot(fit.line.index, fit.line, label=label, color="#009e73", zorder=2)
    if spec.theory:
        _draw_theory(axes, rows, spec.theory)
    axes.margins(0.13)


def _draw_regimes(
    axes: Axes, rows: pd.DataFrame, regimes: pd.Series, plane: Sequence[str], lanes: pd.Series
) -> None:
    x, y = plane
    for regime, (marker, colour, filled) in MARKS.items():
        face = colour if filled else "white"
        look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "markersize": _MARKER}
        for lane, part in rows[regimes == regime].groupby(lanes):
            drawn = axes.plot(part[x], part[y], marker, label=regime, zorder=3, **look)
            move_aside(axes, drawn, x=(-1) ** lane * ((lane + 1) // 2) * (_MARKER + 1.5))


def creeping(rows: pd.DataFrame) -> pd.Series:
    """Return which points of the chute move, but slower than `CREEP`, whatever their trend is."""
    slow = rows["velocity"].abs() < CREEP * np.sqrt(rows["gravity"] * rows["diameter"])
    return slow & ~rows["regime"].isin(("arrested", "failed"))


#: Where friction just holds the weight: the parameter, what the other one is there, and its entry.
_HOLDS = {
    "least_friction": ("angle", lambda x: tan(radians(x)), "μ = tan θ, slope θ = {:g}°"),
    "largest_angle": ("friction", lambda x: degrees(atan(x)), "tan θ = μ, friction μ = {:g}"),
}


def _draw_theory(axes: Axes, rows: pd.DataFrame, theory: str) -> None:
    """Draw where friction just holds the weight, or the belt accelerates as gravity does."""
    if theory in _HOLDS:
        name, other, label = _HOLDS[theory]
        for value in sorted(set(rows[name])):
            axes.axhline(other(value), label=label.format(value), **THEORY)
        return
    smallest, largest = rows["amplitude"][rows["amplitude"] > 0].agg(["min", "max"])
    amplitude = np.linspace(0.9 * smallest, 1.05 * largest, 200)
    for (gravity, diameter), _ in rows.groupby(["gravity", "diameter"]):
        frequency = np.sqrt(gravity / (amplitude * diameter)) / (2 * np.pi)
        axes.plot(amplitude, frequency, label="$Γ = 4π^2 f^2 A_z/g$ = 1", **THEORY)


def _draw_boundaries(
    axes: Axes, boundaries: pd.DataFrame, plane: Sequence[str], aside: float = 0
) -> None:
    """Draw the intervals that hold a boundary as bars along its parameter, side by side.

    They stand ``aside`` of their position, in points of print; a marker shows the kind.
    """
    intervals = boundaries[boundaries["along"].isin(plane) & boundaries["low"].notna()]
    looks: list[CurveStyle] = []
    numbers: dict[tuple[str, float], int] = {}
    for names, bars in _kinds(intervals, plane):
        text, look = BOUNDARIES[names.pop("of")]
        look = cycle_style(len(looks)) if look in looks else look
        looks.append(look)
        style: dict[str, Any] = {"color": look.colour, "marker": look.marker}
        style |= {"markerfacecolor": "white", "zorder": 4}
        for bar in bars.to_dict("records"):
            upright = bar["along"] == plane[1]
            place = bar[plane[0] if upright else plane[1]]
            middle, half = (bar["low"] + bar["high"]) / 2, (bar["high"] - bar["low"]) / 2
            at = (place, middle, half) if upright else (middle, place, None, half)
            drawn = axes.errorbar(*at, **style, elinewidth=2.2, capsize=3.5, capthick=1.4)
            number = numbers[bar["along"], place] = numbers.get((bar["along"], place), -1) + 1
            # Flat bars need no more room than a marker.
            shift = (aside if upright else min(aside, 1.5 * BAR_PITCH)) + BAR_PITCH * number
            move_aside(axes, drawn.get_children(), **{"x" if upright else "y": shift})
        settings = (setting(bars["system"].iloc[0], *item) for item in names.items())
        label = escape_label(", ".join([text, *settings]))
        axes.plot([], [], **style, linewidth=2.2, label=label)


def fit_boundaries(data: FigureData) -> list[Fit]:
    """Fit the law of a plot to the middles of the intervals that hold its boundaries."""
    (x, y), found, law = data.spec.axes, data.boundaries, data.spec.fit
    if not law:
        return []
    fits = []
    for names, bars in _kinds(found[found["along"].isin((x, y)) & found["low"].notna()], (x, y)):
        middle = (bars["low"] + bars["high"]) / 2
        across, up = (bars[name].mask(bars["along"] == name, middle) for name in (x, y))
        others = {name: value for name, value in names.items() if name != "of"}
        fits.append(fit_points(law, others, across, up))
    return fits


def _kinds(
    intervals: pd.DataFrame, plane: Sequence[str]
) -> list[tuple[dict[str, Any], pd.DataFrame]]:
    """Return kind and parameters of boundaries in a plane, and the rows of each."""
    fields = {name for system in set(intervals["system"]) for name in SYSTEMS[system].model_fields}
    names = sorted(name for name in fields if name in intervals and name not in plane)
    return split_curves(intervals, "along", ("of",), names) if len(intervals) else []


def boundary_sentences(boundaries: pd.DataFrame, plane: Sequence[str]) -> list[str]:
    """Return what is drawn, and which boundaries have no interval or exceed the tolerance."""
    in_plane = boundaries[boundaries["along"].isin(plane)]
    if in_plane.empty:
        return ["One marker per point."]
    counts = {text: (in_plane["verdict"] == verdict).sum() for verdict, text in _VERDICTS.items()}
    parts = "; ".join(f"{count} {text}" for text, count in counts.items() if count)
    found = int(in_plane["low"].notna().sum())
    return [
        f"Bars: intervals that hold a boundary, {found} of {len(in_plane)} looked for.",
        f"Boundaries: {parts}." if parts else "",
    ]
