"""Gallas et al. (1992), Fig. 1c under the published and under the converged protocol."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import place_legend
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the shear friction coefficient γ_s, for several "
    "frequencies f of the belt: left from runs of the published length, right from runs that go on "
    "until the mean velocity has converged. Where the panels differ, runs of the published length "
    "are too short."
)
PAPER = "The paper: the flux rises rapidly up to γ_s = 10g and only gently from there on."


def draw(data: FigureData) -> Figure:
    """Draw the figure: a panel per protocol, with common axes."""
    figure = Figure(figsize=(8.0, 3.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    look = transport.AGAINST_FRICTION
    for axes, protocol in zip(panels, ("published", "converged"), strict=True):
        rows = data.rows[data.rows["protocol"] == protocol]
        transport.draw_curves(axes, rows, "shear_damping", ("frequency",), look)
        axes.set_xlabel("shear friction coefficient $γ_s$ (g)")
        axes.set_title(f"{protocol} protocol", fontsize=9)
        axes.label_outer()
    place_legend(figure, panels[0])
    return figure
