"""Gallas et al. (1992), Fig. 3a: velocity above the belt for several frequencies."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import belt_profiles
from sim.figures.belt_profiles import VELOCITY
from sim.figures.summary import FigureData

NAMED = belt_profiles.NAMED
LEAD = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several frequencies f."
)
PAPER = (
    "The paper: almost all beads move at the same speed, a plateau that grows with frequency; "
    "the velocity is smaller right at the belt and at great heights, where a steady state may "
    "not have been reached."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    return belt_profiles.draw_panel(data, VELOCITY, ("frequency",), belt_profiles.by_frequency)


def table(data: FigureData) -> pd.DataFrame:
    """Return the profiles."""
    return belt_profiles.table(data, VELOCITY)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    return belt_profiles.notes(data, VELOCITY)
