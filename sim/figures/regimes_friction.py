"""Regimes of chute flows over depth and friction coefficient, with the boundaries found."""

from math import radians, tan

from matplotlib.figure import Figure

from sim.figures.regime_map import CREEP_SENTENCE, THEORY, draw_map
from sim.figures.style import place_legend
from sim.figures.summary import FigureData

LEAD = (
    "Regimes of monodisperse spheres on a frictional inclined plane over the friction coefficient "
    "μ and the depth n = N/σ² of the flow: one marker per point, boundaries between regimes as "
    "bars beside the points, and μ = tan θ, below which friction cannot hold the weight (dotted). "
    f"{CREEP_SENTENCE}"
)
NAMED = (
    "angle",
    "restitution",
    "stiffness",
    "cell",
    "transient",
    "average",
)
PAPER = (
    "The paper: flows accelerate without bound wherever μ < tan θ, and at half a sphere per σ² "
    "too, as spheres then roll alone; flows with μ somewhat greater than tan θ are steady at a "
    "variety of depths; those with μ more than twice tan θ come to rest."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = draw_map(rows, data.boundaries, "friction")
    for angle in sorted(set(rows["angle"])):
        axes.axhline(tan(radians(angle)), label=f"μ = tan θ, θ = {angle:g}°", **THEORY)
    axes.set_ylabel("friction coefficient μ")
    place_legend(figure, axes)
    return figure
