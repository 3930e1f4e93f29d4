"""What the three panels of Gallas' Fig. 1 share: one curve per set of parameters of the belt."""

from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.family import Look, draw_family
from sim.figures.style import (
    DASH_DOT,
    LONG_DASH,
    SHORT_DASH,
    CurveStyle,
    canvas,
    cycled,
    place_legend,
)
from sim.parameters import BeltParameters
from sim.parameters.wording import setting

#: Parameters that the captions of all three panels give.
NAMED = (
    "vibration_angle",
    "amplitude",
    "damping",
    "shear_damping",
    "beads",
    "width",
    "transient",
    "average",
)


#: Fig. 1b, and wherever else amplitudes are told apart.
AMPLITUDES = {
    1.5: CurveStyle("#d55e00", DASH_DOT),
    1.0: CurveStyle("#000000", "-"),
    0.5: CurveStyle("#0072b2", SHORT_DASH),
}


def draw_panel(
    rows: pd.DataFrame,
    along: str,
    keys: Sequence[str],
    look: Look,
) -> tuple[Figure, Axes]:
    """Draw transport velocity against one parameter.

    Parameters
    ----------
    rows : pandas.DataFrame
        Points, as `sim.figures.summary.summarize` returns them.
    along : str
        Parameter on the horizontal axis.
    keys : sequence of str
        Parameters that name a curve.
    look : callable
        Gives style and legend entry from the values of the keys and the number of the curve.
    """
    figure, axes = canvas()
    draw_curves(axes, rows, along, keys, look)
    place_legend(figure, axes)
    return figure, axes


def draw_curves(
    axes: Axes, rows: pd.DataFrame, along: str, keys: Sequence[str], look: Look
) -> None:
    """Draw the curves of a panel, see `draw_panel`."""

    def look_and_extra(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, label = look(names, index)
        return style, label + describe({name: names[name] for name in names if name not in keys})

    draw_family(axes, rows, along, keys, tuple(BeltParameters.model_fields), look_and_extra)
    axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
    axes.set_xlim(left=-0.02 * rows[along].max())
    axes.set_ylabel("transport velocity $V_x$ (m/s)")


def describe(names: dict[str, object]) -> str:
    """Spell out further parameters of a curve for its entry in the legend."""
    return "".join(f", {setting('belt', name, value)}" for name, value in names.items())


def by_frequency(styles: Mapping[float, CurveStyle]) -> Look:
    """Return how curves look that differ in frequency, given the styles of the paper's."""

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        frequency = names["frequency"]
        return styles.get(frequency, cycled(index + len(styles))), f"f = {frequency:g} Hz"

    return look


#: Fig. 1c: 50 Hz solid, 20 Hz dashed.
AGAINST_FRICTION = by_frequency(
    {
        50.0: CurveStyle("#000000", "-", "o"),
        20.0: CurveStyle("#0072b2", LONG_DASH, "s"),
    }
)


def pair(damping: float, shear_damping: float) -> str:
    """Write both damping coefficients for an entry in the legend: ``(γ, γ_s) = (0, 50g)``."""
    values = (f"{value:g}g" if value else "0" for value in (damping, shear_damping))
    return f"(γ, γ$_s$) = ({', '.join(values)})"
