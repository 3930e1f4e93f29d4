"""Height of the shearing layer against depth, for several restitutions and stiffnesses."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures.measures import measure_notes as notes
from sim.figures.measures import measure_table, measured
from sim.figures.over_depth import APART, JOINED, NAMED, draw_curves, set_depth_axis
from sim.figures.style import canvas, mark_cut_bars, place_legend
from sim.figures.summary import FigureData

__all__ = ["LEAD", "NAMED", "PAPER", "draw", "notes", "table"]

LEAD = (
    "Height δ_s of the shearing layer, in diameters σ, against the depth n = N/σ² of the flow for "
    "several coefficients of restitution e and stiffnesses K1. δ_s is where the time-averaged "
    "velocity reaches 90 % of that at the surface. "
    f"{JOINED} {APART}"
)
PAPER = (
    "The paper: more elastic spheres have a deeper shearing layer (Fig. 2); the thickness of the "
    "layer tends to decrease as the flows get deeper; spheres stiffer by one or two orders of "
    "magnitude have a significantly deeper one in flows deeper than 10 per σ², while flows of less "
    "than 5 per σ² hardly depend on the stiffness."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    rows = _heights(data)
    draw_curves(axes, rows, ("restitution", "stiffness"))
    set_depth_axis(axes, data.rows["depth"])
    # Intervals over two replicates may be wider than all the heights.
    highest = rows["velocity"].max()
    axes.set_ylim(0, min(axes.get_ylim()[1], 1.5 * highest) if highest > 0 else 1)
    mark_cut_bars(axes)
    axes.set_ylabel("height of the shearing layer $δ_s$ (σ)")
    place_legend(figure, axes)
    return figure


def _heights(data: FigureData) -> pd.DataFrame:
    return measured(data, "shear_depth", "diameter")


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    names = ("depth", *NAMED, "protocol")
    return measure_table(data, names, {"height of the shearing layer [σ]": _heights(data)})
