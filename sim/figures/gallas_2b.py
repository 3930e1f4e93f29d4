"""Gallas et al. (1992), Fig. 2b: number density above the belt for several angles of vibration."""

from sim.figures import belt_profiles

NAMED = belt_profiles.NAMED
LEAD = (
    "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt "
    "in mean diameters ⟨d⟩, for several angles α of the vibration (the paper's caption has π "
    "for the dotted line, which is read as π/2, a vertical vibration)."
)
PAPER = (
    "The paper: the curves of all angles collapse within their statistical errors, as the "
    "vertical vibration alone determines the density."
)

draw, table, notes = belt_profiles.panel(
    belt_profiles.DENSITY, ("vibration_angle",), belt_profiles.by_angle
)
