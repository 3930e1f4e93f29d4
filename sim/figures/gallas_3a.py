"""Gallas et al. (1992), Fig. 3a: velocity above the belt for several frequencies."""

from sim.figures import belt_profiles

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

draw, table, notes = belt_profiles.panel(
    belt_profiles.VELOCITY, ("frequency",), belt_profiles.by_frequency
)
