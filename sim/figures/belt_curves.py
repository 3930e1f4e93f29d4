"""Transport velocity of the belt's beads over a parameter, in one panel or one per protocol.

Options of a figure: those of `sim.figures.looks`; ``log``, the logarithmic axes, x alone.
"""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from sim.figures.curves import draw_family
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.looks import look_of
from sim.figures.quantity import Quantity, velocity
from sim.figures.style import canvas, place_legend
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
    rows, spec = data.rows, data.spec
    if "protocol" in spec.axes:
        return _draw_protocols(rows, spec)
    figure, axes = canvas()
    draw_curves(axes, rows, velocity(rows), spec)
    place_legend(figure, axes)
    if "x" in spec.options.get("log", ()):
        _set_log_axis(axes, rows[spec.axes[0]])
    return figure


def _draw_protocols(rows: pd.DataFrame, spec: FigureSpec) -> Figure:
    figure = Figure(figsize=(8.0, 3.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, protocol in zip(panels, ("published", "converged"), strict=True):
        part = rows[rows["protocol"] == protocol]
        draw_curves(axes, part, velocity(part), spec)
        axes.set_title(f"{protocol} protocol", fontsize=9)
        axes.label_outer()
    place_legend(figure, panels[0])
    return figure


def draw_curves(axes: Axes, rows: pd.DataFrame, quantity: Quantity, spec: FigureSpec) -> None:
    """Draw a quantity of the belt over the first axis of a figure, with a line at zero."""
    along, names = spec.axes[0], tuple(BeltParameters.model_fields)
    draw_family(axes, rows, quantity, along, spec.curves, names, look=look_of(spec))
    axes.axhline(0, color="#888888", linewidth=0.7, zorder=1)
    axes.set_xlim(left=-0.02 * rows[along].max())
    axes.set_ylabel("transport velocity $V_x$ (m/s)")
    axes.set_xlabel(axis_label(along))


def axis_label(parameter: str) -> str:
    """Return the label of an axis along a parameter of the belt."""
    return _LABELS.get(parameter, parameter)


def _set_log_axis(axes: Axes, values: pd.Series) -> None:
    """Make the horizontal axis logarithmic, with a number at each value."""
    axes.set_xscale("log")
    axes.set_xlim(0.8 * values.min(), 1.25 * values.max())
    axes.xaxis.set_major_locator(FixedLocator(sorted(set(values))))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")


KIND = Kind(draw)
