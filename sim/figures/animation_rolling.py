"""Animation: a flow of little more than one sphere per σ²."""

from sim.figures import moving_chute

LEAD = moving_chute.lead("A flow of little more than one sphere per σ²")
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: with between one and two particles per σ² the flow is steady and slower than at "
    "other depths, and its density falls with height."
)

draw, select, notes = moving_chute.draw, moving_chute.select, moving_chute.notes
