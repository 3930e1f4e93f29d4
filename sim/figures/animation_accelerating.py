"""Animation: spheres whose friction coefficient is less than tan θ."""

from sim.figures import moving_chute

LEAD = moving_chute.lead("Spheres whose friction coefficient is less than tan θ")
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: a flow accelerates without bound wherever the friction coefficient is less than "
    "the tangent of the inclination."
)

draw, select, notes = moving_chute.draw, moving_chute.select, moving_chute.notes
