"""Gallas et al. (1992), Fig. 3b: velocity above the belt for several angles of vibration."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import belt_profiles
from sim.figures.belt_profiles import VELOCITY
from sim.figures.summary import FigureData

NAMED = belt_profiles.NAMED
LEAD = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several angles α of the vibration (the paper's caption has π for the "
    "dotted line, which is read as π/2, a vertical vibration)."
)
PAPER = "The paper: the plateau is higher the smaller the angle of vibration."


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    return belt_profiles.draw_panel(data, VELOCITY, ("vibration_angle",), belt_profiles.by_angle)


def table(data: FigureData) -> pd.DataFrame:
    """Return the profiles."""
    return belt_profiles.table(data, VELOCITY)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    return belt_profiles.notes(data, VELOCITY)
