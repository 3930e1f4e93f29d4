"""Regimes of chute flows over depth and inclination, with the boundaries found."""

from math import atan, degrees

from matplotlib.figure import Figure

from sim.figures.regime_map import CREEP_SENTENCE, THEORY, draw_map
from sim.figures.style import place_legend
from sim.figures.summary import FigureData

LEAD = (
    "Regimes of monodisperse spheres on a frictional inclined plane over the inclination θ and the "
    "depth n = N/σ² of the flow: one marker per point, boundaries between regimes as bars beside "
    "the points, and tan θ = μ, above which friction cannot hold the weight (dotted). "
    f"{CREEP_SENTENCE}"
)
NAMED = (
    "friction",
    "restitution",
    "stiffness",
    "cell",
    "transient",
    "average",
)
PAPER = (
    "The paper expects a significant range of inclinations with steady flows for a given set of "
    "properties, and leaves it to further work."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = draw_map(rows, data.boundaries, "angle")
    for friction in sorted(set(rows["friction"])):
        axes.axhline(degrees(atan(friction)), label=f"tan θ = μ = {friction:g}", **THEORY)
    axes.set_ylabel("inclination θ (degrees)")
    place_legend(figure, axes)
    return figure
