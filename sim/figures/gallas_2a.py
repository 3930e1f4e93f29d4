"""Gallas et al. (1992), Fig. 2a: number density above the belt for several frequencies."""

from sim.figures import belt_profiles

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

draw, table, notes = belt_profiles.panel(
    belt_profiles.DENSITY, ("frequency",), belt_profiles.by_frequency
)
