"""Animation: shaking below the onset."""

from sim.figures import moving_belt

LEAD = moving_belt.lead("Shaking below the onset")
NAMED = moving_belt.NAMED
PAPER = (
    "The paper: the beads move together as a block, their paths being ellipses, and nothing is "
    "transported."
)

draw, select, notes = moving_belt.draw, moving_belt.select, moving_belt.notes
