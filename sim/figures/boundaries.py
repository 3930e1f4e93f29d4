"""Boundaries between regimes as bars, and the sentences of captions on them."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from sim.figures.data import FigureData, split_curves, varying_parameters
from sim.figures.style import CurveStyle, cycle_style, escape_label, move_aside
from sim.parameters import SYSTEMS
from sim.parameters.words import setting

#: Name in legends and style of the bars of each kind of boundary. Further boundaries of a kind get
#: other styles.
BOUNDARIES = {
    "flow": ("limit of arrest", CurveStyle("#009e73", "-", "")),
    "acceleration": ("limit of acceleration", CurveStyle("#cc79a7", "-", "")),
    "transport": ("onset of transport", CurveStyle("#000000", "-", "o")),
}

#: Shift between bars at the same position, points of print.
BAR_PITCH = 5.0


def draw_boundaries(
    axes: Axes, boundaries: pd.DataFrame, plane: Sequence[str], aside: float = 0
) -> None:
    """Draw the intervals that contain a boundary as bars; markers in the middle show the kind.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    boundaries : pandas.DataFrame
        Boundaries, as `sim.dataset.boundaries.tabulate` returns them.
    plane : sequence of str
        Parameters on the horizontal and on the vertical axis. Boundaries along the second are
        vertical bars, those along the first horizontal ones. Boundaries along another parameter, or
        without an interval, are left out.
    aside : float
        Shift of the bars from their position, in points of print. Several bars at one position
        stand side by side.
    """
    counts: Counter[tuple[str, str, float]] = Counter()
    for label, look, bars in _kinds(boundaries, plane):
        style: dict[str, Any] = {
            "color": look.colour,
            "marker": look.marker,
            "markerfacecolor": "white",
        }
        for bar in bars.to_dict("records"):
            upright = bar["along"] == plane[1]
            place = bar[plane[0] if upright else plane[1]]
            middle, half = (bar["low"] + bar["high"]) / 2, (bar["high"] - bar["low"]) / 2
            x, y, lengths = (place, middle, "yerr") if upright else (middle, place, "xerr")
            drawn = axes.errorbar(
                x,
                y,
                **{lengths: half},
                **style,
                elinewidth=2.2,
                capsize=3.5,
                capthick=1.4,
                zorder=4,
            )
            key = (bar["of"], bar["along"], place)
            # Flat bars need no more room than a marker.
            shift = (aside if upright else min(aside, 1.5 * BAR_PITCH)) + BAR_PITCH * counts[key]
            move_aside(axes, drawn.get_children(), **{"x" if upright else "y": shift})
            counts[key] += 1
        axes.plot([], [], **style, linewidth=2.2, label=escape_label(label))


def _kinds(
    boundaries: pd.DataFrame, plane: Sequence[str]
) -> list[tuple[str, CurveStyle, pd.DataFrame]]:
    """Return legend entry, style and rows of each kind of boundary in a plane."""
    intervals = boundaries[boundaries["along"].isin(plane) & boundaries["low"].notna()]
    if intervals.empty:
        return []
    fields = [name for name in _parameter_names(intervals) if name not in plane]
    kinds: list[tuple[str, CurveStyle, pd.DataFrame]] = []
    for names, bars in split_curves(intervals, "along", ("of",), fields):
        text, look = BOUNDARIES[names.pop("of")]
        if any(look == other for _, other, _ in kinds):
            look = cycle_style(len(kinds))
        label = text + _settings_suffix(bars["system"].iloc[0], names)
        kinds.append((label, look, bars))
    return kinds


def _parameter_names(boundaries: pd.DataFrame) -> list[str]:
    """Return the columns of the table that are parameters of the systems of its boundaries."""
    names = (name for system in set(boundaries["system"]) for name in SYSTEMS[system].model_fields)
    return sorted({name for name in names if name in boundaries})


def _settings_suffix(system: str, names: dict[str, Any]) -> str:
    return "".join(f", {setting(system, name, value)}" for name, value in names.items())


def boundary_sentences(boundaries: pd.DataFrame, plane: Sequence[str]) -> list[str]:
    """Return what the bars are; and which boundaries have no interval or exceed the tolerance."""
    in_plane = boundaries[boundaries["along"].isin(plane)]
    if in_plane.empty:
        return [""]
    notes = {
        "wide": "wider than asked for, as undecided or contradictory points lie in between",
        "none": "not within the range searched",
        "several": "not a single one, the same side lying at both ends of the range",
        "open": "unknown, no decided points lying on two sides",
    }
    parts = []
    for verdict, text in notes.items():
        rows = in_plane[in_plane["verdict"] == verdict]
        missing = "; ".join(_missing_names(rows, in_plane))
        if len(rows):
            parts.append(f"{len(rows)} {text}" + (f" ({missing})" if missing else ""))
    kinds = "; ".join(f"{label} ({len(bars)})" for label, _, bars in _kinds(boundaries, plane))
    found = int(in_plane["low"].notna().sum())
    return [
        f"Bars: intervals that hold a boundary, {found} of {len(in_plane)} looked for.",
        f"Boundaries: {'; '.join(parts)}." if parts else "",
        f"Boundaries shown: {kinds}." if kinds else "",
    ]


def _missing_names(rows: pd.DataFrame, boundaries: pd.DataFrame) -> list[str]:
    """Return names of the boundaries without an interval, with the parameters that differ."""
    varied = varying_parameters(boundaries, _parameter_names(boundaries))
    names = [
        BOUNDARIES[row["of"]][0]
        + _settings_suffix(row["system"], {key: row[key] for key in varied if key != row["along"]})
        for row in rows[rows["low"].isna()].to_dict("records")
    ]
    return list(dict.fromkeys(names))


def boundary_notes(data: FigureData) -> list[str]:
    """Return the notes on the boundaries in the plane of a figure."""
    return boundary_sentences(data.boundaries, data.spec.axes)
