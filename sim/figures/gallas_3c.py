"""Gallas et al. (1992), Fig. 3c: velocity above the belt for several damping coefficients."""

from sim.figures import belt_profiles

NAMED = (*belt_profiles.NAMED, "initial_velocity")
LEAD = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several damping coefficients (γ, γ_s); fast start, dashed: all beads begin "
    "with a higher speed than they end up with."
)
PAPER = (
    "The paper: from γ_s = 50g on the profile depends only weakly on γ_s; the fall at great "
    "heights is unfinished relaxation and disappears after a start at a higher speed "
    "(dashed)."
)

_KEYS = ("damping", "shear_damping", "initial_velocity")

draw, table, notes = belt_profiles.panel(belt_profiles.VELOCITY, _KEYS, belt_profiles.by_damping)
