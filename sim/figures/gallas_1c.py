"""Gallas et al. (1992), Fig. 1c: transport velocity against the shear friction coefficient."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the shear friction coefficient γ_s, "
    "for several frequencies f of the belt."
)
PAPER = "The paper: the flux rises rapidly up to γ_s = 10g and only gently from there on."


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    look = transport.AGAINST_FRICTION
    figure, axes = transport.draw_panel(data.rows, "shear_damping", ("frequency",), look)
    axes.set_xlabel("shear friction coefficient $γ_s$ (g)")
    return figure
