"""Gallas et al. (1992), Fig. 1c: transport velocity against the shear friction coefficient."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import LONG_DASH, CurveStyle, cycled
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the shear friction coefficient γ_s, "
    "for several frequencies f of the belt."
)
PAPER = "The paper: the flux rises rapidly up to γ_s = 10g and only gently from there on."

_STYLES = {
    50.0: CurveStyle("#000000", "-", "o"),
    20.0: CurveStyle("#0072b2", LONG_DASH, "s"),
}


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = transport.draw_panel(data.rows, "shear_damping", ("frequency",), look)
    axes.set_xlabel("shear friction coefficient $γ_s$ (g)")
    return figure


def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    """Return style and legend entry of a curve."""
    frequency = names["frequency"]
    return _STYLES.get(frequency, cycled(index + len(_STYLES))), f"f = {frequency:g} Hz"
