"""Regimes of chute flows over depth and friction coefficient, with the boundaries found."""

from math import radians, tan

import pandas as pd
from matplotlib.figure import Figure

from sim.figures.regime_map import THEORY, draw_map
from sim.figures.style import place_legend

LEAD = (
    "Regimes of monodisperse spheres on a frictional inclined plane over the friction coefficient "
    "μ and the depth n = N/σ² of the flow: one marker per point, boundaries between regimes as "
    "bars joined by lines, and μ = tan θ, below which friction cannot hold the weight (dotted)."
)
NAMED = (
    "angle",
    "restitution",
    "stiffness",
    "cell",
    "transient",
    "average",
)


def draw(rows: pd.DataFrame, found: pd.DataFrame) -> Figure:
    """Draw the figure from its points and boundaries, see `sim.figures.regime_map.draw_map`."""
    figure, axes = draw_map(rows, found, "friction")
    for angle in sorted(set(rows["angle"])):
        axes.axhline(tan(radians(angle)), label=f"μ = tan θ, θ = {angle:g}°", **THEORY)
    axes.set_ylabel("friction coefficient μ")
    place_legend(figure, axes)
    return figure
