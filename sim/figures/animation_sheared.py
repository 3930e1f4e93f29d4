"""Animation: a flow of medium depth."""

from sim.figures import moving_chute

LEAD = moving_chute.lead("A flow of medium depth")
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: shallow flows usually have a velocity that rises monotonically up to the surface."
)

draw, select, notes = moving_chute.draw, moving_chute.select, moving_chute.notes
