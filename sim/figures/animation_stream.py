"""Animation: shaking far above the onset."""

from sim.figures import moving_belt

LEAD = moving_belt.lead("Shaking far above the onset")
NAMED = moving_belt.NAMED
PAPER = (
    "The paper: the beads move like a stream, with little vertical motion, over a belt that "
    "almost none of them touches."
)

draw, select, notes = moving_belt.draw, moving_belt.select, moving_belt.notes
