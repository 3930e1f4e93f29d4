"""Walton (1993), Fig. 1.2: profiles and configuration of a flow of depth 2.5."""

from sim.figures import chute_row

LEAD = chute_row.lead(2.5)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: the velocity of flows this shallow rises monotonically with height; below this "
    "depth the density falls monotonically with height, above it has a maximum inside the flow."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
