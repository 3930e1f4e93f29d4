"""Gallas et al. (1992), Fig. 2c: number density above the belt for several damping coefficients."""

from sim.figures import belt_profiles

NAMED = belt_profiles.NAMED
LEAD = (
    "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt "
    "in mean diameters ⟨d⟩, for several damping coefficients (γ, γ_s)."
)
PAPER = (
    "The paper: with less friction the layer is more smeared out; only very close to the belt "
    "the profiles do not depend on friction."
)

draw, table, notes = belt_profiles.panel(
    belt_profiles.DENSITY, ("damping", "shear_damping"), belt_profiles.by_damping
)
