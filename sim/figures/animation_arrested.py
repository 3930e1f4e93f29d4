"""Animation: spheres whose friction coefficient is more than twice tan θ."""

from sim.figures import moving_chute

LEAD = moving_chute.lead("Spheres whose friction coefficient is more than twice tan θ")
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: friction coefficients that greatly exceed tan θ, by more than a factor of two, "
    "arrest the flow."
)

draw, select, notes = moving_chute.draw, moving_chute.select, moving_chute.notes
