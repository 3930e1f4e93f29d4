"""Animation: shaking just above the onset."""

from sim.figures import moving_belt

LEAD = moving_belt.lead("Shaking just above the onset")
NAMED = moving_belt.NAMED
PAPER = "The paper: the paths are almost sinusoidal and the beads drift along the belt."

draw, select, notes = moving_belt.draw, moving_belt.select, moving_belt.notes
