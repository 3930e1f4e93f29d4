"""Walton (1993), Fig. 1.5: profiles and configuration of a flow of depth 20."""

from sim.figures import chute_row

LEAD = chute_row.lead(20)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: an almost uniformly dense, crystalline region without shear rides over a thin "
    "layer that shears and is less dense; the layer tends to be thinner the deeper the flow."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
