"""Animation: a deep flow."""

from sim.figures import moving_chute

LEAD = moving_chute.lead("A deep flow")
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: deeper flows often have a region without shear, here crystalline, that rides "
    "over a relatively thin layer that shears."
)

draw, select, notes = moving_chute.draw, moving_chute.select, moving_chute.notes
