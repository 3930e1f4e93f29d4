"""What the figures of regimes share: markers of points, and boundaries as bars joined by lines."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from sim.figures.style import DASHES, canvas
from sim.figures.summary import split_curves
from sim.parameters import SYSTEMS
from sim.wording import setting

#: Marker, colour and whether it is filled, of the regimes in the order of the legend.
MARKS = {
    "steady": ("o", "#0072b2", True),
    "accelerating": ("^", "#d55e00", True),
    "arrested": ("s", "#000000", True),
    "undetermined": ("D", "#666666", False),
    "mixed": ("p", "#666666", False),
    "failed": ("x", "#666666", True),
}

#: What the boundaries are called in legends, their colours and their first dash patterns.
BOUNDARIES = {
    "flow": ("limit of arrest", "#009e73", 1),
    "acceleration": ("limit of acceleration", "#cc79a7", 0),
    "transport": ("onset of transport", "#0072b2", 0),
}

#: Dash patterns of boundaries; dotted lines are those that theory gives.
UNDOTTED = DASHES[:3]
THEORY = {"color": "#444444", "linestyle": DASHES[3], "linewidth": 1.3, "zorder": 2}


def draw_map(rows: pd.DataFrame, found: pd.DataFrame, y: str) -> tuple[Figure, Axes]:
    """Draw the regimes of chute flows over depth and another parameter.

    Parameters
    ----------
    rows : pandas.DataFrame
        Points, as `sim.figures.summary.summarize` returns them.
    found : pandas.DataFrame
        Boundaries, as `sim.regime_boundaries.table` returns them.
    y : str
        Parameter on the vertical axis.
    """
    figure, axes = canvas(height=4.3)
    for regime, (marker, colour, filled) in MARKS.items():
        part = rows[rows["regime"] == regime]
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
    draw_boundaries(axes, found, "depth", y)
    axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("depth n (particles per σ²)")
    return figure, axes


def draw_boundaries(axes: Axes, found: pd.DataFrame, x: str, y: str) -> None:
    """Draw the intervals that hold a boundary as bars, their middles joined by a line.

    Boundaries along ``y`` are vertical bars, those along ``x`` horizontal ones; what is along
    another parameter, or was not found in its range, is left out.
    """
    dashes: dict[str, object] = {}
    for along, across in ((y, x), (x, y)):
        known = found[(found["along"] == along) & found["low"].notna()]
        fields = [name for name in _numbers(known) if name not in (x, y)]
        for names, curve in split_curves(known, across, ("of",), fields) if len(known) else []:
            text, colour, first = BOUNDARIES[names.pop("of")]
            label = text + _described(curve["system"].iloc[0], names)
            new = label not in dashes
            alike = sum(other.startswith(text) for other in dashes)
            pattern = dashes.setdefault(label, UNDOTTED[(first + alike) % len(UNDOTTED)])
            style = {"color": colour, "linestyle": pattern, "zorder": 4}
            middle, half = (curve["low"] + curve["high"]) / 2, (curve["high"] - curve["low"]) / 2
            places = (curve[across], middle) if along == y else (middle, curve[across])
            errors = {"yerr" if along == y else "xerr": half}
            axes.errorbar(*places, **errors, **style, elinewidth=2.2, capsize=3.5, capthick=1.4)
            axes.plot([], [], label=label if new else None, **style)


def _numbers(found: pd.DataFrame) -> list[str]:
    """Return the parameters in the table that the systems of its boundaries have."""
    names = (name for system in set(found["system"]) for name in SYSTEMS[system].model_fields)
    return sorted({name for name in names if name in found})


def _described(system: str, names: dict[str, object]) -> str:
    return "".join(f", {setting(system, name, value)}" for name, value in names.items())


def boundary_sentence(found: pd.DataFrame, axes: Sequence[str]) -> str:
    """Say what the bars are and how many boundaries were not found, or not to the tolerance."""
    part = found[found["along"].isin(axes)]
    if part.empty:
        return ""
    notes = {
        "wide": "wider than asked for, as undecided or contradictory points lie in between",
        "none": "not within the range searched",
        "several": "not a single one, the same side lying at both ends of the range",
        "open": "unknown, no point being decided",
    }
    counts = part["verdict"].value_counts()
    parts = [f"{counts[verdict]} {text}" for verdict, text in notes.items() if verdict in counts]
    return (
        f"Bars: intervals that hold a boundary, of {len(part)} looked for"
        + (": " if parts else "")
        + "; ".join(parts)
        + "."
    )
