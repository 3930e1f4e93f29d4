"""Transport velocity on the belt against the stiffness of the beads."""

from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from sim.figures import transport
from sim.figures.style import LONG_DASH, SHORT_DASH, CurveStyle
from sim.figures.summary import FigureData

NAMED = ("frequency", *transport.NAMED)
LEAD = (
    "Transport velocity V_x of the beads against their stiffness Y, in units of g⟨m⟩/⟨d⟩, for "
    "several frequencies f of the belt."
)
PAPER = "The paper: above Y = 500 g⟨m⟩/⟨d⟩ the stiffness has only a weak influence."

_LOOK = transport.by_frequency(
    {
        80.0: CurveStyle("#000000", "-", "o"),
        50.0: CurveStyle("#d55e00", SHORT_DASH, "^"),
        20.0: CurveStyle("#0072b2", LONG_DASH, "s"),
    }
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = transport.draw_panel(data.rows, "stiffness", ("frequency",), _LOOK)
    axes.set_xscale("log")
    axes.set_xlim(0.8 * data.rows["stiffness"].min(), 1.25 * data.rows["stiffness"].max())
    axes.xaxis.set_major_locator(FixedLocator(sorted(set(data.rows["stiffness"]))))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("stiffness Y (g⟨m⟩/⟨d⟩)")
    return figure
