"""What the figures of regimes share: markers of points, and boundaries as bars."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from sim.figures.style import DASHES, CurveStyle, canvas, cycled, move_aside
from sim.figures.summary import split_curves, varying
from sim.parameters import SYSTEMS
from sim.parameters.wording import setting

#: Flows slower than this (√(gσ)) that are not at rest are said to creep.
CREEP = 0.1
CREEPING = f"creeps: |V| < {CREEP:g} √(gσ)"

#: What captions say of creeping flows.
CREEP_SENTENCE = (
    f"Flows that move, but slower than {CREEP:g} √(gσ), have a marker of their own, whatever their "
    "regime."
)

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

#: What the boundaries are called in legends, and how their bars look where nothing tells several
#: of a kind apart.
BOUNDARIES = {
    "flow": ("limit of arrest", CurveStyle("#009e73", "-", "")),
    "acceleration": ("limit of acceleration", CurveStyle("#cc79a7", "-", "")),
    "transport": ("onset of transport", CurveStyle("#000000", "-", "o")),
}

THEORY = {"color": "#444444", "linestyle": DASHES[3], "linewidth": 1.3, "zorder": 2}

#: Points of print between bars in one place.
_PITCH = 5.0


def draw_map(rows: pd.DataFrame, found: pd.DataFrame, y: str) -> tuple[Figure, Axes]:
    """Draw the regimes of chute flows over depth and another parameter.

    Parameters
    ----------
    rows : pandas.DataFrame
        Points, as `sim.figures.summary.summarize` returns them.
    found : pandas.DataFrame
        Boundaries, as `sim.dataset.boundaries.table` returns them.
    y : str
        Parameter on the vertical axis.
    """
    figure, axes = canvas(height=4.3)
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
    draw_boundaries(axes, found, ("depth", y), aside=1.5 * _PITCH)
    axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("depth n (particles per σ²)")
    return figure, axes


def creeping(rows: pd.DataFrame) -> pd.Series:
    """Return which points of the chute move, but slower than `CREEP`, whatever their trend is."""
    slow = rows["velocity"].abs() < CREEP * np.sqrt(rows["gravity"] * rows["diameter"])
    return slow & ~rows["regime"].isin(("arrested", "failed"))


def draw_boundaries(
    axes: Axes, found: pd.DataFrame, plane: tuple[str, str], aside: float = 0
) -> None:
    """Draw the intervals that hold a boundary as bars; markers in their middles tell kinds apart.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    found : pandas.DataFrame
        Boundaries, as `sim.dataset.boundaries.table` returns them.
    plane : tuple of str
        Parameters on the horizontal and on the vertical axis. Boundaries along the second are
        vertical bars, those along the first horizontal ones; what is along another parameter, or
        was not found in its range, is left out.
    aside : float
        How far beside their place bars stand, in points of print; several in one place stand side
        by side.
    """
    taken: Counter[tuple[str, str, float]] = Counter()
    for label, look, bars in _kinds(found, plane):
        style = {"color": look.colour, "marker": look.marker, "markerfacecolor": "white"}
        for bar in bars.to_dict("records"):
            upright = bar["along"] == plane[1]
            place = bar[plane[0] if upright else plane[1]]
            middle, half = (bar["low"] + bar["high"]) / 2, (bar["high"] - bar["low"]) / 2
            drawn = axes.errorbar(
                *((place, middle) if upright else (middle, place)),
                **{"yerr" if upright else "xerr": half},
                **style,
                elinewidth=2.2,
                capsize=3.5,
                capthick=1.4,
                zorder=4,
            )
            before = (bar["of"], bar["along"], place)
            shift = aside + _PITCH * taken[before]
            move_aside(axes, drawn.get_children(), **{"x" if upright else "y": shift})
            taken[before] += 1
        axes.plot([], [], **style, linewidth=2.2, label=label)


def _kinds(found: pd.DataFrame, plane: Sequence[str]) -> list[tuple[str, CurveStyle, pd.DataFrame]]:
    """Return what to tell apart among the intervals in a plane: name, look, rows of each kind."""
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


def _described(system: str, names: dict[str, object]) -> str:
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
    shown = "; ".join(f"{label} ({len(bars)})" for label, _, bars in _kinds(found, plane))
    return (
        f"Bars: intervals that hold a boundary, of {len(part)} looked for"
        + (": " if parts else "")
        + "; ".join(parts)
        + "."
        + (f" Shown: {shown}." if shown else "")
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
