"""Gallas et al. (1992), Fig. 3c: velocity above the belt for several damping coefficients."""

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import belt_profiles
from sim.figures.belt_profiles import VELOCITY
from sim.figures.summary import FigureData

NAMED = (*belt_profiles.NAMED, "initial_velocity")
LEAD = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several damping coefficients (γ, γ_s); dashed: all beads start at a "
    "higher speed than they end up with."
)
PAPER = (
    "The paper: from γ_s = 50g on the profile depends only weakly on γ_s; the fall at great "
    "heights is unfinished relaxation and disappears after a start at a higher speed "
    "(dashed)."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    return belt_profiles.draw_panel(
        data, VELOCITY, ("damping", "shear_damping", "initial_velocity"), belt_profiles.by_damping
    )


def table(data: FigureData) -> pd.DataFrame:
    """Return the profiles."""
    return belt_profiles.table(data, VELOCITY)


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    return belt_profiles.notes(data, VELOCITY)
