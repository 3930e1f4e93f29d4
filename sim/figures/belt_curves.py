"""Velocity of the belt's beads, or measures of them, over a parameter.

Options of a figure: those of `sim.figures.looks`; ``quantities``, the measures (of the velocity,
none); ``axis``, label of the vertical axis; ``levels`` to compare with; ``log``, the logarithmic
axes, x alone.
"""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from sim.figures.curves import draw_family
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import look_of, look_of_measure
from sim.figures.quantity import Quantity, quantities, velocity
from sim.figures.style import LEVEL, canvas, place_legend
from sim.parameters import BeltParameters
from sim.study.figure_spec import FigureSpec

_LABELS = {
    "frequency": "frequency f (Hz)",
    "obstacle": "diameter of the obstacle $d_o$ (⟨d⟩)",
    "shear_damping": "shear friction coefficient $γ_s$ (g)",
    "stiffness": "stiffness Y (g⟨m⟩/⟨d⟩)",
}


def draw(data: FigureData) -> Figure:
    """Draw the figure: panels with common axes for a second axis, which is the protocol."""
    rows, spec, shown = data.rows, data.spec, quantities(data)
    if "protocol" in spec.axes:
        return _draw_protocols(rows, spec)
    figure, axes = canvas()
    if len(shown) == 1:
        _draw_curves(axes, shown[0].rows_with_value(rows), shown[0], spec)
    else:
        _draw_several(axes, rows, shown, spec)
    for level in spec.options.get("levels", ()):
        axes.axhline(level, **LEVEL)
    place_legend(figure, axes)
    if "x" in spec.options.get("log", ()):
        _set_log_axis(axes, rows[spec.axes[0]])
    return figure


def _draw_protocols(rows: pd.DataFrame, spec: FigureSpec) -> Figure:
    figure = Figure(figsize=(8.0, 3.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, protocol in zip(panels, ("published", "converged"), strict=True):
        part = rows[rows["protocol"] == protocol]
        _draw_curves(axes, part, velocity(part), spec)
        axes.set_title(f"{protocol} protocol", fontsize=9)
        axes.label_outer()
    place_legend(figure, panels[0])
    return figure


def _draw_curves(axes: Axes, rows: pd.DataFrame, quantity: Quantity, spec: FigureSpec) -> None:
    """Draw a quantity of the belt over the first axis of a figure, with a line at zero."""
    along, names = spec.axes[0], tuple(BeltParameters.model_fields)
    draw_family(axes, rows, quantity, along, spec.curves, names, look=look_of(spec))
    axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
    axes.set_xlim(left=-0.02 * rows[along].max())
    _label(axes, spec)


def _draw_several(axes: Axes, rows: pd.DataFrame, shown: list[Quantity], spec: FigureSpec) -> None:
    """Draw one curve of each of several measures, from zero on."""
    names, keys = tuple(BeltParameters.model_fields), spec.curves or ("protocol",)
    for quantity, option in zip(shown, spec.options["quantities"], strict=True):
        look = look_of_measure(spec, spec.curves, option)
        draw_family(
            axes, quantity.rows_with_value(rows), quantity, spec.axes[0], keys, names, look=look
        )
    axes.set_ylim(bottom=0)
    _label(axes, spec)


def _label(axes: Axes, spec: FigureSpec) -> None:
    axes.set_xlabel(_LABELS.get(spec.axes[0], spec.axes[0]))
    axes.set_ylabel(spec.options.get("axis", "transport velocity $V_x$ (m/s)"))


def _set_log_axis(axes: Axes, values: pd.Series) -> None:
    """Make the horizontal axis logarithmic, with a number at each value."""
    axes.set_xscale("log")
    axes.set_xlim(0.8 * values.min(), 1.25 * values.max())
    axes.xaxis.set_major_locator(FixedLocator(sorted(set(values))))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")


KIND = Kind(draw)
