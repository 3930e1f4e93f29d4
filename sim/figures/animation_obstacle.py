"""Animation: shaking far above the onset with a fixed obstacle on the belt."""

from sim.figures import moving_belt

LEAD = moving_belt.lead("Shaking far above the onset with a fixed obstacle on the belt")
NAMED = moving_belt.NAMED
PAPER = (
    "The paper: the obstacle slows the whole flow without any turbulence, and the paths look "
    "rather like those at much lower frequencies without it."
)

draw, select, notes = moving_belt.draw, moving_belt.select, moving_belt.notes
