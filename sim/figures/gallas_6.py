"""Gallas et al. (1992), Fig. 6: transport velocity against the diameter of an obstacle."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import LONG_DASH, CurveStyle
from sim.figures.summary import FigureData

NAMED = ("frequency", *transport.NAMED)
LEAD = (
    "Transport velocity V_x of the beads against the diameter d_o of a fixed circular obstacle in "
    "the middle of the cell at the height A_z above the average belt, for several frequencies f."
)
PAPER = "The paper: even a rather small obstacle rapidly slows down the flow."

_LOOK = transport.by_frequency(
    {
        80.0: CurveStyle("#000000", "-", "o"),
        20.0: CurveStyle("#0072b2", LONG_DASH, "s"),
    }
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = transport.draw_panel(data.rows, "obstacle", ("frequency",), _LOOK)
    axes.set_xlabel("diameter of the obstacle $d_o$ (⟨d⟩)")
    return figure
