"""Gallas et al. (1992), Fig. 3b: velocity above the belt for several angles of vibration."""

from sim.figures import belt_profiles

NAMED = belt_profiles.NAMED
LEAD = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several angles α of the vibration (the paper's caption has π for the "
    "dotted line, which is read as π/2, a vertical vibration)."
)
PAPER = "The paper: the plateau is higher the smaller the angle of vibration."

draw, table, notes = belt_profiles.panel(
    belt_profiles.VELOCITY, ("vibration_angle",), belt_profiles.by_angle
)
