"""Gallas et al. (1992), Fig. 2c: number density above the belt for several damping coefficients."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import belt_profiles
from sim.figures.belt_profiles import DENSITY
from sim.figures.summary import FigureData

NAMED = belt_profiles.NAMED
LEAD = (
    "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt "
    "in mean diameters ⟨d⟩, for several damping coefficients (γ, γ_s)."
)
PAPER = (
    "The paper: with less friction the layer is more smeared out; only very close to the belt "
    "the profiles do not depend on friction."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    return belt_profiles.draw_panel(
        data, DENSITY, ("damping", "shear_damping"), belt_profiles.by_damping
    )


def table(data: FigureData) -> pd.DataFrame:
    """Return the profiles."""
    return belt_profiles.table(data, DENSITY)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    return belt_profiles.notes(data, DENSITY)
