"""Gallas et al. (1992), Fig. 2a: number density above the belt for several frequencies."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import belt_profiles
from sim.figures.belt_profiles import DENSITY
from sim.figures.summary import FigureData

NAMED = belt_profiles.NAMED
LEAD = (
    "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt "
    "in mean diameters ⟨d⟩, for several frequencies f."
)
PAPER = (
    "The paper: at low frequency the density has a plateau that ends almost abruptly near z = "
    "9⟨d⟩; with frequency its maximum falls, the profile smears out and a gas-like tail "
    "appears above the bed; close to the belt the density is very small."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    return belt_profiles.draw_panel(data, DENSITY, ("frequency",), belt_profiles.by_frequency)


def table(data: FigureData) -> pd.DataFrame:
    """Return the profiles."""
    return belt_profiles.table(data, DENSITY)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    return belt_profiles.notes(data, DENSITY)
