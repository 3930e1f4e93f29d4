"""Boundaries between regimes as bars, and what captions say of them."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from sim.figures.data import FigureData, split_curves, varying
from sim.figures.style import CurveStyle, cycled, literal, move_aside
from sim.parameters import SYSTEMS
from sim.parameters.words import setting

#: What the boundaries are called in legends, and how their bars look where nothing tells several
#: of a kind apart.
BOUNDARIES = {
    "flow": ("limit of arrest", CurveStyle("#009e73", "-", "")),
    "acceleration": ("limit of acceleration", CurveStyle("#cc79a7", "-", "")),
    "transport": ("onset of transport", CurveStyle("#000000", "-", "o")),
}

#: Points of print between bars in one place.
PITCH = 5.0


def draw_boundaries(
    axes: Axes, found: pd.DataFrame, plane: Sequence[str], aside: float = 0
) -> None:
    """Draw the intervals that hold a boundary as bars; markers in their middles tell kinds apart.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    found : pandas.DataFrame
        Boundaries, as `sim.dataset.boundaries.table` returns them.
    plane : sequence of str
        Parameters on the horizontal and on the vertical axis. Boundaries along the second are
        vertical bars, those along the first horizontal ones; what is along another parameter, or
        was not found in its range, is left out.
    aside : float
        How far beside their place bars stand, in points of print; several in one place stand side
        by side.
    """
    taken: Counter[tuple[str, str, float]] = Counter()
    for label, look, bars in _kinds(found, plane):
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
            before = (bar["of"], bar["along"], place)
            shift = aside + PITCH * taken[before]
            move_aside(axes, drawn.get_children(), **{"x" if upright else "y": shift})
            taken[before] += 1
        axes.plot([], [], **style, linewidth=2.2, label=literal(label))


def _kinds(found: pd.DataFrame, plane: Sequence[str]) -> list[tuple[str, CurveStyle, pd.DataFrame]]:
    """Return the kinds of boundaries in a plane: legend entry, style and rows of each."""
    known = found[found["along"].isin(plane) & found["low"].notna()]
    if known.empty:
        return []
    fields = [name for name in _numbers(known) if name not in plane]
    kinds: list[tuple[str, CurveStyle, pd.DataFrame]] = []
    for names, bars in split_curves(known, "along", ("of",), fields):
        text, look = BOUNDARIES[names.pop("of")]
        if any(look == other for _, other, _ in kinds):
            look = cycled(len(kinds))
        label = text + _described(bars["system"].iloc[0], names)
        kinds.append((label, look, bars))
    return kinds


def _numbers(found: pd.DataFrame) -> list[str]:
    """Return the parameters in the table that the systems of its boundaries have."""
    names = (name for system in set(found["system"]) for name in SYSTEMS[system].model_fields)
    return sorted({name for name in names if name in found})


def _described(system: str, names: dict[str, Any]) -> str:
    return "".join(f", {setting(system, name, value)}" for name, value in names.items())


def boundary_sentence(found: pd.DataFrame, plane: Sequence[str]) -> str:
    """Say what the bars are, and which boundaries were not found, or not to the tolerance."""
    part = found[found["along"].isin(plane)]
    if part.empty:
        return ""
    notes = {
        "wide": "wider than asked for, as undecided or contradictory points lie in between",
        "none": "not within the range searched",
        "several": "not a single one, the same side lying at both ends of the range",
        "open": "unknown, no decided points lying on two sides",
    }
    parts = []
    for verdict, text in notes.items():
        rows = part[part["verdict"] == verdict]
        missing = "; ".join(_missing(rows, part))
        if len(rows):
            parts.append(f"{len(rows)} {text}" + (f" ({missing})" if missing else ""))
    kinds = "; ".join(f"{label} ({len(bars)})" for label, _, bars in _kinds(found, plane))
    return (
        f"Bars: intervals that hold a boundary, of {len(part)} looked for"
        + (": " if parts else "")
        + "; ".join(parts)
        + "."
        + (f" Shown: {kinds}." if kinds else "")
    )


def _missing(rows: pd.DataFrame, among: pd.DataFrame) -> list[str]:
    """Return the names of the boundaries without an interval, by what tells them from others."""
    varied = varying(among, _numbers(among))
    names = [
        BOUNDARIES[row["of"]][0]
        + _described(row["system"], {key: row[key] for key in varied if key != row["along"]})
        for row in rows[rows["low"].isna()].to_dict("records")
    ]
    return list(dict.fromkeys(names))


def boundary_notes(data: FigureData) -> list[str]:
    """Return what a caption says of the boundaries in the plane of a figure."""
    return [boundary_sentence(data.boundaries, data.spec.axes)]
